// The subcommands that write the frames of a log as files: images and export.
#include <fmt/core.h>

#include <iostream>
#include <stdexcept>
#include <string>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/prior_map.h"
#include "common/logfile/log_error.h"
#include "common/picture/frame_pictures.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "services/log/commands.h"
#include "services/log/frame_truth.h"
#include "services/log/log_frames.h"

namespace sprout::log {
namespace {

void Require(const Result<void>& written) {
  if (!written) throw std::runtime_error(written.error().text);
}

void Finish(const std::string& complaint, const FrameFileNames& names,
            const PicturesOptions& options, const std::string& nothing) {
  if (names.files() == 0) {
    throw LogError(options.file, nothing + (complaint.empty() ? "" : "; " + complaint));
  }
  if (!complaint.empty()) std::cerr << "sprout-log: " << complaint << "\n";
  std::cout << fmt::format("{}: {} files of {} frames\n", options.folder.string(), names.files(),
                           names.frames());
}

}  // namespace

int RunImages(const ImagesOptions& options) {
  LogTruth truth(options.truth);
  FrameFileNames names(options.folder);
  const std::string complaint = ReadFrames(options, AllParts(), [&](const Frame& frame) {
    WriteFramePictures(frame, truth.Add(frame), names.For(frame.id));
  });
  Finish(complaint, names, options, "no message of these frames that can be shown");
  std::cout << truth.Text();
  return 0;
}

namespace {

// Writes what export was asked for, and counts the frames that have no cloud.
class Exporter {
 public:
  explicit Exporter(const ExportOptions& options) : options_(options), names_(options.folder) {}

  const FrameFileNames& names() const { return names_; }

  PartSet Parts() const {
    PartSet parts{Part::kPrior, Part::kUnfilled, Part::kDisparity};
    if (options_.pfm) parts.Add(Part::kSigma);
    if (WantsCloud()) {
      parts.Add(Part::kLeft);
      parts.Add(Part::kRig);
    }
    return parts;
  }

  void Write(const Frame& frame) {
    if (options_.pfm) {
      if (frame.prior) WriteMap(frame, frame.prior->disparity, "prior.pfm");
      if (frame.unfilled) WriteMap(frame, *frame.unfilled, "unfilled.pfm");
      if (frame.disparity) WriteMap(frame, *frame.disparity, "disparity.pfm");
      if (frame.sigma.type() == CV_8UC1 && !frame.sigma.empty()) {
        Require(WritePfm(names_.Of(frame.id, "sigma.pfm"), SigmaToPx(cv::Mat1b(frame.sigma))));
      }
    }
    if (WantsCloud() && frame.disparity) WriteCloud(frame);
  }

  // @returns whether all frames that could have a cloud have one.
  bool Complain() const {
    if (without_cloud_ > 0) {
      std::cerr << fmt::format(
          "sprout-log: no cloud of {} frames: a cloud needs disparity, left image "
          "and calibration\n",
          without_cloud_);
    }
    if (misfits_ > 1) {
      std::cerr << fmt::format("sprout-log: no cloud of {} frames that differ in size\n", misfits_);
    }
    return misfits_ == 0;
  }

 private:
  bool WantsCloud() const { return options_.ply || options_.mesh; }

  void WriteMap(const Frame& frame, const DisparityImage& map, const char* what) {
    Require(WritePfm(names_.Of(frame.id, what), map));
  }

  void WriteCloud(const Frame& frame) {
    if (frame.left.empty() || !frame.rig) {
      ++without_cloud_;
      return;
    }
    const RectifiedPair& pair = frame.rig->pair;
    if (!HasCloud(frame)) {
      if (misfits_++ > 0) return;
      std::cerr << fmt::format(
          "sprout-log: no cloud of frame {}: disparity map {}, left image {} and calibration {} "
          "differ in size\n",
          frame.id.seq, SizeText(frame.disparity->size()), SizeText(frame.left.size()),
          SizeText(pair.size()));
      return;
    }
    if (options_.ply) {
      Require(WriteCloudPly(names_.Of(frame.id, "cloud.ply"), pair, *frame.disparity, frame.left));
    }
    if (options_.mesh) {
      Require(WriteMeshPly(names_.Of(frame.id, "mesh.ply"), pair, *frame.disparity, frame.left));
    }
  }

  const ExportOptions& options_;
  FrameFileNames names_;
  int64_t without_cloud_ = 0;
  int64_t misfits_ = 0;
};

}  // namespace

int RunExport(const ExportOptions& options) {
  if (!options.ply && !options.mesh && !options.pfm) {
    throw ConfigError("export: nothing to do without --ply, --mesh or --pfm");
  }
  Exporter exporter(options);
  const std::string complaint =
      ReadFrames(options, exporter.Parts(), [&](const Frame& frame) { exporter.Write(frame); });
  const bool whole = exporter.Complain();
  Finish(complaint, exporter.names(), options, "no message of these frames that can be exported");
  return whole ? 0 : 1;
}

}  // namespace sprout::log
