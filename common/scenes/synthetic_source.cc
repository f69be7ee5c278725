#include <algorithm>
#include <cassert>
#include <limits>
#include <optional>
#include <vector>

#include "common/scenes/lens_view.h"
#include "common/scenes/source_options.h"
#include "common/scenes/sr4000.h"
#include "common/scenes/synthetic_scene.h"
#include "common/scenes/tof_grid.h"
#include "common/scenes/zone_sensor.h"

namespace sprout::scenes {
namespace {

constexpr double kFocalPerWidth = 0.9;    // 58° from left to right
constexpr double kSceneBaselineM = 0.2;   // disparities of 2 to 15 % of the width
constexpr double kOffsetPerWidth = 0.01;  // cx_right − cx: code that takes it for 0 shall show
constexpr double kNearestFloorM = 1.6;    // depth of the floor at the bottom of the image

// A disparity image ends at 1023 px; from this width on the baseline shrinks instead.
constexpr double kWidestFullBaselinePx = 6000;

RectifiedPair PairOfSize(cv::Size size) {
  const double shrink = std::min(1.0, kWidestFullBaselinePx / size.width);
  RectifiedPair pair{.width = size.width, .height = size.height};
  pair.focal_px = kFocalPerWidth * size.width;
  pair.cx = (size.width - 1) / 2.0;
  pair.cy = (size.height - 1) / 2.0;
  pair.cx_right = pair.cx + shrink * kOffsetPerWidth * size.width;
  pair.baseline_m = shrink * kSceneBaselineM;
  return pair;
}

// One camera of the pair: the left one at the origin, the right one at (baseline, 0, 0).
struct Eye {
  double focal_px;
  double cx;
  double cy;
  double x_m;

  Ray RayThrough(double u, double v) const {
    return {{x_m, 0, 0}, {(u - cx) / focal_px, (v - cy) / focal_px, 1}};
  }
};

// Part of the image that a solid can be seen in, px, ends included; saves most intersections.
struct Bounds {
  double left, right, top, bottom;
};

constexpr double kHuge = std::numeric_limits<double>::infinity();

Bounds BoundsOf(const Solid& solid, const Eye& eye, double height) {
  if (solid.shape == Solid::Shape::kWall) return {-kHuge, kHuge, -kHuge, kHuge};
  if (solid.shape == Solid::Shape::kFloor) return {-kHuge, kHuge, eye.cy, height};
  Bounds bounds{kHuge, -kHuge, kHuge, -kHuge};
  for (int corner = 0; corner < 8; ++corner) {
    const double x = (corner & 1 ? 1 : -1) * solid.half_size.x;
    const double y = (corner & 2 ? 1 : -1) * solid.half_size.y;
    const double z = (corner & 4 ? 1 : -1) * solid.half_size.z;
    const double depth = solid.centre.z + solid.cos_yaw * z - solid.sin_yaw * x;
    const double across = solid.centre.x + solid.cos_yaw * x + solid.sin_yaw * z - eye.x_m;
    const double u = eye.focal_px * across / depth + eye.cx;
    const double v = eye.focal_px * (solid.centre.y + y) / depth + eye.cy;
    bounds = {std::min(bounds.left, u), std::max(bounds.right, u), std::min(bounds.top, v),
              std::max(bounds.bottom, v)};
  }
  return bounds;
}

struct Hit {
  double depth_m;
  int solid;
};

// What one camera sees of the solids.
class Renderer {
 public:
  Renderer(const RectifiedPair& pair, const Eye& eye, const std::vector<Solid>& solids)
      : pair_(pair), eye_(eye), solids_(solids) {
    assert(solids.size() < 256);
    for (const Solid& solid : solids) bounds_.push_back(BoundsOf(solid, eye, pair.height));
  }

  void Render(cv::Mat& image, cv::Mat1f& disparity) const {
    image.create(pair_.size(), CV_8UC3);
    disparity.create(pair_.size());
    cv::Mat1b owner(pair_.size());
    const cv::Range rows(0, pair_.height);
    cv::parallel_for_(rows, [&](const cv::Range& part) {
      for (int v = part.start; v < part.end; ++v) RenderRow(v, image, disparity, owner);
    });
    cv::parallel_for_(rows, [&](const cv::Range& part) {
      for (int v = part.start; v < part.end; ++v) SmoothEdges(v, owner, image);
    });
  }

 private:
  // One ray through every pixel centre. Textures are free of finer detail, so one is enough
  // inside a solid.
  void RenderRow(int v, cv::Mat& image, cv::Mat1f& disparity, cv::Mat1b& owner) const {
    for (int u = 0; u < pair_.width; ++u) {
      const Ray ray = eye_.RayThrough(u, v);
      const Hit hit = Cast(ray, u, v);
      owner(v, u) = static_cast<uchar>(hit.solid);
      disparity(v, u) = static_cast<float>(pair_.DisparityFromDepth(hit.depth_m));
      image.at<cv::Vec3b>(v, u) = ToPixel(ColourOf(hit, ray));
    }
  }

