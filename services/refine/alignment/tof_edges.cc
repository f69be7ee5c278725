#include "services/refine/alignment/tof_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/core/parallel.h"
#include "services/refine/alignment/alignment_rules.h"

namespace sprout::refine {
namespace {

using Rules = AlignmentRules;
// How far beyond a pixel is looked: past the mixed ones, two more and the disc's radius.
constexpr int kBorder = Rules::kMaxMixed + 2 + Rules::kDiscRadius;

// The steps of a ToF pixel in the images, up to a common factor.
Eigen::Matrix2d ImageFromTof(const Eigen::Matrix3d& left_from_tof, const TofCamera& camera) {
  Eigen::Matrix2d steps = left_from_tof.topLeftCorner<2, 2>();
  steps.col(0) /= camera.fx;
  steps.col(1) /= camera.fy;
  return steps;
}

}  // namespace

// Along a row or a column of the ToF image.
struct TofEdgeFinder::Direction {
  int u, v;
};

// Where the ToF camera stands and looks.
struct TofEdgeFinder::View {
  const TofProjector& projector;
  const RectifiedPair& pair = projector.rig().pair;
  const TofCamera& camera = projector.rig().tof;
  Eigen::Matrix3d rotation = camera.left_from_tof_rotation.toRotationMatrix();
  Eigen::Vector3d place = camera.left_from_tof_translation_m;
  double infinity_px = pair.cx - pair.cx_right;  // disparity of a point at infinity

  Eigen::Matrix2d image_from_tof = ImageFromTof(rotation, camera);
  Eigen::Matrix2d take_normal = image_from_tof.inverse().transpose();  // to the images

  // The near surface's end: on the ray there, at the depth that its disparity says. From the
  // camera, in the left frame; nothing where that is behind one of the cameras.
  std::optional<Eigen::Vector3d> ArmTo(const ProjectedPoint& point, const Direction& direction,
                                       const Step& step) const;
};

// ToF pixels, one after another in one direction.
struct TofEdgeFinder::Line {
  const float* disparity;
  const float* amplitude;
  std::ptrdiff_t stride;
  double infinity_px;  // disparity of a point at infinity

