#include "services/refine/alignment/scan_alignment.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "services/refine/alignment/alignment_rules.h"
#include "services/refine/alignment/tof_alignment.h"
#include "services/refine/range/range_costs.h"

namespace sprout::refine {
namespace {

using Rules = AlignmentRules;

// Eq. (A7): how much more a disparity costs than the best one around it.
float ExcessOf(const OffsetCosts& costs, double offset_px) {
  const float least = *std::ranges::min_element(costs);
  return std::min(static_cast<float>(CostAt(costs, offset_px)) - least, Rules::kMaxExcess);
}

double Mean(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double RollRad(const RectifiedPair& pair, double px_at_half_width) {
  return 2 * px_at_half_width / pair.width;
}

// Eqs. (A9) and (A10): first nearer, then turned. What is then behind the cameras gets a place
// outside the image.
SlantedPatch Moved(const RectifiedPair& pair, const RangeNode& node, const Eigen::Vector4d& move) {
  const cv::Point2d centre(pair.cx, pair.cy);
  const double infinity_px = pair.cx - pair.cx_right;
  const double nearer = move.z() / (pair.focal_px * pair.baseline_m);
  const double disparity = node.disparity - infinity_px;
  const double growth = 1 / (1 - nearer * disparity);
  if (!(growth > 0)) return {{-1, -1}, 0, {}};
  const double at_centre = disparity - node.slope.dot(node.at - centre);
  const cv::Point2d ray = growth / pair.focal_px * (node.at - centre);
  const cv::Point2d turn(move.x(), move.y());
  const double along = turn.dot(ray);
  const cv::Point2d roll = RollRad(pair, move.w()) * pair.focal_px * cv::Point2d(-ray.y, ray.x);
  return {centre + pair.focal_px * ray + turn + along * ray + roll,
          growth * disparity * (1 + along / pair.focal_px) + infinity_px,
          node.slope / (1 - nearer * at_centre)};
}

}  // namespace

// Makes nodes of up to `most` points, spread over the scan, whose windows lie in both images.
void ScanAligner::Take(const RangeInput& input, std::span<const ProjectedPoint> points,
                       size_t most) {
  const size_t count = std::min(points.size(), most);
  const double tolerance_px = RangeRules::kSurfacePx + RangeRules::kNoiseSigmas * input.noise_px;
  constexpr float kUnknown = -1;
  nodes_.resize(count);
  ForEachParallel(count, [&](size_t i) {
    const ProjectedPoint& point = points[i * points.size() / count];
    const TofSurface::Plane plane = input.surface.PlaneOf(point, tolerance_px);
    RangeNode& node = nodes_[i];
    node = {.cell = input.surface.CellOf(point),
            .at = {point.seed.u, point.seed.v},
            .disparity = plane.disparity,
            .slope = plane.slope,
            .moments = {},
            .distinctness = kUnknown};
    // Steeper planes lie across an edge.
    if (std::max(std::abs(node.slope.x), std::abs(node.slope.y)) > RangeRules::kSteepest) {
      node.slope = {};
    }
    const auto moments = MomentsOf(input.left, input.right, {node.at, node.disparity, node.slope});
    if (!moments) return;
    node.costs = CostsOf(*moments, RangeRules::kUnlikeVariance);
    node.distinctness = DistinctnessOf(node.costs);
  });
  std::erase_if(nodes_, [](const RangeNode& node) { return node.distinctness == kUnknown; });
  excess_here_.clear();
  std::vector<double> disparities;
  for (const RangeNode& node : nodes_) {
    excess_here_.push_back(ExcessOf(node.costs, 0));
    disparities.push_back(node.disparity);
  }
  if (nodes_.empty()) return;
  const RectifiedPair& pair = input.rig.pair;
  const double near_m = pair.DepthFromDisparity(Quantile(disparities, Rules::kNearQuantile));
  m_per_px_ = near_m * near_m / (pair.focal_px * pair.baseline_m);
}

// The excess of all nodes when moved; those that leave the images keep the one they have.
void ScanAligner::Look(const RangeInput& input, const Move& move,
                       std::vector<float>& excess) const {
  excess.resize(nodes_.size());
  ForEachParallel(nodes_.size(), [&](size_t i) {
    const auto moments = MomentsOf(input.left, input.right, Moved(input.rig.pair, nodes_[i], move));
    excess[i] =
        moments ? ExcessOf(CostsOf(*moments, RangeRules::kUnlikeVariance), 0) : excess_here_[i];
  });
}

// Eq. (A8), from where the search starts.
double ScanAligner::CostOf(const RangeInput& input, const Move& move) {
  if (move.isZero(0)) return Mean(excess_here_);
  const Move way = move - start_;
  const double length_px = Move(way.x(), way.y(), way.z() / m_per_px_, way.w()).norm();
  if (!(length_px <= Rules::kMaxMovePx)) return std::numeric_limits<double>::infinity();
  Look(input, move, excess_);
  return Mean(excess_) + Rules::kMovePenalty * length_px;
}

// One step along each axis; down half as long, since the ground shows moves down better.
std::vector<ScanAligner::Move> ScanAligner::StepsOf(double step_px, Freedom freedom) const {
  std::vector<Move> steps = {{step_px, 0, 0, 0}, {0, std::max(1.0, step_px / 2), 0, 0}};
  if (freedom == Freedom::kTurnAndMotion) steps.push_back({0, 0, step_px * m_per_px_, 0});
  if (freedom == Freedom::kTurnAndRoll) steps.push_back({0, 0, 0, step_px});
  return steps;
}

// The move that costs least, axis by axis, by steps that are halved.
ScanAligner::Move ScanAligner::Descend(const RangeInput& input, Move from, double step_px,
                                       Freedom freedom) {
  double least = CostOf(input, from);
  for (int sweep = 0; sweep < Rules::kMaxSweeps; ++sweep) {
    const Move before = from;
    for (const Move& step : StepsOf(step_px, freedom)) {
      const Move start = from;
      for (const Move& way : {step, Move(-step)}) {
        if (from != start) break;
        double cost = CostOf(input, from + way);
        while (cost < least) {
          least = cost;
          from = from + way;
          cost = CostOf(input, from + way);
        }
      }
    }
    if (step_px == 1 && from == before) break;
    step_px = std::max(1.0, step_px / 2);
  }
  return from;
}

// By how many standard deviations the images prefer one place to another, over blocks within which
// mistakes go together: windows that overlap.
double ScanAligner::GainInSigmas(const std::vector<float>& before,
                                 const std::vector<float>& after) const {
  constexpr double kBlockPx = Rules::kBlockWindows * (2 * RangeRules::kWindowRadius + 1);
  std::map<std::pair<int, int>, double> blocks;
  double gain = 0;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const double less = double{before[i]} - double{after[i]};
    gain += less;
    blocks[{static_cast<int>(nodes_[i].at.x / kBlockPx),
            static_cast<int>(nodes_[i].at.y / kBlockPx)}] += less;
  }
  double variance = 0;
  for (const auto& [place, less] : blocks) variance += less * less;
  return variance > 0 ? gain / std::sqrt(variance) : 0;
}

// How much less the nodes cost without an error of the ranges that all share.
double ScanAligner::CurveGain(const RangeInput& input) {
  curve_.Estimate(nodes_, input.rig.pair, /*stiff=*/true);
  double gain = 0;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const double offset_px = curve_.OffsetPx(input.rig.pair, nodes_[i].disparity);
    gain += double{excess_here_[i]} - double{ExcessOf(nodes_[i].costs, offset_px)};
  }
  return gain / static_cast<double>(nodes_.size());
}

