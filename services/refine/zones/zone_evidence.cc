#include "services/refine/zones/zone_evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/geometry/projection.h"
#include "services/refine/zones/zone_rules.h"

namespace sprout::refine {
namespace {

constexpr double kFarthest = std::numeric_limits<double>::infinity();

double Squared(double x) { return x * x; }

// Of a point in front of the pair.
std::optional<Seed> InPair(const TofZones& zones, const RectifiedPair& pair, double x, double y,
                           double depth_m) {
  const Pose& pose = zones.left_from_sensor;
  const Eigen::Vector3d point =
      pose.rotation * Eigen::Vector3d(x * depth_m, y * depth_m, depth_m) + pose.translation_m;
  if (!(point.z() > 0)) return {};
  return ProjectToPair(pair, point);
}

}  // namespace

// A zone as the left camera sees it.
struct ZoneEvidence::Footprint {
  cv::Rect2d box_px;    // around all its targets
  double least_px = 0;  // what its surfaces can have
  double most_px = 0;
  Patch patch;
};

std::optional<ZoneEvidence::Footprint> ZoneEvidence::FootprintOf(const TofZones& zones, size_t zone,
                                                                 const RectifiedPair& pair) const {
  const ZoneView& view = zones.views[zone];
  const double x = (double{view.left} + view.right) / 2;
  const double y = (double{view.top} + view.bottom) / 2;
  // Disparity of the middle of the zone at a depth; without one in front of the pair, the largest.
  const auto disparity_at = [&](double depth_m) {
    const auto seed = depth_m > 0 ? InPair(zones, pair, x, y, depth_m) : std::nullopt;
    return seed ? double{seed->disparity()} : kFarthest;
  };
  double left = kFarthest, right = -kFarthest, top = kFarthest, bottom = -kFarthest;
  Footprint footprint{.box_px = {}, .least_px = kFarthest, .most_px = -kFarthest, .patch = {}};
  int targets = 0;
  bool sure = zones.mode == ZoneMode::kMean;
  for (const ZoneTarget& target : zones.TargetsOf(zone)) {
    if (target.status == TargetStatus::kNone) continue;
    for (const double corner_x : {view.left, view.right}) {
      for (const double corner_y : {view.top, view.bottom}) {
        const auto corner = InPair(zones, pair, corner_x, corner_y, target.depth_m);
        if (!corner) return {};
        left = std::min(left, double{corner->u});
        right = std::max(right, double{corner->u});
        top = std::min(top, double{corner->v});
        bottom = std::max(bottom, double{corner->v});
      }
    }
    const double off_m = ZoneRules::kSigmas * target.sigma_m;
    const double least_px = zones.mode == ZoneMode::kNearest ? -kFarthest
                                                             : disparity_at(target.depth_m + off_m);
    footprint.least_px = std::min(footprint.least_px, least_px);
    footprint.most_px = std::max(footprint.most_px, disparity_at(target.depth_m - off_m));
    footprint.patch.disparity_px = disparity_at(target.depth_m);
    const double near_px = disparity_at(target.depth_m - target.sigma_m);
    footprint.patch.variance_px2 =
        Squared((near_px - disparity_at(target.depth_m + target.sigma_m)) / 2);
    ++targets;
    sure = sure && target.status == TargetStatus::kValid && std::isfinite(near_px);
  }
  if (targets == 0 || !std::isfinite(right - left) || !std::isfinite(bottom - top)) return {};
  footprint.box_px = {left, top, right - left, bottom - top};
  footprint.patch.is_one = sure && targets == 1;
  footprint.patch.centre_px = {(left + right) / 2, (top + bottom) / 2};
  footprint.patch.half_px = {(right - left) / 2, (bottom - top) / 2};
  return footprint;
}

namespace {

// Cells whose centres lie in a box of the image.
cv::Rect CellsIn(const cv::Rect2d& box_px, const CellGrid& grid) {
  const auto first = [&](double px, int cells) {
    return static_cast<int>(std::clamp(std::ceil((px + 0.5) / grid.spacing_px - 0.5), 0.0,
                                       static_cast<double>(cells)));
  };
  const int left = first(box_px.x, grid.size.width);
  const int top = first(box_px.y, grid.size.height);
  return {left, top, first(box_px.x + box_px.width, grid.size.width) - left,
          first(box_px.y + box_px.height, grid.size.height) - top};
}

cv::Rect2d Widened(const cv::Rect2d& box) {
  const double across = ZoneRules::kReach * box.width;
  const double down = ZoneRules::kReach * box.height;
  return {box.x - across, box.y - down, box.width + 2 * across, box.height + 2 * down};
}

}  // namespace

void ZoneEvidence::Bound(const Footprint& footprint, const CellGrid& grid) {
  const cv::Rect cells = CellsIn(Widened(footprint.box_px), grid);
  for (int y = cells.y; y < cells.br().y; ++y) {
    for (int x = cells.x; x < cells.br().x; ++x) {
      float& least = bounds_.least_px(y, x);
      float& most = bounds_.most_px(y, x);
      least = std::min(least, static_cast<float>(footprint.least_px));
      most = std::max(most, static_cast<float>(footprint.most_px));
    }
  }
}

Result<void> ZoneEvidence::Set(const TofZones& zones, const RectifiedPair& pair,
                               const CellGrid& grid) {
  grid_ = grid;
  patches_.clear();
  planes_.clear();
  bounds_ = {};
  if (zones.views.empty()) return {};
  zone_.create(grid.size);
  zone_.setTo(kNone);
  nearest_px_.create(grid.size);
  bounds_.spacing_px = grid.spacing_px;
  bounds_.least_px = cv::Mat1f(grid.size, std::numeric_limits<float>::infinity());
  bounds_.most_px = cv::Mat1f(grid.size, -std::numeric_limits<float>::infinity());
  int64_t cells = 0;
  for (size_t zone = 0; zone < zones.views.size(); ++zone) {
    const std::optional<Footprint> footprint = FootprintOf(zones, zone, pair);
    patches_.push_back(footprint ? footprint->patch : Patch());
    if (!footprint) continue;
    cells += CellsIn(Widened(footprint->box_px), grid).area();
    if (cells > int64_t{ZoneRules::kMostZonesPerCell} * grid.size.area()) {
      return Fail("zones overlap: allowed are " + std::to_string(ZoneRules::kMostZonesPerCell) +
                  " zones at a place of the left image, on average, with those beside it");
    }
    Bound(*footprint, grid);
    const cv::Rect own = CellsIn(footprint->box_px, grid);
    for (int y = own.y; y < own.br().y; ++y) {
      for (int x = own.x; x < own.br().x; ++x) {
        const auto disparity_px = static_cast<float>(footprint->patch.disparity_px);
        if (zone_(y, x) != kNone && nearest_px_(y, x) >= disparity_px) continue;
        zone_(y, x) = static_cast<int>(zone);
        nearest_px_(y, x) = disparity_px;
      }
    }
  }
  // Nothing is known of what no zone with a target looks at.
  const cv::Mat unseen = zone_ == kNone;
  bounds_.least_px.setTo(-std::numeric_limits<float>::infinity(), unseen);
  bounds_.most_px.setTo(std::numeric_limits<float>::infinity(), unseen);
  for (int row = 0; row < zones.rows; ++row) {
    for (int column = 0; column < zones.columns; ++column) {
      planes_.push_back(PlaneOf(zones, column, row));
    }
  }
  return {};
}

// An M-estimator as the prior's (P1) and (P2), with the zones around.
ZoneEvidence::Plane ZoneEvidence::PlaneOf(const TofZones& zones, int column, int row) const {
  const auto patch_of = [&](int u, int v) -> const Patch& {
    return patches_[static_cast<size_t>(v * zones.columns + u)];
  };
  const Patch& own = patch_of(column, row);
  Plane plane;
  if (!own.is_one) return plane;
  plane.at = {own.disparity_px, 0, 0};
  for (const double wider : {1.5, 1.0, 1.0}) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    // Without others the plane is level.
    const double level = 1e-6;
    normal.diagonal() << 0, level, level;
    for (int v = std::max(row - 1, 0); v <= std::min(row + 1, zones.rows - 1); ++v) {
      for (int u = std::max(column - 1, 0); u <= std::min(column + 1, zones.columns - 1); ++u) {
        const Patch& other = patch_of(u, v);
        if (!other.is_one) continue;
        const Eigen::Vector2d off = other.centre_px - own.centre_px;
        const Eigen::Vector3d basis(1, off.x(), off.y());
        const double scale =
            wider * std::max({1e-3, ZoneRules::kPlaneScalePerPx * off.norm(),
                              ZoneRules::kPlaneScaleSigmas *
                                  std::sqrt(own.variance_px2 + other.variance_px2)});
        const double residual = other.disparity_px - plane.at.dot(basis);
        const double weight =
            1 / (Squared(1 + Squared(residual / scale)) * std::max(1e-4, other.variance_px2));
        normal += weight * basis * basis.transpose();
        right += weight * other.disparity_px * basis;
      }
    }
    plane.covariance = normal.inverse();
    plane.at = plane.covariance * right;
  }
  const double slant_px2 = (Squared(plane.at.y() * own.half_px.x()) +
                            Squared(plane.at.z() * own.half_px.y())) / 3;
  plane.unexplained_px2 = std::max(0.0, own.variance_px2 - slant_px2);
  return plane;
}

std::optional<ZoneSurface> ZoneEvidence::SurfaceAt(cv::Point cell) const {
  if (patches_.empty() || zone_(cell) == kNone) return {};
  const auto zone = static_cast<size_t>(zone_(cell));
  const Patch& patch = patches_[zone];
  if (!patch.is_one) return {};
  const cv::Point2d centre = grid_.CentrePx(cell);
  const Eigen::Vector3d basis(1, centre.x - patch.centre_px.x(), centre.y - patch.centre_px.y());
  const Plane& plane = planes_[zone];
  const double variance = basis.dot(plane.covariance * basis) + plane.unexplained_px2;
  const ZoneSurface surface{plane.at.dot(basis), std::sqrt(variance)};
  if (!std::isfinite(surface.disparity_px) || !std::isfinite(surface.sigma_px)) return {};
  return surface;
}

}  // namespace sprout::refine
