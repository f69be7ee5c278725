#include "services/refine/zones/zone_evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "common/geometry/projection.h"

namespace sprout::refine {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Added to the weights of slopes: a plane through zones in a row, or one alone, stays level, and
// its slope is as good as unknown (1000 px a px).
constexpr double kLevel = 1e-6;
constexpr double kMinVariancePx2 = 1e-4;  // of a zone: disparities are not known to 0.01 px

double Squared(double x) { return x * x; }

// A point of the sensor's; nothing when it does not lie in front of the pair.
std::optional<Seed> InPair(const TofZones& zones, const RectifiedPair& pair, double x, double y,
                           double depth_m) {
  const Pose& pose = zones.left_from_sensor;
  const Eigen::Vector3d point =
      pose.rotation * Eigen::Vector3d(x * depth_m, y * depth_m, depth_m) + pose.translation_m;
  if (!(point.z() > 0)) return {};
  return ProjectToPair(pair, point);
}

// What lies between the least and the largest of what is added.
struct ZoneBox {
  double left = kInfinity, right = -kInfinity, top = kInfinity, bottom = -kInfinity;

  void Add(const Seed& corner) {
    left = std::min(left, double{corner.u});
    right = std::max(right, double{corner.u});
    top = std::min(top, double{corner.v});
    bottom = std::max(bottom, double{corner.v});
  }
  bool IsFinite() const { return std::isfinite(right - left) && std::isfinite(bottom - top); }
  ZoneBox Widened() const {
    const double across = ZoneRules::kReach * (right - left);
    const double down = ZoneRules::kReach * (bottom - top);
    return {left - across, right + across, top - down, bottom + down};
  }
};

// Cells whose centres lie in a box of the image.
cv::Rect CellsIn(const ZoneBox& box, const CellGrid& grid) {
  const auto first = [&](double px, int cells) {
    return static_cast<int>(
        std::clamp(std::ceil((px + 0.5) / grid.spacing_px - 0.5), 0.0, static_cast<double>(cells)));
  };
  const int left = first(box.left, grid.size.width);
  const int top = first(box.top, grid.size.height);
  return {left, top, first(box.right, grid.size.width) - left,
          first(box.bottom, grid.size.height) - top};
}

template <typename Visit>
void ForEachCell(const cv::Rect& cells, const Visit& visit) {
  for (int y = cells.y; y < cells.y + cells.height; ++y) {
    for (int x = cells.x; x < cells.x + cells.width; ++x) visit(cv::Point(x, y));
  }
}

// A zone as the left camera sees it.
struct Footprint {
  ZoneBox box;          // around all its targets, px
  double most_px = -1;  // that its targets allow
  ZonePatch patch;
};

// Nothing for a zone that has no target in front of the pair.
std::optional<Footprint> FootprintOf(const TofZones& zones, size_t zone,
                                     const RectifiedPair& pair) {
  const ZoneView& view = zones.views[zone];
  const double x = (double{view.left} + view.right) / 2;
  const double y = (double{view.top} + view.bottom) / 2;
  // Disparity of the middle of the zone; where that is not in front of the pair, the largest.
  const auto disparity_at = [&](double depth_m) {
    const auto seed = depth_m > 0 ? InPair(zones, pair, x, y, depth_m) : std::nullopt;
    return seed ? double{seed->disparity()} : kInfinity;
  };
  Footprint footprint;
  ZonePatch& patch = footprint.patch;
  int targets = 0;
  for (const ZoneTarget& target : zones.TargetsOf(zone)) {
    if (target.status == TargetStatus::kNone) continue;
    ++targets;
    for (const double corner_x : {view.left, view.right}) {
      for (const double corner_y : {view.top, view.bottom}) {
        const auto corner = InPair(zones, pair, corner_x, corner_y, target.depth_m);
        if (!corner) return {};
        footprint.box.Add(*corner);
      }
    }
    const double sigma_m = target.sigma_m;
    footprint.most_px =
        std::max(footprint.most_px, disparity_at(target.depth_m - ZoneRules::kSigmas * sigma_m));
    patch.disparity_px = disparity_at(target.depth_m);
    patch.variance_px2 = Squared(
        (disparity_at(target.depth_m - sigma_m) - disparity_at(target.depth_m + sigma_m)) / 2);
    patch.is_one = targets == 1 && zones.mode == ZoneMode::kMean &&
                   target.status == TargetStatus::kValid && std::isfinite(patch.variance_px2);
  }
  const ZoneBox& box = footprint.box;
  if (targets == 0 || !box.IsFinite()) return {};
  patch.centre_px = {(box.left + box.right) / 2, (box.top + box.bottom) / 2};
  return footprint;
}

}  // namespace