// Searches on from a candidate, in the finest steps and with the present nodes.
void ScanAligner::Refine(const RangeInput& input, Freedom freedom, Candidate& candidate) {
  candidate.move = Descend(input, candidate.move, 1, freedom);
  Look(input, candidate.move, candidate.excess);
}

// Whether a first step to any side helps; right scans end here.
bool ScanAligner::MayBeOff(const RangeInput& input) {
  const double here = CostOf(input, Move::Zero());
  const auto is_better = [&](const Move& move) { return CostOf(input, move) < here; };
  std::vector<Move> first = StepsOf(Rules::kFirstStepPx, Freedom::kTurnAndMotion);
  first.push_back(StepsOf(Rules::kFirstStepPx, Freedom::kTurnAndRoll).back());
  return std::ranges::any_of(first,
                             [&](const Move& step) { return is_better(step) || is_better(-step); });
}

ScanMove ScanAligner::Estimate(const RangeInput& input, std::span<const ProjectedPoint> points,
                               const cv::Point2d* start_px) {
  start_ = Move::Zero();
  if (start_px != nullptr) start_.head<2>() << start_px->x, start_px->y;
  Take(input, points, Rules::kFirstScanPoints);
  if (nodes_.size() < Rules::kMinScanPoints) return {};
  if (start_px == nullptr && !MayBeOff(input)) return {};
  turn_.move = Descend(input, start_, Rules::kFirstStepPx, Freedom::kTurn);
  roll_.move = Descend(input, start_, Rules::kFirstStepPx, Freedom::kTurnAndRoll);
  motion_.move = Descend(input, start_, Rules::kFirstStepPx, Freedom::kTurnAndMotion);
  Take(input, points, Rules::kMaxScanPoints);
  Refine(input, Freedom::kTurn, turn_);
  Refine(input, Freedom::kTurnAndRoll, roll_);
  Refine(input, Freedom::kTurnAndMotion, motion_);
  const double roll_sigmas = GainInSigmas(turn_.excess, roll_.excess);
  const double motion_sigmas = GainInSigmas(turn_.excess, motion_.excess);
  const bool is_rolled = roll_sigmas >= Rules::kRollSigmas && roll_sigmas > motion_sigmas;
  const bool has_moved =
      motion_sigmas >= (motion_.move.z() > 0 ? Rules::kNearerSigmas : Rules::kFartherSigmas);
  const Candidate& best = is_rolled ? roll_ : has_moved ? motion_ : turn_;
  const double sigmas = GainInSigmas(excess_here_, best.excess);
  return {.du_px = best.move.x(),
          .dv_px = best.move.y(),
          .roll_rad = RollRad(input.rig.pair, best.move.w()),
          .nearer_m = best.move.z(),
          .significance = sigmas,
          .is_off = sigmas >= Rules::kMoveSigmas &&
                    Mean(excess_here_) - Mean(best.excess) > CurveGain(input)};
}

