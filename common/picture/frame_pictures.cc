#include "common/picture/frame_pictures.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/geometry/projection.h"
#include "common/measure/score.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"

namespace sprout {
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
cv::Mat3b FourOf(const std::array<cv::Mat3b, 4>& pictures) {
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

// The pictures of one frame, each shown as soon as it is made.
class FramePictures {
 public:
  using Show = std::function<void(const char* what, const cv::Mat3b& picture)>;

  FramePictures(const Frame& frame, Show show)
      : frame_(frame),
        show_(std::move(show)),
        title_(frame.id.seq < 0 ? "" : fmt::format(", frame {}", frame.id.seq)),
        size_(CameraSize(frame)),
        range_px_(RangeOf(frame)),
        pair_(frame.rig ? &frame.rig->pair : nullptr) {}

  void ShowCameras() {
    if (!frame_.left.empty()) left_ = Made("left.png", Left());
    if (!frame_.right.empty()) Made("right.png", Right());
    if (frame_.tof && (!size_.empty() || !frame_.tof->depth_m.empty())) {
      tof_ = Made("tof.png", Tof());
    }
  }

  void ShowSeeds() {
    if (size_.empty()) return;
    if (const auto raw = RawSeeds(frame_)) Made("seeds_raw.png", Seeds(*raw, "ToF points"));
    if (frame_.seeds) Made("seeds.png", Seeds(frame_.seeds->seeds, "Seeds"));
  }

  void ShowMaps() {
    const auto map = [&](const char* what, const std::optional<DisparityImage>& disparity,
                         const char* name) -> cv::Mat3b {
      if (!disparity) return {};
      return Made(what, Disparity(*disparity, name));
    };
    map("prior.png", PriorOf(frame_), "Prior disparity");
    if (frame_.prior) {
      Made("prior_sigma.png", SigmaPicture(*frame_.prior, T("Standard deviation of the prior")));
    }
    map("unfilled.png", frame_.unfilled, "Disparity as grown");
    disparity_ = map("disparity.png", frame_.disparity, "Disparity");
    if (!frame_.confidence.empty()) {
      Made("confidence.png", ConfidencePicture(frame_.confidence, T("Confidence")));
    }
    if (frame_.disparity && frame_.disparity->size() == frame_.sigma.size() &&
        frame_.sigma.type() == CV_8UC1) {
      Made("sigma.png", SigmaPicture(PriorMap(*frame_.disparity, frame_.sigma),
                                     T("Standard deviation of the disparity")));
    }
  }

  // The pictures that need several parts.
  void ShowScene() {
    if (!HasCloud(frame_)) return;
    const cv::Mat3b cloud = Made("cloud.png", Cloud());
    if (tof_.empty()) return;
    Made("overview.png", FourOf({left_, tof_, disparity_, cloud}));
  }

  cv::Mat3b Overview() const {
    const bool has_tof = frame_.tof && !frame_.tof->depth_m.empty();
    return FourOf(
        {Left(), has_tof ? Tof() : Right(), Disparity(*frame_.disparity, "Disparity"), Cloud()});
  }

  void ShowErrors(const FrameTruth& truth) {
    if (truth.disparity_px.empty() || !frame_.disparity) return;
    Made("errors.png",
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

  cv::Mat3b Left() const { return CameraPicture(frame_.left, T("Left image")); }

  cv::Mat3b Right() const { return CameraPicture(frame_.right, T("Right image")); }

  cv::Mat3b Tof() const {
    return DepthPicture(*frame_.tof, size_.empty() ? frame_.tof->depth_m.size() : size_,
                        RangeOfDepth(frame_, range_px_), T("ToF depth"));
  }

  cv::Mat3b Disparity(const DisparityImage& map, const char* name) const {
    return DisparityPicture(map, range_px_, T(name), pair_);
  }

  cv::Mat3b Cloud() const {
    return CameraPicture(CloudView(*pair_, *frame_.disparity, frame_.left),
                         T("Point cloud from the side"));
  }

  cv::Mat3b Made(const char* what, cv::Mat3b picture) const {
    show_(what, picture);
    return picture;
  }

  const Frame& frame_;
  Show show_;
  std::string title_;
  cv::Size size_;
  ValueRange range_px_;
  const RectifiedPair* pair_;
  cv::Mat3b left_, tof_, disparity_;
};

constexpr double kYaw = 0.35;     // rad to the right
constexpr double kPitch = -0.20;  // rad, negative: up

// Drawn at a third of the size: neighbouring points then touch, also where the new view
// stretches a surface.
constexpr int kReduction = 3;

struct ColoredPoint {
  Eigen::Vector3d in_left;
  cv::Vec3b color;
};

std::vector<ColoredPoint> Points(const RectifiedPair& pair, const DisparityImage& disparity,
                                 const cv::Mat& left) {
  const cv::Mat3b bgr = ToBgr(left);
  std::vector<ColoredPoint> points;
  points.reserve(disparity.counts().total());
  for (int v = 0; v < disparity.height(); ++v) {
    for (int u = 0; u < disparity.width(); ++u) {
      if (!disparity.IsValid(u, v)) continue;
      const Eigen::Vector3d point = PointAt(pair, disparity, u, v);
      if (point.z() > 0 && point.allFinite()) points.push_back({point, bgr(v, u)});
    }
  }
  return points;
}

double MedianDepth(const std::vector<ColoredPoint>& points) {
  std::vector<double> depths;
  for (const ColoredPoint& point : points) depths.push_back(point.in_left.z());
  return Median(depths);
}

}  // namespace

bool HasCloud(const Frame& frame) {
  if (!frame.disparity || frame.left.empty() || !frame.rig) return false;
  const cv::Size size = frame.disparity->size();
  return frame.left.size() == size && frame.rig->pair.size() == size;
}

void WriteFramePictures(const Frame& frame, const FrameTruth& truth,
                        const std::function<std::filesystem::path(const char* what)>& path_of) {
  FramePictures pictures(frame, [&](const char* what, const cv::Mat3b& picture) {
    RequireWritten(WritePng(path_of(what), picture));
  });
  pictures.ShowCameras();
  pictures.ShowSeeds();
  pictures.ShowMaps();
  pictures.ShowScene();
  pictures.ShowErrors(truth);
}

cv::Mat3b OverviewOf(const Frame& frame) {
  return FramePictures(frame, [](const char*, const cv::Mat3b&) {}).Overview();
}

cv::Mat3b CloudView(const RectifiedPair& pair, const DisparityImage& disparity,
                    const cv::Mat& left) {
  assert(disparity.size() == left.size());
  const cv::Size size((left.cols + kReduction - 1) / kReduction,
                      (left.rows + kReduction - 1) / kReduction);
  cv::Mat3b view(size, kNoValueColor);
  const std::vector<ColoredPoint> points = Points(pair, disparity, left);
  if (points.empty()) return view;

  // The camera turns around a point in the middle of the scene and steps back a little.
  const Eigen::Vector3d center(0, 0, MedianDepth(points));
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(kPitch, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(kYaw, Eigen::Vector3d::UnitY()))
                                       .toRotationMatrix();
  const Eigen::Vector3d new_center = 1.15 * center;
  const double focal = pair.focal_px / kReduction;
  cv::Mat1d nearest(size, std::numeric_limits<double>::infinity());
  for (const ColoredPoint& point : points) {
    const Eigen::Vector3d seen = rotation * (point.in_left - center) + new_center;
    if (seen.z() <= 0) continue;
    const double u = focal * seen.x() / seen.z() + size.width / 2.0;
    const double v = focal * seen.y() / seen.z() + size.height / 2.0;
    if (!(u >= 0 && u < size.width && v >= 0 && v < size.height)) continue;
    const cv::Point pixel(static_cast<int>(u), static_cast<int>(v));
    if (seen.z() >= nearest(pixel)) continue;
    nearest(pixel) = seen.z();
    view(pixel) = point.color;
  }
  cv::Mat3b enlarged;
  cv::resize(view, enlarged, left.size(), 0, 0, cv::INTER_CUBIC);
  return enlarged;
}

}  // namespace sprout