Result<void> ZoneEvidence::Set(const TofZones& zones, const RectifiedPair& pair,
                               const CellGrid& grid) {
  grid_ = grid;
  patches_.clear();
  planes_.clear();
  if (zones.views.empty()) {
    most_px_.release();
    return {};
  }
  zone_.create(grid.size);
  zone_.setTo(kNone);
  nearest_px_.create(grid.size);
  most_px_.create(grid.size);
  most_px_.setTo(-std::numeric_limits<float>::infinity());
  int64_t cells = 0;
  for (size_t zone = 0; zone < zones.views.size(); ++zone) {
    const std::optional<Footprint> footprint = FootprintOf(zones, zone, pair);
    patches_.push_back(footprint ? footprint->patch : ZonePatch());
    if (!footprint) continue;
    const cv::Rect within_reach = CellsIn(footprint->box.Widened(), grid);
    cells += within_reach.area();
    if (cells > int64_t{ZoneRules::kMaxZonesPerCell} * grid.size.area()) {
      return Fail("zones overlap: allowed are " + std::to_string(ZoneRules::kMaxZonesPerCell) +
                  " zones within reach of a place in the left image, on average");
    }
    const auto most_px = static_cast<float>(footprint->most_px);
    ForEachCell(within_reach,
                [&](cv::Point cell) { most_px_(cell) = std::max(most_px_(cell), most_px); });
    const auto disparity_px = static_cast<float>(footprint->patch.disparity_px);
    ForEachCell(CellsIn(footprint->box, grid), [&](cv::Point cell) {
      if (zone_(cell) != kNone && nearest_px_(cell) >= disparity_px) return;
      zone_(cell) = static_cast<int>(zone);
      nearest_px_(cell) = disparity_px;
    });
  }
  // Where no zone with a target looks, nothing is known.
  const cv::Mat unseen = zone_ == kNone;
  most_px_.setTo(std::numeric_limits<float>::infinity(), unseen);
  for (int row = 0; row < zones.rows; ++row) {
    for (int column = 0; column < zones.columns; ++column) {
      planes_.push_back(PlaneOf(zones, column, row));
    }
  }
  return {};
}

// Eq. (Z2), by iteratively reweighted least squares.
ZoneEvidence::Plane ZoneEvidence::PlaneOf(const TofZones& zones, int column, int row) const {
  const auto patch_of = [&](int u, int v) -> const ZonePatch& {
    return patches_[static_cast<size_t>(v * zones.columns + u)];
  };
  const ZonePatch& own = patch_of(column, row);
  Plane plane;
  if (!own.is_one) return plane;
  plane.at = {own.disparity_px, 0, 0};
  for (const double wider : {ZoneRules::kFirstScale, 1.0, 1.0}) {
    Eigen::Matrix3d normal = Eigen::Vector3d(0, kLevel, kLevel).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int v = std::max(row - 1, 0); v <= std::min(row + 1, zones.rows - 1); ++v) {
      for (int u = std::max(column - 1, 0); u <= std::min(column + 1, zones.columns - 1); ++u) {
        const ZonePatch& other = patch_of(u, v);
        if (!other.is_one) continue;
        const double variance_px2 = std::max(kMinVariancePx2, other.variance_px2);
        const Eigen::Vector2d off = other.centre_px - own.centre_px;
        const Eigen::Vector3d basis(1, off.x(), off.y());
        const double scale_px =
            wider *
            std::max(ZoneRules::kPlaneScalePerPx * off.norm(),
                     ZoneRules::kPlaneScaleSigmas *
                         std::sqrt(std::max(kMinVariancePx2, own.variance_px2) + variance_px2));
        const double residual_px = other.disparity_px - plane.at.dot(basis);
        const double weight = 1 / (Squared(1 + Squared(residual_px / scale_px)) * variance_px2);
        normal += weight * basis * basis.transpose();
        right += weight * other.disparity_px * basis;
      }
    }
    plane.covariance = normal.inverse();
    plane.at = plane.covariance * right;
  }
  return plane;
}

// Eq. (Z3).
std::optional<ZoneSurface> ZoneEvidence::SurfaceAt(cv::Point cell) const {
  if (patches_.empty() || zone_(cell) == kNone) return {};
  const auto zone = static_cast<size_t>(zone_(cell));
  const ZonePatch& patch = patches_[zone];
  if (!patch.is_one) return {};
  const cv::Point2d centre = grid_.CentrePx(cell);
  const Eigen::Vector3d basis(1, centre.x - patch.centre_px.x(), centre.y - patch.centre_px.y());
  const Plane& plane = planes_[zone];
  const ZoneSurface surface{plane.at.dot(basis),
                            std::sqrt(patch.variance_px2 + basis.dot(plane.covariance * basis))};
  if (!std::isfinite(surface.disparity_px) || !std::isfinite(surface.sigma_px)) return {};
  return surface;
}

bool AddsInformation(const ZoneSurface& surface, const PointSurface& seeds, cv::Point cell) {
  return ZoneRules::kSurer * surface.sigma_px <= seeds.SigmaPx(cell) &&
         seeds.OffPx(cell, surface.disparity_px) > ZoneRules::kSigmas * surface.sigma_px;
}

}  // namespace sprout::refine
