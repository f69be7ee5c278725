// sprout-log export: the frames of a log for other programs.
#include <fmt/core.h>

#include <cctype>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/app/output_paths.h"
#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/prior_map.h"
#include "common/geometry/projection.h"
#include "common/picture/frame_pictures.h"
#include "common/picture/write_image.h"
#include "common/picture/write_npz.h"
#include "common/picture/write_ply.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/log_frames.h"
#include "services/tools/log/print_line.h"

namespace sprout::log {
namespace {

struct ExportOptions : PicturesOptions {
  bool ply = false;
  bool mesh = false;
  bool pfm = false;
  bool depth = false;
  bool npz = false;
  std::string mcap;
  bool force_mcap = false;
};

// Depth of a frame, and the camera that sees it.
struct Depth {
  cv::Mat1f metres;  // NaN: none
  double focal_px, cx, cy;
  std::optional<double> baseline_m;
};

// Depth of the disparities, which have the resolution of the images, else that of SPROUT_DEPTH.
std::optional<Depth> DepthOf(const Frame& frame) {
  if (frame.disparity && frame.rig && frame.rig->pair.size() == frame.disparity->size()) {
    const RectifiedPair& pair = frame.rig->pair;
    return Depth{DepthMap(pair, *frame.disparity), pair.focal_px, pair.cx, pair.cy,
                 pair.baseline_m};
  }
  if (!frame.depth) return std::nullopt;
  const DepthImage& depth = *frame.depth;
  cv::Mat1f metres;
  depth.counts.convertTo(metres, CV_32F, depth.metres_per_count);
  metres.setTo(std::numeric_limits<float>::quiet_NaN(), depth.counts == 0);
  return Depth{metres, depth.focal_px, depth.cx, depth.cy, std::nullopt};
}

cv::Mat1f PxOf(const DisparityImage& disparity) {
  cv::Mat1f px = ToPx(disparity);
  px.setTo(std::numeric_limits<float>::infinity(), disparity.counts() == DisparityImage::kInvalid);
  return px;
}

// Empty when there is none that fits the map.
cv::Mat ConfidenceOf(const Frame& frame) {
  const cv::Mat& confidence = frame.confidence;
  const bool fits = frame.disparity && confidence.size() == frame.disparity->size() &&
                    confidence.type() == CV_8UC1;
  return fits ? confidence : cv::Mat();
}

// A rig_id is any text of a message.
std::string FileNameOf(std::string text) {
  for (char& letter : text) {
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0) letter = '_';
  }
  return text.substr(0, 40);
}

// Writes what export was asked for, and counts the frames that have no cloud.
class Exporter {
 public:
  explicit Exporter(const ExportOptions& options) : options_(options), names_(options.folder) {}

  const FrameFileNames& names() const { return names_; }

  PartSet Parts() const {
    PartSet parts{Part::kDisparity};
    const auto add = [&](bool is_wanted, std::initializer_list<Part> more) {
      for (const Part part : more) {
        if (is_wanted) parts.Add(part);
      }
    };
    add(options_.pfm, {Part::kPrior, Part::kUnfilled, Part::kSigma});
    add(WantsCloud(), {Part::kLeft, Part::kRig, Part::kConfidence});
    add(options_.depth || options_.npz, {Part::kRig, Part::kDepth});
    add(options_.npz, {Part::kConfidence});
    return parts;
  }

  void Write(const Frame& frame) {
    if (options_.pfm) {
      if (frame.prior) WriteMap(frame, frame.prior->disparity, "prior.pfm");
      if (frame.unfilled) WriteMap(frame, *frame.unfilled, "unfilled.pfm");
      if (frame.disparity) WriteMap(frame, *frame.disparity, "disparity.pfm");
      if (frame.sigma.type() == CV_8UC1 && !frame.sigma.empty()) {
        RequireWritten(
            WritePfm(names_.Of(frame.id, "sigma.pfm"), SigmaToPx(cv::Mat1b(frame.sigma))));
      }
    }
    if (WantsCloud() && frame.disparity) WriteCloud(frame);
    if (options_.depth || options_.npz) WriteDepth(frame);
  }

  // @returns whether all frames that could have a cloud have one.
  bool Complain() const {
    if (without_cloud_ > 0) {
      PrintWarning(
          fmt::format("no cloud of {} frames: a cloud needs disparity, left image and calibration",
                      without_cloud_));
    }
    if (without_depth_ > 0) {
      PrintWarning(fmt::format(
          "no depth of {} frames: a depth needs disparity and calibration, or SPROUT_DEPTH",
          without_depth_));
    }
    if (misfits_ > 1) {
      PrintWarning(fmt::format("no cloud of {} frames that differ in size", misfits_));
    }
    return misfits_ == 0;
  }

 private:
  bool WantsCloud() const { return options_.ply || options_.mesh; }

  void WriteMap(const Frame& frame, const DisparityImage& map, const char* what) {
    RequireWritten(WritePfm(names_.Of(frame.id, what), map));
  }