void ApplyMove(const ScanMove& move, const Rig& rig, std::vector<ProjectedPoint>& points) {
  for (ProjectedPoint& point : points) {
    Eigen::Vector3d place = PointFromSeed(rig.pair, point.seed);
    place.z() -= move.nearer_m;
    if (!(place.z() > 0)) continue;
    const Seed seed = ProjectToPair(rig.pair, place);
    const auto across = static_cast<float>(-move.roll_rad * (seed.v - rig.pair.cy));
    const auto down = static_cast<float>(move.roll_rad * (seed.u - rig.pair.cx));
    point.seed.u = seed.u + across;
    point.seed.v = seed.v + down;
    point.seed.u_right = seed.u_right + across;
  }
  ApplyOffset({.du_px = move.du_px, .dv_px = move.dv_px}, rig, points);
}

std::string ScanMoveText(const ScanMove& move) {
  std::string beside =
      fmt::format("({:+.0f}, {:+.0f}) px in the left image", move.du_px, move.dv_px);
  if (move.roll_rad != 0) {
    beside += fmt::format(" and rolled by {:+.2f}°", move.roll_rad * 180 / std::numbers::pi);
  }
  if (move.nearer_m == 0) {
    return "the lidar's points fit the pair when moved by " + beside +
           ", and were: it is turned, or it measures at another moment";
  }
  return fmt::format(
      "the lidar's points fit the pair when moved by {} and {:.2f} m {}, and were: it measures at "
      "another moment",
      beside, std::abs(move.nearer_m), move.nearer_m > 0 ? "nearer" : "farther");
}

}  // namespace sprout::refine
