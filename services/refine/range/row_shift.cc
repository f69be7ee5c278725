#include "services/refine/range/row_shift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "common/core/quantile.h"
#include "services/refine/range/range_rules.h"

namespace sprout::refine {
namespace {

// What the images show of a place.
struct PlaceOffset {
  double row = 0;        // in the left image, px
  double disparity = 0;  // as measured, px, 0 at infinity
  double offset_px = 0;
  double weight = 1;
};

// What is left of the offsets, px in the mean, if in each of so many bands they are in proportion
// to that power of the disparity. Sorts them.
double LeftOver(std::vector<PlaceOffset>& offsets, double PlaceOffset::*band_by, size_t bands,
                int power) {
  std::ranges::stable_sort(offsets, {}, band_by);
  const auto shape = [&](const PlaceOffset& offset) {
    const double d = offset.disparity;
    return power == 0 ? 1 : power == 1 ? d : d * d;
  };
  double sum = 0;
  double weight = 0;
  std::vector<double> ratios;
  for (size_t band = 0; band < bands; ++band) {
    const std::span<const PlaceOffset> all = offsets;
    const size_t begin = all.size() * band / bands;
    const std::span<const PlaceOffset> part =
        all.subspan(begin, all.size() * (band + 1) / bands - begin);
    ratios.clear();
    for (const PlaceOffset& offset : part) ratios.push_back(offset.offset_px / shape(offset));
    const double middle = Median(ratios);
    for (const PlaceOffset& offset : part) {
      const double left_px = std::abs(offset.offset_px - middle * shape(offset));
      sum += offset.weight * std::min(left_px, RangeRules::kMaxResidualPx);
      weight += offset.weight;
    }
  }
  return sum / weight;
}

bool ShiftsRows(std::vector<PlaceOffset> places) {
  // At infinity an offset of the rows is one of the depth, too.
  std::erase_if(places, [](const PlaceOffset& place) {
    return !(place.weight > 0 && place.disparity > RangeRules::kMinShiftPx);
  });
  if (places.size() < RangeRules::kMinFieldNodes) return false;
  const double all = LeftOver(places, &PlaceOffset::row, 1, 0);
  if (all < RangeRules::kMinShiftPx) return false;
  constexpr size_t kBands = RangeRules::kShiftBands;
  const double by_row = LeftOver(places, &PlaceOffset::row, kBands, 0);
  if (by_row > RangeRules::kShiftLeft * all) return false;
  const double by_others = std::min({LeftOver(places, &PlaceOffset::row, kBands, 1),
                                     LeftOver(places, &PlaceOffset::row, kBands, 2),
                                     LeftOver(places, &PlaceOffset::disparity, kBands, 0)});
  return by_row < RangeRules::kShiftBetter * by_others;
}

}  // namespace

bool ShiftsRows(const RangeNodes& nodes, std::span<const double> offsets_px, double infinity_px) {
  // Right sensors take no time.
  if (std::ranges::all_of(offsets_px, [](double px) { return px == 0; })) return false;
  std::vector<PlaceOffset> places;
  places.reserve(offsets_px.size());
  for (size_t i = 0; i < offsets_px.size(); ++i) {
    const RangeNode& node = nodes.nodes()[i];
    places.push_back({.row = node.at.y,
                      .disparity = node.disparity - infinity_px,
                      .offset_px = offsets_px[i],
                      .weight = node.distinctness});
  }
  return ShiftsRows(std::move(places));
}

bool ShiftsRows(const PlacedPoints& points, std::span<const Seed> matches) {
  const double wide = std::max(1.0, points.spacing_px.width);
  const double high = std::max(1.0, points.spacing_px.height);
  cv::Mat1f beside(static_cast<int>(points.image.height / high) + 1,
                   static_cast<int>(points.image.width / wide) + 1,
                   std::numeric_limits<float>::quiet_NaN());
  const auto cell_of = [&](const Seed& seed) {
    return cv::Point(cvFloor(seed.u / wide), cvFloor(seed.v / high));
  };
  for (const ProjectedPoint& point : points.corrected) {
    const cv::Point cell = cell_of(point.seed);
    if (cv::Rect({}, beside.size()).contains(cell)) beside(cell) = point.seed.disparity();
  }
  std::vector<PlaceOffset> places;
  for (const Seed& match : matches) {
    const double disparity = beside(cell_of(match));
    if (std::isnan(disparity)) continue;
    places.push_back({.row = match.v,
                      .disparity = disparity - points.infinity_px,
                      .offset_px = match.disparity() - disparity});
  }
  return ShiftsRows(std::move(places));
}

}  // namespace sprout::refine
