#include "services/refine/range/pair_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "services/refine/range/range_rules.h"

namespace sprout::refine {
namespace {

constexpr auto& kMoves = RangeRules::kRowMoves;
using RowCosts = std::array<double, std::size(RangeRules::kRowMoves)>;

// The least cost of a node for each move of the rows; nothing where a window leaves an image.
std::optional<RowCosts> CostsOf(const RangeInput& input, const RangeNode& node, double noise) {
  RowCosts costs;
  for (size_t k = 0; k < costs.size(); ++k) {
    const int above = std::max(0, -kMoves[k]);
    const int below = std::max(0, kMoves[k]);
    const int rows = input.left.rows;
    if (above + below >= rows) return {};
    const auto moments = MomentsOf(input.left.rowRange(above, rows - below),
                                   input.right.rowRange(below, rows - above),
                                   {node.at - cv::Point2d(0, above), node.disparity, node.slope});
    if (!moments) return {};
    const OffsetCosts of_offsets = refine::CostsOf(*moments, noise);
    costs[k] = std::min(RangeRules::kMaxCost, *std::ranges::min_element(of_offsets));
  }
  return costs;
}

}  // namespace

PairFit PairFitAt(const RangeInput& input, const RangeNodes& nodes) {
  const double noise = RangeRules::kUnlikeVariance + nodes.noise();
  std::vector<const RangeNode*> clear;
  for (const RangeNode& node : nodes.nodes()) {
    const double signal = node.moments.left_variance - noise;
    if (node.whole && signal > RangeRules::kClearSignal * noise) clear.push_back(&node);
  }
  if (clear.size() < RangeRules::kMinFitNodes) return {};
  constexpr int kSide = RangeRules::kRowBlocks;
  std::array<RowCosts, size_t{kSide} * kSide> blocks{};
  double count = 0;
  const size_t step = clear.size() / RangeRules::kMaxFitNodes + 1;
  for (size_t i = 0; i < clear.size(); i += step) {
    const RangeNode& node = *clear[i];
    const std::optional<RowCosts> costs = CostsOf(input, node, noise);
    if (!costs) continue;
    ++count;
    const auto part_of = [](double at, int side) {
      return std::clamp(static_cast<int>(at * kSide / side), 0, kSide - 1);
    };
    const int block =
        part_of(node.at.y, input.left.rows) * kSide + part_of(node.at.x, input.left.cols);
    RowCosts& sum = blocks[static_cast<size_t>(block)];
    for (size_t k = 0; k < sum.size(); ++k) sum[k] += (*costs)[k];
  }
  RowCosts of_all{};
  double best = 0;
  double most_rows = 0;
  for (const RowCosts& sum : blocks) {
    for (size_t k = 0; k < sum.size(); ++k) of_all[k] += sum[k];
    const auto least = std::ranges::min_element(sum);
    best += *least;
    most_rows = std::max(most_rows, static_cast<double>(std::abs(kMoves[least - sum.begin()])));
  }
  const double here = of_all[0];
  if (!(here > 0)) return {};
  const double together = *std::ranges::min_element(of_all);
  return {.cost = here / count,
          .rows_gain = 1 - best / here,
          .uneven_gain = 1 - best / together,
          .most_rows_px = most_rows};
}

}  // namespace sprout::refine
