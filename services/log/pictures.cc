// The subcommands that write the frames of a log as files: images and export.
#include <fmt/format.h>

#include <iostream>
#include <optional>
#include <stdexcept>
#include <vector>

#include "common/config/config.h"
#include "common/core/image.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "services/log/frame_pictures.h"

namespace sprout {
namespace {

void Require(const Result<void>& written) {
  if (!written) throw std::runtime_error(written.error().text);
}

std::optional<DisparityImage> PriorOf(const Frame& frame) {
  if (!frame.prior) return std::nullopt;
  return frame.prior->disparity;
}

// The maps of a frame and its seeds share one scale.
ValueRange RangeOf(const Frame& frame) {
  std::vector<DisparityImage> maps;
  for (const auto& map : {PriorOf(frame), frame.unfilled, frame.disparity}) {
    if (map) maps.push_back(*map);
  }
  return DisparityRange(maps, frame.seeds ? frame.seeds->seeds : std::vector<Seed>());
}

// The depths of those disparities, so that near has one colour in all pictures; that of the ToF
// image alone where nothing says which disparity a depth has.
ValueRange RangeOfDepth(const Frame& frame, const ValueRange& range_px) {
  if (!frame.rig || !(frame.seeds || frame.prior || frame.disparity || frame.unfilled)) {
    return DepthRange(*frame.tof);
  }
  const std::optional<ValueRange> in_front = InFront(frame.rig->pair, range_px);
  return in_front ? DepthRange(frame.rig->pair, *in_front) : DepthRange(*frame.tof);
}

// The size of the images that the frame was captured with, as far as it is known: a calibration may
// claim 100 MP in a few bytes, so it is asked last. Empty when nothing says it.
cv::Size CameraSize(const Frame& frame) {
  for (const cv::Mat& image : {frame.left, frame.right, frame.confidence}) {
    if (!image.empty()) return image.size();
  }
  for (const auto& map : {frame.disparity, frame.unfilled, PriorOf(frame)}) {
    if (map) return map->size();
  }
  return frame.rig ? frame.rig->pair.size() : cv::Size();
}

}  // namespace

void WriteFramePictures(const Frame& frame, FrameFileNames& names) {
  const std::string title = fmt::format(", frame {}", frame.id.seq);
  const auto write = [&](const char* what, const cv::Mat& picture) {
    Require(WritePng(names.Of(frame.id, what), picture));
  };
  if (!frame.left.empty()) write("left.png", CameraPicture(frame.left, "Left image" + title));
  if (!frame.right.empty()) write("right.png", CameraPicture(frame.right, "Right image" + title));
  const cv::Size size = CameraSize(frame);
  const ValueRange range_px = RangeOf(frame);
  const RectifiedPair* pair = frame.rig ? &frame.rig->pair : nullptr;
  if (frame.tof && (!size.empty() || !frame.tof->depth_m.empty())) {
    write("tof.png", DepthPicture(*frame.tof, size.empty() ? frame.tof->depth_m.size() : size,
                                  RangeOfDepth(frame, range_px), "ToF depth" + title));
  }
  if (frame.seeds && !size.empty()) {
    // A log without images shows its seeds on black.
    const cv::Mat left = frame.left.empty() ? cv::Mat(cv::Mat1b::zeros(size)) : frame.left;
    write("seeds.png",
          SeedPicture(ToGrey(left), frame.seeds->seeds, range_px,
                      fmt::format("Seeds ({}){}", frame.seeds->seeds.size(), title), pair));
  }
  const auto write_map = [&](const char* what, const std::optional<DisparityImage>& map,
                             const char* name) {
    if (map) write(what, DisparityPicture(*map, range_px, name + title, pair));
  };
  write_map("prior.png", PriorOf(frame), "Prior disparity");
  if (frame.prior) {
    write("prior_sigma.png", SigmaPicture(*frame.prior, "Standard deviation of the prior" + title));
  }
  write_map("unfilled.png", frame.unfilled, "Disparity as grown");
  write_map("disparity.png", frame.disparity, "Disparity");
  if (!frame.confidence.empty()) {
    write("confidence.png", ConfidencePicture(frame.confidence, "Confidence" + title));
  }
}

namespace {

bool HasOneSize(const Frame& frame) {
  const cv::Size size = frame.disparity->size();
  return frame.left.size() == size && frame.rig->pair.size() == size;
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

int RunImages(const PicturesOptions& options) {
  FrameFileNames names(options.folder);
  const std::string complaint = ReadFrames(
      options, AllParts(), [&](const Frame& frame) { WriteFramePictures(frame, names); });
  Finish(complaint, names, options, "no message of these frames that can be shown");
  return 0;
}

int RunExport(const ExportOptions& options) {
  if (!options.ply && !options.pfm)
    throw ConfigError("export: nothing to do without --ply or --pfm");
  FrameFileNames names(options.folder);
  int64_t without_cloud = 0;
  int64_t misfits = 0;
  const PartSet parts = options.ply ? PartSet{Part::kLeft, Part::kRig, Part::kPrior,
                                              Part::kUnfilled, Part::kDisparity}
                                    : PartSet{Part::kPrior, Part::kUnfilled, Part::kDisparity};
  const auto write_pfm = [&](const Frame& frame, const std::optional<DisparityImage>& map,
                             const char* what) {
    if (options.pfm && map) Require(WritePfm(names.Of(frame.id, what), *map));
  };
  const std::string complaint = ReadFrames(options, parts, [&](const Frame& frame) {
    write_pfm(frame, PriorOf(frame), "prior.pfm");
    write_pfm(frame, frame.unfilled, "unfilled.pfm");
    write_pfm(frame, frame.disparity, "disparity.pfm");
    if (!options.ply || !frame.disparity) return;
    if (frame.left.empty() || !frame.rig) {
      ++without_cloud;
      return;
    }
    if (!HasOneSize(frame)) {
      if (misfits++ == 0) {
        std::cerr << fmt::format(
            "sprout-log: no cloud of frame {}: disparity map {}, left image {} and calibration {} "
            "differ in size\n",
            frame.id.seq, SizeText(frame.disparity->size()), SizeText(frame.left.size()),
            SizeText(frame.rig->pair.size()));
      }
      return;
    }
    Require(WriteCloudPly(names.Of(frame.id, "cloud.ply"), frame.rig->pair, *frame.disparity,
                          frame.left));
  });
  if (without_cloud > 0) {
    std::cerr << fmt::format(
        "sprout-log: no cloud of {} frames: a cloud needs disparity, left image "
        "and calibration\n",
        without_cloud);
  }
  if (misfits > 1) {
    std::cerr << fmt::format("sprout-log: no cloud of {} frames that differ in size\n", misfits);
  }
  Finish(complaint, names, options, "no message of these frames that can be exported");
  return misfits > 0 ? 1 : 0;
}

}  // namespace sprout
