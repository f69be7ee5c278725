#include "services/refine/range/range_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "common/core/parallel.h"

namespace sprout::refine {
namespace {

constexpr int kCandidates = RangeRules::kCurveCandidates;
constexpr int kNoError = kCandidates / 2;
using Votes = std::array<double, kCandidates>;

// What a disparity has to be moved by when its depth is too large by error_m.
double OffsetOfError(const RectifiedPair& pair, double depth_m, double error_m) {
  const double fb = pair.focal_px * pair.baseline_m;
  return fb / std::max(depth_m - error_m, depth_m / 4) - fb / depth_m;
}

double VoteAt(const RangeNode& node, double offset_px) {
  return std::min(CostAt(node.costs, offset_px), double{node.max_vote});
}

// Sums of votes, by blocks of the range image.
class BlockSums {
 public:
  explicit BlockSums(cv::Size blocks)
      : rows_(blocks.height), sums_(static_cast<size_t>(blocks.area())) {}

  static cv::Point BlockOf(const RangeNode& node) { return node.cell / RangeRules::kBlockCells; }

  void Add(const RangeNode& node, double value) {
    const cv::Point block = BlockOf(node);
    sums_[static_cast<size_t>(block.x * rows_ + block.y)] += value;
  }
  double Total() const { return std::accumulate(sums_.begin(), sums_.end(), 0.0); }
  // Standard deviation of the total when blocks are independent.
  double Sigma() const {
    return std::sqrt(std::inner_product(sums_.begin(), sums_.end(), sums_.begin(), 0.0));
  }