  double At(int i) const { return double{disparity[i * stride]}; }
  // Not negative, whatever a sensor sends: (A2) would put the end anywhere.
  double Light(int i) const { return std::max(0.0, double{amplitude[i * stride]}); }
  // Depth up to a factor; negative when there is none.
  double Depth(double disparity_px) const { return 1 / (disparity_px - infinity_px); }
};

// A step from one surface to the other along a line.
struct TofEdgeFinder::Step {
  double near_px = 0, far_px = 0;        // where the near one ends
  double near_slope = 0, far_slope = 0;  // px a ToF pixel
  double end = 0.5;                      // of the near one, ToF pixels from the first of the line
};

// Pixels 0 and 1 are the last two that are near, unless the line of the next pixel is the one.
std::optional<TofEdgeFinder::Step> TofEdgeFinder::StepAlong(const Line& line, double least_px) {
  for (int last = 2; last < 2 + Rules::kMaxMixed;
       ++last) {  // last + 1: the second on the far surface
    const int far = last + 1;
    const double jump = line.At(0) - line.At(far);
    const double tolerance = Rules::kSameSurface * jump;
    const auto same = [&](int i, int k) { return std::abs(line.At(i) - line.At(k)) <= tolerance; };
    if (!(jump >= least_px) || !same(0, 1) || !same(last, far)) continue;
    if (same(0, 2)) return {};
    const auto gentle = [&](double slope) { return std::abs(slope) <= tolerance ? slope : 0; };
    Step step;
    step.near_slope = gentle((line.At(0) - line.At(-2)) / 2);
    step.far_slope = gentle((line.At(far + 2) - line.At(far)) / 2);
    // Eq. (A2): light adds up, so the depth of a pixel is the mean by amplitude.
    for (int i = 1; i <= last; ++i) {
      const double near_depth = line.Depth(line.At(0) + step.near_slope * i);
      const double far_depth = line.Depth(line.At(far) + step.far_slope * (i - far));
      const double depth = line.Depth(line.At(i));
      const double near_part = line.Light(far) * std::max(0.0, far_depth - depth);
      const double far_part = line.Light(0) * std::max(0.0, depth - near_depth);
      if (!(near_depth > 0 && far_depth > near_depth && near_part + far_part > 0)) return {};
      step.end += near_part / (near_part + far_part);
    }
    step.near_px = line.At(0) + step.near_slope * step.end;
    step.far_px = line.At(far) + step.far_slope * (step.end - far);
    if (!(step.near_px - step.far_px >= least_px)) return {};  // a slant
    return step;
  }
  return {};
}

// Away from where the near pixels of a disc lie, in ToF pixels; nothing when none is near or far.
std::optional<Eigen::Vector2d> TofEdgeFinder::NormalAt(const float* centre,
                                                       double between_px) const {
  Eigen::Vector2d sum(0, 0);
  Eigen::Vector2d near_sum(0, 0);
  int count = 0;
  int near_count = 0;
  for (int y = -Rules::kDiscRadius; y <= Rules::kDiscRadius; ++y) {
    for (int x = -Rules::kDiscRadius; x <= Rules::kDiscRadius; ++x) {
      const double disparity = centre[y * stride_ + x];
      if (x * x + y * y > Rules::kDiscRadius * Rules::kDiscRadius + 1 || std::isnan(disparity))
        continue;
      sum += Eigen::Vector2d(x, y);
      ++count;
      if (disparity <= between_px) continue;
      near_sum += Eigen::Vector2d(x, y);
      ++near_count;
    }
  }
  if (near_count == 0 || near_count == count) return {};
  const Eigen::Vector2d away = sum / count - near_sum / near_count;
  if (!(away.squaredNorm() > 0)) return {};
  return away / std::sqrt(away.squaredNorm());
}

std::optional<Eigen::Vector3d> TofEdgeFinder::View::ArmTo(const ProjectedPoint& point,
                                                          const Direction& direction,
                                                          const Step& step) const {
  Seed near = point.seed;
  near.u_right = near.u - static_cast<float>(step.near_px);
  const Eigen::Vector3d on_surface = PointFromSeed(pair, near);
  const double depth_m = (rotation.transpose() * (on_surface - place)).z();
  const int whole = static_cast<int>(step.end);
  const auto ray = [&](int pixels) -> const Eigen::Vector3d& {
    return projector.ray(point.tof_u + pixels * direction.u, point.tof_v + pixels * direction.v);
  };
  const Eigen::Vector3d& before = ray(whole);
  const Eigen::Vector3d& behind = ray(whole + 1);
  const Eigen::Vector3d arm =
      rotation * (depth_m * (before + (step.end - whole) * (behind - before)));
  if (!(depth_m > 0 && arm.z() + place.z() > 0)) return {};
  return arm;
}

size_t TofEdgeFinder::IndexOf(const ProjectedPoint& point) const {
  return static_cast<size_t>((point.tof_v + kBorder) * stride_ + point.tof_u + kBorder);
}

void TofEdgeFinder::SetImage(std::span<const ProjectedPoint> points, const TofImage& tof,
                             const TofCamera& camera) {
  stride_ = camera.width + 2 * kBorder;
  disparity_.assign(static_cast<size_t>(stride_ * (camera.height + 2 * kBorder)),
                    std::numeric_limits<float>::quiet_NaN());
  amplitude_.assign(disparity_.size(), 1);
  for (const ProjectedPoint& point : points) {
    disparity_[IndexOf(point)] = point.seed.disparity();
    if (tof.amplitude.empty()) continue;
    amplitude_[IndexOf(point)] = tof.amplitude(point.tof_v, point.tof_u);
  }
}

// The edge behind a point, if a near surface ends there.
std::optional<TofEdge> TofEdgeFinder::EdgeAt(const ProjectedPoint& point,
                                             const Direction& direction, const View& view,
                                             double least_px) const {
  const RectifiedPair& pair = view.pair;
  const std::ptrdiff_t along = direction.v * stride_ + direction.u;
  const float* disparity = disparity_.data() + IndexOf(point);
  const std::optional<Step> step = StepAlong({.disparity = disparity,
                                              .amplitude = amplitude_.data() + IndexOf(point),
                                              .stride = along,
                                              .infinity_px = view.infinity_px},
                                             least_px);
  if (!step || step->near_px >= pair.width || step->far_px <= -pair.width) return {};
  const std::optional<Eigen::Vector2d> normal_in_tof =
      NormalAt(disparity + std::lround(step->end) * along, (step->near_px + step->far_px) / 2);
  if (!normal_in_tof) return {};
  const double across = normal_in_tof->x() * direction.u + normal_in_tof->y() * direction.v;
  if (!(across >= Rules::kMinAcross)) return {};
  const std::optional<Eigen::Vector3d> arm = view.ArmTo(point, direction, *step);
  if (!arm) return {};
  const Eigen::Vector3d end = *arm + view.place;
  const Seed seed = ProjectToPair(pair, end);
  if (!(seed.u >= 0 && seed.u < static_cast<float>(pair.width) && seed.v >= 0 &&
        seed.v < static_cast<float>(pair.height))) {
    return {};
  }
  const Eigen::Vector2d normal = (view.take_normal * *normal_in_tof).normalized();
  const double per_px =
      across / pair.focal_px * (direction.u != 0 ? view.camera.fx : view.camera.fy);
  // Eq. (A1): the image of ω × arm, for f·ω of 1 px about the axes that point down and left.
  const double x = end.x() / end.z();
  const double y = end.y() / end.z();
  const Eigen::Vector3d lever = *arm / end.z();
  return TofEdge{.left = {seed.u, seed.v},
                 .near_px = step->near_px,
                 .far_px = step->far_px,
                 .near_slope = step->near_slope * per_px,
                 .far_slope = step->far_slope * per_px,
                 .normal = normal,
                 .motion = {normal.dot(Eigen::Vector2d(lever.z() + x * lever.x(), y * lever.x())),
                            normal.dot(Eigen::Vector2d(x * lever.y(), lever.z() + y * lever.y()))}};
}

std::span<const TofEdge> TofEdgeFinder::Find(std::span<const ProjectedPoint> points,
                                             const TofImage& tof, const TofProjector& projector,
                                             double least_px) {
  edges_.clear();
  const View view{.projector = projector};
  SetImage(points, tof, view.camera);
  if (!(std::abs(view.image_from_tof.determinant()) > 0)) return edges_;  // it looks across
  std::array<std::vector<TofEdge>, 16> parts;
  ForEachParallel(parts.size(), [&](size_t k) {
    const size_t end = points.size() * (k + 1) / parts.size();
    for (size_t i = points.size() * k / parts.size(); i < end; ++i) {
      for (const Direction direction : {Direction{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const std::optional<TofEdge> edge = EdgeAt(points[i], direction, view, least_px);
        if (edge) parts[k].push_back(*edge);
      }
    }
  });
  for (const auto& part : parts) edges_.insert(edges_.end(), part.begin(), part.end());
  return edges_;
}

}  // namespace sprout::refine
