#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <vector>

#include "services/grow/paper/plain_costs.h"
#include "services/grow/paper/plain_growth.h"

namespace sprout::grow {
namespace {

constexpr int kNone = -(1 << 14);  // px, where a pixel has no disparity

// A left pixel's claim on the right pixel (u − d, v).
struct Claim {
  int d = kNone;
  int32_t key = 0;  // GrowthRule::KeyOf() its cost
};

class PlainSweep {
 public:
  PlainSweep(const GrowthRule& rule, const GrowthInput& input)
      : rule_(rule),
        input_(input),
        claims_(static_cast<size_t>(input.left.size().area())),
        matched_(input.left.size(), kNone) {}

  DisparityImage Run(std::span<const Correspondence> seeds) {
    for (int v = 0; v < matched_.rows; ++v) {
      for (int u = 0; u < matched_.cols; ++u) ClaimAt(u, v) = Choose(u, v);  // (W1)
      Assign(v);                                                             // (W2)
    }
    const cv::Mat1b reached = Reach(seeds);                                     // (W3)
    for (int v = 0; v < matched_.rows; ++v) AssignFreed(v, Erase(v, reached));  // (W4), (W5)
    return ToCountsOfMap();
  }

 private:
  Claim& ClaimAt(int u, int v) { return claims_[static_cast<size_t>(v * matched_.cols + u)]; }

  // The disparity of the least cost, of equals the lowest; at least of ⌊D_p⌋ and the next one.
  Claim Choose(int u, int v) const {
    const int prior = input_.prior.disparity.counts()(v, u);
    if (prior == DisparityImage::kInvalid || rule_.IsOpen(input_.prior.sigma(v, u))) return {};
    // Eq. (5) alone rules out all others.
    const int reach = std::max(rule_.prior_reaches[input_.prior.sigma(v, u)], 31);
    int best = 0;
    int32_t least = kExcludedCost;
    for (int d = (prior - reach + 31) >> 5; d <= (prior + reach) >> 5; ++d) {
      const int32_t cost = CostWhereItFits(rule_, input_, {u, v, d});
      if (cost >= least) continue;
      least = cost;
      best = d;
    }
    if (least > rule_.limit) return {};
    return {best, rule_.KeyOf(least)};
  }

  // The claim with the least key wins a right pixel; if two claims have that key, none wins.
  void Assign(int v) {
    std::vector<int32_t> least(static_cast<size_t>(matched_.cols), INT32_MAX);
    std::vector<int> count_of_least(least.size());
    const auto for_each_claim = [&](const auto& act) {
      for (int u = 0; u < matched_.cols; ++u) {
        const Claim& claim = ClaimAt(u, v);
        if (claim.d != kNone) act(u, claim, static_cast<size_t>(u - claim.d));
      }
    };
    for_each_claim([&](int, const Claim& claim, size_t right) {
      if (claim.key < least[right]) count_of_least[right] = 0;
      least[right] = std::min(least[right], claim.key);
      if (claim.key == least[right]) ++count_of_least[right];
    });
    for_each_claim([&](int u, const Claim& claim, size_t right) {
      if (claim.key == least[right] && count_of_least[right] == 1) matched_(v, u) = claim.d;
    });
  }

  // Marks each seed's four neighbours, where they are within one disparity of it, and all that is
  // linked with them: neighbours within one disparity of each other.
  cv::Mat1b Reach(std::span<const Correspondence> seeds) const {
    cv::Mat1b reached(matched_.size(), uint8_t{0});
    std::vector<Correspondence> todo;
    const auto visit = [&](int u, int v, int d) {
      if (!cv::Rect({}, matched_.size()).contains({u, v}) || reached(v, u) != 0) return;
      if (matched_(v, u) == kNone || std::abs(matched_(v, u) - d) > 1) return;
      reached(v, u) = 1;
      todo.push_back({u, v, matched_(v, u)});
    };
    const auto visit_neighbours = [&](const Correspondence& q) {
      visit(q.u - 1, q.v, q.d);
      visit(q.u + 1, q.v, q.d);
      visit(q.u, q.v - 1, q.d);
      visit(q.u, q.v + 1, q.d);
    };
    for (const Correspondence& seed : seeds) visit_neighbours(seed);
    while (!todo.empty()) {
      const Correspondence last = todo.back();
      todo.pop_back();
      visit_neighbours(last);
    }
    return reached;
  }

  // Erases what no seed reaches. @returns the right pixels that become free.
  std::vector<bool> Erase(int v, const cv::Mat1b& reached) {
    std::vector<bool> free(static_cast<size_t>(matched_.cols), false);
    for (int u = 0; u < matched_.cols; ++u) {
      if (matched_(v, u) == kNone || reached(v, u) != 0) continue;
      free[static_cast<size_t>(u - matched_(v, u))] = true;
      matched_(v, u) = kNone;
      ClaimAt(u, v) = {};  // an erased pixel does not claim again
    }
    return free;
  }

  // Among the claims that lost against what has been erased those with the least key win, if they
  // continue what is matched on their left; then, from right to left, on their right.
  void AssignFreed(int v, std::vector<bool> free) {
    std::vector<int32_t> least(free.size(), INT32_MAX);
    const auto loses = [&](int u) { return ClaimAt(u, v).d != kNone && matched_(v, u) == kNone; };
    const auto right_of = [&](int u) { return static_cast<size_t>(u - ClaimAt(u, v).d); };
    for (int u = 0; u < matched_.cols; ++u) {
      if (loses(u)) least[right_of(u)] = std::min(least[right_of(u)], ClaimAt(u, v).key);
    }
    const auto take = [&](int u, int beside) {
      if (!loses(u) || !free[right_of(u)] || ClaimAt(u, v).key != least[right_of(u)]) return;
      const int d = ClaimAt(u, v).d;
      if (matched_(v, beside) == kNone || std::abs(matched_(v, beside) - d) > 1) return;
      free[right_of(u)] = false;
      matched_(v, u) = d;
    };
    for (int u = kWindowRadius; u < matched_.cols; ++u) take(u, u - 1);
    for (int u = matched_.cols - kWindowRadius; u-- > 0;) take(u, u + 1);
  }

  DisparityImage ToCountsOfMap() const {
    DisparityImage map(matched_.size());
    for (int v = 0; v < map.height(); ++v) {
      for (int u = 0; u < map.width(); ++u) {
        const int d = matched_(v, u);
        if (d == kNone) continue;
        const int step = rule_.sub_pixel ? SubPixelStep(rule_, input_, {u, v, d}) : 0;
        map.counts()(v, u) = static_cast<int16_t>(d * DisparityImage::kCountsPerPixel + step);
      }
    }
    return map;
  }

  const GrowthRule& rule_;
  const GrowthInput& input_;
  std::vector<Claim> claims_;
  cv::Mat1i matched_;  // px
};

}  // namespace

DisparityImage SweepPlainly(const GrowthRule& rule, const GrowthInput& input,
                            std::span<const Correspondence> seeds) {
  if (rule.min_open_sigma == 0) return DisparityImage(input.left.size());
  return PlainSweep(rule, input).Run(seeds);
}

}  // namespace sprout::grow