  void WriteCloud(const Frame& frame) {
    if (frame.left.empty() || !frame.rig) {
      ++without_cloud_;
      return;
    }
    const RectifiedPair& pair = frame.rig->pair;
    if (!HasCloud(frame)) {
      if (misfits_++ > 0) return;
      PrintWarning(fmt::format(
          "no cloud of frame {}: disparity map {}, left image {} and calibration {} differ in size",
          frame.id.seq, SizeText(frame.disparity->size()), SizeText(frame.left.size()),
          SizeText(pair.size())));
      return;
    }
    if (options_.ply) {
      RequireWritten(WriteCloudPly(names_.Of(frame.id, "cloud.ply"), pair, *frame.disparity,
                                   frame.left, ConfidenceOf(frame)));
    }
    if (options_.mesh) {
      RequireWritten(WriteMeshPly(names_.Of(frame.id, "mesh.ply"), pair, *frame.disparity,
                                  frame.left, ConfidenceOf(frame)));
    }
  }

  void WriteDepth(const Frame& frame) {
    const std::optional<Depth> depth = DepthOf(frame);
    if (!depth) {
      ++without_depth_;
      return;
    }
    if (options_.depth) {
      RequireWritten(WriteDepthPng(names_.Of(frame.id, "depth.png"), depth->metres));
      WriteIntrinsics(frame.id.rig_id, *depth);
    }
    if (!options_.npz) return;
    const double k[] = {depth->focal_px, 0, depth->cx, 0, depth->focal_px, depth->cy, 0, 0, 1};
    std::vector<NpzArray> arrays = {NpzOf("depth_m", depth->metres), NpzOf("K", k, {3, 3}),
                                    NpzOf("utime", frame.id.utime), NpzOf("seq", frame.id.seq)};
    if (frame.disparity) arrays.push_back(NpzOf("disparity_px", PxOf(*frame.disparity)));
    if (const cv::Mat confidence = ConfidenceOf(frame); !confidence.empty()) {
      arrays.push_back(NpzOf("confidence", confidence));
    }
    RequireWritten(WriteNpz(names_.Of(frame.id, "depth.npz"), arrays));
  }

  // Writes the intrinsics once for each calibration; those of the first one are intrinsics.json.
  void WriteIntrinsics(const std::string& rig_id, const Depth& depth) {
    if (!known_rigs_.insert(rig_id).second) return;
    nlohmann::ordered_json json{{"width", depth.metres.cols},
                                {"height", depth.metres.rows},
                                {"fx", depth.focal_px},
                                {"fy", depth.focal_px},
                                {"cx", depth.cx},
                                {"cy", depth.cy}};
    if (depth.baseline_m) json["baseline_m"] = *depth.baseline_m;
    json["rig_id"] = rig_id;
    const std::string name =
        known_rigs_.size() == 1 ? "intrinsics.json" : "intrinsics_" + FileNameOf(rig_id) + ".json";
    constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
    WriteWhole(options_.folder / name, json.dump(2, ' ', false, kReplace) + "\n");
  }

  const ExportOptions& options_;
  FrameFileNames names_;
  std::set<std::string> known_rigs_;
  int64_t without_depth_ = 0;
  int64_t without_cloud_ = 0;
  int64_t misfits_ = 0;
};

int RunExport(const ExportOptions& options) {
  if (!options.ply && !options.mesh && !options.pfm && !options.depth && !options.npz) {
    throw ConfigError("export: nothing to do without --ply, --mesh, --pfm, --depth or --npz");
  }
  Exporter exporter(options);
  const std::string complaint =
      ReadFrames(options, exporter.Parts(), [&](const Frame& frame) { exporter.Write(frame); });
  const bool whole = exporter.Complain();
  FinishFiles(complaint, exporter.names(), options,
              "no message of these frames that can be exported");
  return whole ? 0 : 1;
}

int RunEitherExport(const ExportOptions& options) {
  if (!options.mcap.empty()) return RunMcapExport(options, options.mcap, options.force_mcap);
  if (options.folder.empty()) throw ConfigError("DIR is required (--help lists the flags)");
  return RunExport(options);
}

}  // namespace

void AddExport(Flags& program) {
  const auto options = std::make_shared<ExportOptions>();
  Flags& flags = program.AddCommand("export",
                                    "Writes each frame for other programs, or with --mcap "
                                    "all of a log as ROS 2's messages",
                                    [options] { return RunEitherExport(*options); });
  flags.Add("FILE", options->file, "Log").Required();
  const Flag folder =
      flags.Add("DIR", options->folder, "Folder to write to: 000042_disparity.pfm, ...");
  flags.Add("--ply", options->ply,
            "Coloured point cloud of the disparity map, m in the left rectified frame, each point "
            "with its confidence if the log has it");
  flags.Add("--mesh", options->mesh,
            "Coloured surface of the disparity map, cut at depth edges, m");
  flags.Add("--pfm", options->pfm, "Prior and disparity maps, px; +inf: no disparity; sigma, px");
  flags.Add("--depth", options->depth,
            "Depth as PNG of 16 bits, mm, 0: none or more than 65.535 m; and intrinsics.json");
  flags.Add(
      "--npz", options->npz,
      "For NumPy: depth_m (m, NaN: none), disparity_px, confidence (0 to 255), K, utime, seq");
  flags
      .Add("--mcap OUT", options->mcap,
           "One MCAP file for rosbag2, Foxglove and rerun: the images, depth, points, "
           "disparities and statuses of the log on the topics of sprout-ros2")
      .Excludes(folder);
  AddForce(flags, options->force_mcap);
  AddFrames(flags, options->frames);
  AddPrefix(flags, options->prefix);
}

}  // namespace sprout::log