  // Pixels at the border of two solids show both of them: 2 × 2 rays.
  void SmoothEdges(int v, const cv::Mat1b& owner, cv::Mat& image) const {
    const int above = std::max(v - 1, 0);
    const int below = std::min(v + 1, pair_.height - 1);
    for (int u = 0; u < pair_.width; ++u) {
      const uchar here = owner(v, u);
      const bool inside = owner(v, std::max(u - 1, 0)) == here && owner(above, u) == here &&
                          owner(v, std::min(u + 1, pair_.width - 1)) == here &&
                          owner(below, u) == here;
      if (inside) continue;
      Vec3 sum;
      for (double dv : {-0.25, 0.25}) {
        for (double du : {-0.25, 0.25}) {
          const Ray ray = eye_.RayThrough(u + du, v + dv);
          sum = sum + ColourOf(Cast(ray, u + du, v + dv), ray);
        }
      }
      image.at<cv::Vec3b>(v, u) = ToPixel(0.25 * sum);
    }
  }

  // The nearest solid. The wall, which is first and hit by every ray, is where the search starts.
  Hit Cast(const Ray& ray, double u, double v) const {
    Hit hit{Intersect(solids_[0], ray), 0};
    for (size_t i = 1; i < solids_.size(); ++i) {
      const Bounds& bounds = bounds_[i];
      if (u < bounds.left || u > bounds.right || v < bounds.top || v > bounds.bottom) continue;
      const double depth_m = Intersect(solids_[i], ray);
      if (depth_m < hit.depth_m) hit = {depth_m, static_cast<int>(i)};
    }
    return hit;
  }

  Vec3 ColourOf(const Hit& hit, const Ray& ray) const {
    return ColourAt(solids_[static_cast<size_t>(hit.solid)],
                    ray.origin + hit.depth_m * ray.direction, pair_.focal_px);
  }

  static cv::Vec3b ToPixel(const Vec3& bgr) {
    const auto channel = [](double value) {
      return static_cast<uchar>(std::clamp(value, 0.0, 255.0) + 0.5);
    };
    return {channel(bgr.x), channel(bgr.y), channel(bgr.z)};
  }

  const RectifiedPair& pair_;
  const Eye& eye_;
  const std::vector<Solid>& solids_;
  std::vector<Bounds> bounds_;
};

// The view that a simulated range sensor has of the scene.
LensView ViewOf(const TofCamera& camera) {
  return {camera.lens(), camera.left_from_tof_rotation, camera.left_from_tof_translation_m,
          TofSamples::kPerSide};
}

class SyntheticDataset : public Dataset {
 public:
  SyntheticDataset(cv::Size size, const CaptureConfig& config)
      : tof_grid_px_(config.tof_grid_px()),
        motion_(config.sr4000().motion()),
        rig_{.pair = PairOfSize(size), .tof = {}},
        scene_(config.seed(), kNearestFloorM * size.height / (2 * rig_.pair.focal_px)) {
    if (config.tof() == "sr4000") {
      sr4000_.emplace(rig_.pair, config.sr4000(), config.seed());
      view_.emplace(ViewOf(sr4000_->actual()));
      rig_.tof = sr4000_->calibrated();
    } else if (config.tof() == kZones) {
      zones_.emplace(rig_.pair, config.zones(), config.seed());
      view_.emplace(ViewOf(zones_->camera()));
    } else if (config.tof() == "grid") {
      rig_.tof = TofGridCamera(rig_.pair, tof_grid_px_);
    }
  }

  const Rig& rig() const override { return rig_; }
  std::optional<int64_t> frame_count() const override { return {}; }

  DatasetFrame Get(int64_t index) override {
    assert(index >= 0);
    const RectifiedPair& pair = rig_.pair;
    const std::vector<Solid> solids = scene_.At(index);
    const Eye left{pair.focal_px, pair.cx, pair.cy, 0};
    const Eye right{pair.focal_px, pair.cx_right, pair.cy, pair.baseline_m};
    DatasetFrame frame;
    Renderer(pair, left, solids).Render(frame.left, frame.truth.left);
    Renderer(pair, right, solids).Render(frame.right, frame.truth.right);
    if (sr4000_) {
      const Sr4000Frame measured =
          sr4000_->Measure(RenderTof(*view_, solids, pair.focal_px), index, PhaseImages(index));
      frame.tof = measured.tof;
      frame.unambiguous_range_m = measured.unambiguous_range_m;
    } else if (zones_) {
      frame.tof_zones = zones_->Measure(RenderTof(*view_, solids, pair.focal_px), index);
    } else if (rig_.tof.width > 0) {
      frame.tof = SampleTofGrid(pair, tof_grid_px_, frame.truth.left);
    }
    return frame;
  }

 private:
  // What the SR4000 sees while it takes its phase images, the first at the time of the frame.
  std::vector<TofSamples> PhaseImages(int64_t index) const {
    std::vector<TofSamples> images;
    for (int k = 0; motion_ > 0 && k < 4; ++k) {
      images.push_back(RenderTof(*view_, scene_.At(index, k * motion_), rig_.pair.focal_px));
    }
    return images;
  }

  int tof_grid_px_;
  double motion_;  // frame intervals between phase images
  Rig rig_;
  SyntheticScene scene_;
  std::optional<Sr4000> sr4000_;
  std::optional<ZoneSensor> zones_;  // else the grid or none
  std::optional<LensView> view_;     // of either of them
};

}  // namespace

std::unique_ptr<Dataset> OpenSynthetic(cv::Size size, const CaptureConfig& config) {
  return std::make_unique<SyntheticDataset>(size, config);
}

}  // namespace sprout::scenes
