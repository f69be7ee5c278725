#include "services/refine/surface/image_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "common/core/quantile.h"
#include "common/core/window_sums.h"
#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {
namespace {

constexpr int kNoiseRadius = SurfaceRules::kRadius;
constexpr int kReach = SurfaceRules::kMatchReachPx;

struct Match {
  double sharpness = 0;     // of the minimum: curvature over the difference that is left
  double deviation_px = 0;  // from the point's disparity
};

// Where the windows of a point differ least; nothing where that is on the end of the range.
std::optional<Match> MatchOf(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& seed) {
  const double u = std::round(double{seed.u});
  const double u_right = u - seed.disparity();
  if (!IsInside(u, seed.v, left.size(), kNoiseRadius - 0.5) ||
      !IsInside(u_right, seed.v, right.size(), kNoiseRadius + kReach, kNoiseRadius - 0.5)) {
    return {};
  }
  const cv::Point at_left(static_cast<int>(u), static_cast<int>(std::lround(seed.v)));
  const int first = static_cast<int>(std::lround(u_right)) - kReach;
  std::array<int, 2 * kReach + 1> differences{};
  for (int i = 0; i <= 2 * kReach; ++i) {
    const WindowSums sums = SumWindows<kNoiseRadius>(left, right, at_left, {first + i, at_left.y});
    differences[static_cast<size_t>(i)] =
        sums.left_squares + sums.right_squares - 2 * sums.products;
  }
  const auto best = std::min_element(differences.begin(), differences.end());
  if (best == differences.begin() || best + 1 == differences.end()) return {};
  const int curvature = best[-1] - 2 * best[0] + best[1];
  if (curvature <= 0) return {};
  const double fraction = (best[-1] - best[1]) / (2.0 * curvature);
  const double column = first + static_cast<double>(best - differences.begin()) + fraction;
  return Match{curvature / (best[0] + 1.0), std::abs(column - u_right)};
}

}  // namespace

double ImageNoisePx(const cv::Mat1b& left, const cv::Mat1b& right,
                    std::span<const ProjectedPoint> points) {
  std::vector<Match> matches;
  for (size_t i = 0; i < points.size(); i += points.size() / SurfaceRules::kMatchedPoints + 1) {
    if (const auto match = MatchOf(left, right, points[i].seed)) matches.push_back(*match);
  }
  if (matches.empty()) return std::numeric_limits<double>::infinity();
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.sharpness > b.sharpness; });
  matches.resize((matches.size() + SurfaceRules::kSharpest - 1) / SurfaceRules::kSharpest);
  std::vector<double> deviations;
  for (const Match& match : matches) deviations.push_back(match.deviation_px);
  const double sigma_px = Quantile(deviations, 0.5) / SurfaceRules::kMedianOfNormal;
  constexpr double kMatch = SurfaceRules::kMatchSigmaPx;
  return std::sqrt(std::max(0.0, sigma_px * sigma_px - kMatch * kMatch));
}

}  // namespace sprout::refine