 private:
  int rows_;
  std::vector<double> sums_;
};

}  // namespace

double CostAt(const OffsetCosts& costs, double offset_px) {
  const double label =
      std::clamp(offset_px + RangeRules::kZeroLabel, 0.0, RangeRules::kLabels - 1.0);
  const int nearest = std::clamp(static_cast<int>(label + 0.5), 1, RangeRules::kLabels - 2);
  const auto at = static_cast<size_t>(nearest);
  const double x = label - nearest;
  const double before = costs[at - 1];
  const double here = costs[at];
  const double behind = costs[at + 1];
  return here + x * (behind - before) / 2 + x * x * (before + behind - 2 * here) / 2;
}

// The voters of a knot, and what they say of each candidate.
struct RangeCurve::Bin {
  std::span<const Voter> voters;
  double depth_m = 0;
  double px_per_m = 0;
  Votes votes{};  // the mean of all voters
};

// λ₀, λ₁, λ₂ of eq. (R5).
struct RangeCurve::Penalties {
  double moved = RangeRules::kCurveMoved;
  double per_px = RangeRules::kCurvePerPx;
  double step = RangeRules::kCurveStep;
  // λ₂ counts in full between knots that are no farther apart.
  double full_gap_m = std::numeric_limits<double>::infinity();
};

void RangeCurve::Vote(std::span<const RangeNode> nodes, const RectifiedPair& pair, Bin& bin) const {
  double weight = 0;
  for (const Voter& voter : bin.voters) {
    bin.depth_m += voter.depth_m / static_cast<double>(bin.voters.size());
    const RangeNode& node = nodes[voter.node];
    weight += node.distinctness;
    for (int k = 0; k < kCandidates; ++k) {
      const double off = OffsetOfError(pair, voter.depth_m, (k - kNoError) * step_m_);
      bin.votes[static_cast<size_t>(k)] += node.distinctness * VoteAt(node, off);
    }
  }
  for (double& vote : bin.votes) vote /= weight;
  bin.px_per_m = pair.focal_px * pair.baseline_m / (bin.depth_m * bin.depth_m);
}

// The cheapest path through the candidates of all knots, then between candidates by a parabola.
void RangeCurve::FindPath(std::span<const Bin> bins, const Penalties& penalties) {
  const size_t count = bins.size();
  std::vector<Votes> costs(count);
  for (size_t b = 0; b < count; ++b) {
    costs[b] = bins[b].votes;
    for (int k = 0; k < kCandidates; ++k) {
      const double off_px = std::abs(k - kNoError) * step_m_ * bins[b].px_per_m;
      costs[b][static_cast<size_t>(k)] +=
          (k == kNoError ? 0 : penalties.moved) + penalties.per_px * off_px;
    }
  }
  std::vector<Votes> sums(count);
  std::vector<std::array<int, kCandidates>> from(count);
  sums[0] = costs[0];
  // The penalty of a metre, everywhere as high as where a metre shows most.
  const double near_penalty = penalties.step * step_m_ * bins[0].px_per_m;
  for (size_t b = 1; b < count; ++b) {
    const double gap_m = bins[b].depth_m - bins[b - 1].depth_m;
    const double penalty =
        near_penalty * std::clamp(penalties.full_gap_m / gap_m, RangeRules::kLeastStep, 1.0);
    for (int k = 0; k < kCandidates; ++k) {
      double best = std::numeric_limits<double>::infinity();
      for (int j = 0; j < kCandidates; ++j) {
        const double sum = sums[b - 1][static_cast<size_t>(j)] + penalty * std::abs(k - j);
        if (sum >= best) continue;
        best = sum;
        from[b][static_cast<size_t>(k)] = j;
      }
      sums[b][static_cast<size_t>(k)] = costs[b][static_cast<size_t>(k)] + best;
    }
  }
  std::vector<int> path(count);
  path.back() = static_cast<int>(std::min_element(sums.back().begin(), sums.back().end()) -
                                 sums.back().begin());
  for (size_t b = count - 1; b > 0; --b) path[b - 1] = from[b][static_cast<size_t>(path[b])];
  knots_.clear();
  for (size_t b = 0; b < count; ++b) {
    double candidate = path[b] - kNoError;
    const auto at = static_cast<size_t>(std::clamp(path[b], 1, kCandidates - 2));
    const double before = costs[b][at - 1];
    const double behind = costs[b][at + 1];
    const double curvature = before + behind - 2 * costs[b][at];
    if (path[b] != kNoError && curvature > 1e-6) {
      candidate += std::clamp((before - behind) / (2 * curvature), -0.5, 0.5);
    }
    knots_.push_back({bins[b].depth_m, candidate * step_m_, 0});
  }
}

// Penalties draw a curve to 0, so that it does not explain what the scene adds. Between points that
// are far apart little or nothing of that is seen, and a part of the error would stay.
void RangeCurve::Stiffen(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                         std::span<const Bin> bins) {
  const double bent_sigmas = GainInSigmas(nodes, pair);
  std::vector<RangeKnot> bent = knots_;
  FindPath(bins, {.moved = 0, .per_px = 0, .step = RangeRules::kStiffStep});
  if (GainInSigmas(nodes, pair) < bent_sigmas - RangeRules::kBentSigmas) knots_ = std::move(bent);
  TryScale(nodes, pair);
}

// The constant error (power 0), or the part of the depth (power 1), that the nodes prefer.
double RangeCurve::BestFactor(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                              int power) const {
  const double near_m = power == 0 ? voters_[voters_.size() / 10].depth_m : 1;
  const double step = RangeRules::kFactorStep * near_m;
  const auto cost_of = [&](double factor) {
    double cost = 0;
    for (const Voter& voter : voters_) {
      const double error_m = power == 0 ? factor : factor * voter.depth_m;
      const RangeNode& node = nodes[voter.node];
      cost += node.distinctness * VoteAt(node, OffsetOfError(pair, voter.depth_m, error_m));
    }
    return cost;
  };
  double best = 0;
  double least = cost_of(0);
  const auto try_factor = [&](double factor) {
    const double cost = cost_of(factor);
    if (cost >= least) return;
    best = factor;
    least = cost;
  };
  constexpr int kSteps = static_cast<int>(RangeRules::kMaxFactor / RangeRules::kFactorStep);
  for (int k = -kSteps; k <= kSteps; ++k) try_factor(k * step);
  const double middle = best;
  for (const double part : {-0.5, -0.25, 0.25, 0.5}) try_factor(middle + part * step);
  return best;
}

// A focal length or baseline that is wrong makes an error in proportion to the depth. Of that the
// candidates reach the near knots only, and penalties make it a constant.
void RangeCurve::TryScale(std::span<const RangeNode> nodes, const RectifiedPair& pair) {
  const double constant_m = BestFactor(nodes, pair, 0);
  const double part = BestFactor(nodes, pair, 1);
  if (std::abs(part) > RangeRules::kMaxDepthShare) return;  // no sensor's: the curve shows it
  const auto scaled = [&](double depth_m) { return part * depth_m; };
  const auto is_worse_than = [&](const auto& error_at) {
    return GainInSigmas(nodes, pair, scaled, error_at) < -RangeRules::kOtherSigmas;
  };
  if (is_worse_than([&](double) { return constant_m; })) return;
  if (is_worse_than([&](double depth_m) { return At(depth_m).error_m; })) return;
  for (RangeKnot& knot : knots_) knot.error_m = scaled(knot.depth_m);
}

// By how many standard deviations the nodes prefer the errors (m) at their depths to others.
template <typename ErrorAt, typename OtherAt>
double RangeCurve::GainInSigmas(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                                const ErrorAt& error_at, const OtherAt& other_at) const {
  BlockSums gains(blocks_);
  for (const Voter& voter : voters_) {
    const RangeNode& node = nodes[voter.node];
    const auto vote = [&](double error_m) {
      return VoteAt(node, OffsetOfError(pair, voter.depth_m, error_m));
    };
    gains.Add(node,
              node.distinctness * (vote(other_at(voter.depth_m)) - vote(error_at(voter.depth_m))));
  }
  const double sigma = gains.Sigma();
  return sigma > 0 ? gains.Total() / sigma : 0;
}

double RangeCurve::GainInSigmas(std::span<const RangeNode> nodes, const RectifiedPair& pair) const {
  const auto error_at = [&](double depth_m) { return At(depth_m).error_m; };
  return GainInSigmas(nodes, pair, error_at, [](double) { return 0.0; });
}

bool RangeCurve::IsShownRight(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                              double error_m) const {
  if (knots_.empty()) return false;
  const double near_m = knots_.front().depth_m;
  const double most_px = pair.focal_px * pair.baseline_m / (near_m * near_m) * error_m;
  if (most_px < RangeRules::kUnsurePx) return true;
  return std::ranges::all_of(std::array{error_m, -error_m}, [&](double off_m) {
    return GainInSigmas(
               nodes, pair, [&](double) { return off_m; }, [](double) { return 0.0; }) <
           -RangeRules::kRightSigmas;
  });
}

// The standard deviations of an M-estimate: the spread of the votes' slopes over their curvature.
void RangeCurve::SetSigmas(std::span<const RangeNode> nodes, const RectifiedPair& pair,
                           std::span<const Bin> bins) {
  ForEachParallel(bins.size(), [&](size_t b) {
    RangeKnot& knot = knots_[b];
    const double half_m = 0.5 / bins[b].px_per_m;
    BlockSums slopes(blocks_);
    double curvature = 0;
    for (const Voter& voter : bins[b].voters) {
      const RangeNode& node = nodes[voter.node];
      const auto vote = [&](double error_m) {
        return node.distinctness * VoteAt(node, OffsetOfError(pair, voter.depth_m, error_m));
      };
      const double more = vote(knot.error_m + half_m);
      const double less = vote(knot.error_m - half_m);
      slopes.Add(node, (more - less) / (2 * half_m));
      curvature += (more + less - 2 * vote(knot.error_m)) / (half_m * half_m);
    }
    knot.sigma_m =
        curvature > 0 ? slopes.Sigma() / curvature : std::numeric_limits<double>::infinity();
  });
}

void RangeCurve::Estimate(std::span<const RangeNode> nodes, const RectifiedPair& pair, bool stiff) {
  knots_.clear();
  voters_.clear();
  is_zero_ = true;
  blocks_ = {};
  for (size_t i = 0; i < nodes.size(); ++i) {
    const cv::Point block = BlockSums::BlockOf(nodes[i]);
    blocks_ = {std::max(blocks_.width, block.x + 1), std::max(blocks_.height, block.y + 1)};
    const double depth_m = pair.DepthFromDisparity(nodes[i].disparity);
    if (!(depth_m > 0 && std::isfinite(depth_m))) continue;
    if (nodes[i].distinctness > RangeRules::kMinDistinct) voters_.push_back({depth_m, i});
  }
  if (voters_.size() < RangeRules::kMinNodes) return;
  std::sort(voters_.begin(), voters_.end(), [](const Voter& a, const Voter& b) {
    return std::pair(a.depth_m, a.node) < std::pair(b.depth_m, b.node);
  });
  // The candidates reach as far as the labels do at the near tenth of the points.
  const double near_m = voters_[voters_.size() / 10].depth_m;
  step_m_ = near_m * near_m * RangeRules::kZeroLabel / (pair.focal_px * pair.baseline_m) / kNoError;
  const size_t count =
      std::clamp<size_t>(voters_.size() / RangeRules::kNodesPerKnot, 1, RangeRules::kMaxKnots);
  std::vector<Bin> bins(count);
  ForEachParallel(count, [&](size_t b) {
    const size_t begin = voters_.size() * b / count;
    const size_t end = voters_.size() * (b + 1) / count;
    bins[b].voters = std::span<const Voter>(voters_).subspan(begin, end - begin);
    Vote(nodes, pair, bins[b]);
  });
  const double full_gap_m =
      stiff ? std::numeric_limits<double>::infinity() : RangeRules::kNearKnotsM;
  FindPath(bins, {.full_gap_m = full_gap_m});
  is_zero_ = GainInSigmas(nodes, pair) < RangeRules::kSureSigmas;
  if (is_zero_) {
    for (RangeKnot& knot : knots_) knot.error_m = 0;
  } else if (stiff) {
    Stiffen(nodes, pair, bins);
  } else {
    FindPath(bins, {.moved = 0, .per_px = 0, .full_gap_m = full_gap_m});
  }
  SetSigmas(nodes, pair, bins);
}

void RangeCurve::BoundSigmas(double error_m) {
  const std::vector<RangeKnot> shown = knots_;
  for (RangeKnot& knot : knots_) {
    for (const RangeKnot& other : shown) {
      const double apart = std::abs(other.depth_m - knot.depth_m) / RangeRules::kAlikeOverM;
      knot.sigma_m = std::min(knot.sigma_m, std::hypot(other.sigma_m, apart * error_m));
    }
  }
}

RangeKnot RangeCurve::At(double depth_m) const {
  const auto behind = std::find_if(knots_.begin(), knots_.end(),
                                   [&](const RangeKnot& k) { return k.depth_m >= depth_m; });
  if (behind == knots_.begin()) return knots_.front();
  if (behind == knots_.end()) return knots_.back();
  const RangeKnot& before = behind[-1];
  const double part = (depth_m - before.depth_m) / (behind->depth_m - before.depth_m);
  return {depth_m, before.error_m + part * (behind->error_m - before.error_m),
          std::max(before.sigma_m, behind->sigma_m)};
}

double RangeCurve::OffsetPx(const RectifiedPair& pair, double disparity) const {
  const double depth_m = pair.DepthFromDisparity(disparity);
  if (is_zero_ || !(depth_m > 0)) return 0;
  return OffsetOfError(pair, depth_m, At(depth_m).error_m);
}

double RangeCurve::SigmaPx(const RectifiedPair& pair, double disparity) const {
  const double depth_m = pair.DepthFromDisparity(disparity);
  if (!(depth_m > 0)) return 0;
  return pair.focal_px * pair.baseline_m / (depth_m * depth_m) * At(depth_m).sigma_m;
}

}  // namespace sprout::refine
