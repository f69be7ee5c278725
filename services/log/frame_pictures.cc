#include "services/log/frame_pictures.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <vector>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/picture/cloud_view.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/quality/score.h"

namespace sprout::log {
namespace {

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

// Every ToF point as a seed, before refinement; nothing without a ToF image that fits the
// calibration.
std::optional<std::vector<Seed>> RawSeeds(const Frame& frame) {
  if (!frame.tof || frame.tof->depth_m.empty() || !frame.rig) return std::nullopt;
  const Rig rig = RigOfFrame(*frame.rig, *frame.tof);
  if (!CheckTofSize(rig, *frame.tof)) return std::nullopt;
  int behind = 0;
  std::vector<Seed> seeds;
  for (const ProjectedPoint& point : TofProjector(rig).Project(*frame.tof, behind)) {
    seeds.push_back(point.seed);
  }
  return seeds;
}

// Four pictures in two rows, all as high as the first; wide ones keep their shape.
cv::Mat3b Overview(const std::array<cv::Mat3b, 4>& pictures) {
  const int height = pictures[0].rows;
  std::array<cv::Mat3b, 4> scaled;
  for (size_t i = 0; i < pictures.size(); ++i) {
    const double scale = static_cast<double>(height) / pictures[i].rows;
    cv::resize(pictures[i], scaled[i], {cvRound(pictures[i].cols * scale), height}, 0, 0,
               cv::INTER_AREA);
  }
  const int left_width = std::max(scaled[0].cols, scaled[2].cols);
  const int right_width = std::max(scaled[1].cols, scaled[3].cols);
  cv::Mat3b overview(2 * height, left_width + right_width, cv::Vec3b(255, 255, 255));
  for (size_t i = 0; i < scaled.size(); ++i) {
    const cv::Point corner(i % 2 == 0 ? 0 : left_width, i < 2 ? 0 : height);
    scaled[i].copyTo(overview(cv::Rect(corner, scaled[i].size())));
  }
  return overview;
}

// The pictures of one frame, each written as soon as it is made.
class FramePictures {
 public:
  FramePictures(const Frame& frame, FrameFileNames& names)
      : frame_(frame),
        names_(names),
        title_(fmt::format(", frame {}", frame.id.seq)),
        size_(CameraSize(frame)),
        range_px_(RangeOf(frame)),
        pair_(frame.rig ? &frame.rig->pair : nullptr) {}

  void WriteCameras() {
    if (!frame_.left.empty())
      left_ = Write("left.png", CameraPicture(frame_.left, T("Left image")));
    if (!frame_.right.empty()) Write("right.png", CameraPicture(frame_.right, T("Right image")));
    if (frame_.tof && (!size_.empty() || !frame_.tof->depth_m.empty())) {
      tof_ = Write("tof.png",
                   DepthPicture(*frame_.tof, size_.empty() ? frame_.tof->depth_m.size() : size_,
                                RangeOfDepth(frame_, range_px_), T("ToF depth")));
    }
  }

  void WriteSeeds() {
    if (size_.empty()) return;
    if (const auto raw = RawSeeds(frame_)) Write("seeds_raw.png", Seeds(*raw, "ToF points"));
    if (frame_.seeds) Write("seeds.png", Seeds(frame_.seeds->seeds, "Seeds"));
  }

  void WriteMaps() {
    const auto map = [&](const char* what, const std::optional<DisparityImage>& disparity,
                         const char* name) -> cv::Mat3b {
      if (!disparity) return {};
      return Write(what, DisparityPicture(*disparity, range_px_, T(name), pair_));
    };
    map("prior.png", PriorOf(frame_), "Prior disparity");
    if (frame_.prior) {
      Write("prior_sigma.png", SigmaPicture(*frame_.prior, T("Standard deviation of the prior")));
    }
    map("unfilled.png", frame_.unfilled, "Disparity as grown");
    disparity_ = map("disparity.png", frame_.disparity, "Disparity");
    if (!frame_.confidence.empty()) {
      Write("confidence.png", ConfidencePicture(frame_.confidence, T("Confidence")));
    }
  }

  // What needs several parts.
  void WriteScene() {
    if (!HasCloud(frame_)) return;
    const cv::Mat3b cloud =
        Write("cloud.png", CameraPicture(CloudView(*pair_, *frame_.disparity, frame_.left),
                                         T("Point cloud from the side")));
    if (tof_.empty()) return;
    Write("overview.png", Overview({left_, tof_, disparity_, cloud}));
  }

  void WriteErrors(const FrameTruth& truth) {
    if (truth.disparity_px.empty() || !frame_.disparity) return;
    Write("errors.png",
          ErrorPicture(ErrorMap(ToPx(*frame_.disparity), truth.disparity_px, truth.non_occluded),
                       T("Error of the disparity")));
  }

 private:
  std::string T(const char* name) const { return name + title_; }

  cv::Mat3b Seeds(const std::vector<Seed>& seeds, const char* name) const {
    // A log without images shows its seeds on black.
    const cv::Mat left = frame_.left.empty() ? cv::Mat(cv::Mat1b::zeros(size_)) : frame_.left;
    return SeedPicture(ToGrey(left), seeds, range_px_,
                       fmt::format("{} ({}){}", name, seeds.size(), title_), pair_);
  }

  cv::Mat3b Write(const char* what, cv::Mat3b picture) {
    const Result<void> written = WritePng(names_.Of(frame_.id, what), picture);
    if (!written) throw std::runtime_error(written.error().text);
    return picture;
  }

  const Frame& frame_;
  FrameFileNames& names_;
  std::string title_;
  cv::Size size_;
  ValueRange range_px_;
  const RectifiedPair* pair_;
  cv::Mat3b left_, tof_, disparity_;
};

}  // namespace

bool HasCloud(const Frame& frame) {
  if (!frame.disparity || frame.left.empty() || !frame.rig) return false;
  const cv::Size size = frame.disparity->size();
  return frame.left.size() == size && frame.rig->pair.size() == size;
}

void WriteFramePictures(const Frame& frame, const FrameTruth& truth, FrameFileNames& names) {
  FramePictures pictures(frame, names);
  pictures.WriteCameras();
  pictures.WriteSeeds();
  pictures.WriteMaps();
  pictures.WriteScene();
  pictures.WriteErrors(truth);
}

}  // namespace sprout::log
