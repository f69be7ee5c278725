#include "services/grow/grower.h"

#include <cmath>
#include <string>

#include "common/core/image.h"
#include "services/grow/similarity.h"

namespace sprout {
namespace {

// Steps to the four neighbours, in the order in which they are visited.
struct Step {
  int du;
  int dv;
};
constexpr Step kNeighbours[] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};

// Pixels whose window lies in the image.
cv::Rect WindowCentres(cv::Size size) {
  return {kWindowRadius, kWindowRadius, size.width - 2 * kWindowRadius,
          size.height - 2 * kWindowRadius};
}

struct Match {
  int disparity;
  int32_t cost;
};

// One run of Alg. 1 over one pair of images.
template <typename Cost>
class Growth {
 public:
  Growth(const Cost& cost, int32_t limit, cv::Size size, SeedQueue& queue)
      : cost_(cost),
        limit_(limit),
        centres_(WindowCentres(size)),
        queue_(queue),
        map_(size),  // Alg. 1, step 3
        right_matched_(size, uint8_t{0}) {
    queue_.Reset(limit);
  }

  // Alg. 1, step 2: similarity of every seed.
  void AddSeed(const Seed& seed) {
    const auto u = static_cast<int>(std::lround(seed.u));
    const auto v = static_cast<int>(std::lround(seed.v));
    const auto d = static_cast<int>(std::lround(seed.disparity()));
    if (!Fits(u, v, d)) return;
    queue_.Push(Queued(u, v, d), cost_.At(u, v, d)[1]);
  }

  DisparityImage Run() {
    while (const std::optional<QueuedSeed> seed = queue_.Pop()) {  // Alg. 1, steps 4, 5, 13
      for (const Step& step : kNeighbours) {                       // Alg. 1, step 6
        const int u = seed->u + step.du;
        const int v = seed->v + step.dv;
        if (!centres_.contains({u, v}) || map_.IsValid(u, v)) continue;
        const Match best = BestOfThree(u, v, seed->disparity);
        if (best.cost > limit_ || IsRightMatched(u - best.disparity, v)) continue;  // Steps 7, 8
        queue_.Push(Queued(u, v, best.disparity), best.cost);                       // Step 9
        Write(u, v, best.disparity);                                                // Step 10
      }
    }
    return map_;  // Alg. 1, step 14
  }

 private:
  static QueuedSeed Queued(int u, int v, int d) {
    return {static_cast<int16_t>(u), static_cast<int16_t>(v), static_cast<int16_t>(d)};
  }

  bool Fits(int u, int v, int d) const {
    return d >= 0 && centres_.contains({u, v}) && centres_.contains({u - d, v});
  }

  // The best of N(s) at one neighbour: the disparities d − 1, d and d + 1.
  Match BestOfThree(int u, int v, int d) const {
    Match best{d, kNoMatch};
    if (u - d < kWindowRadius - 1) return best;  // even d − 1 leaves the right image
    const CostTriple costs = cost_.At(u, v, d);
    for (const int i : {1, 0, 2}) {
      if (costs[i] < best.cost && Fits(u, v, d - 1 + i)) best = {d - 1 + i, costs[i]};
    }
    return best;
  }

  bool IsRightMatched(int u_right, int v) const { return right_matched_(v, u_right) != 0; }

  void Write(int u, int v, int d) {
    map_.counts()(v, u) = static_cast<int16_t>(d * DisparityImage::kCountsPerPixel);
    right_matched_(v, u - d) = 1;
  }

  const Cost& cost_;
  int32_t limit_;
  cv::Rect centres_;
  SeedQueue& queue_;
  DisparityImage map_;
  cv::Mat1b right_matched_;
};

template <typename Cost>
DisparityImage RunGrowth(const Cost& cost, double threshold, cv::Size size,
                         std::span<const Seed> seeds, SeedQueue& queue) {
  Growth<Cost> growth(cost, Cost::Limit(threshold), size, queue);
  for (const Seed& seed : seeds) growth.AddSeed(seed);
  return growth.Run();
}

}  // namespace

Grower::Grower(const GrowConfig& config) : config_(config) { RequireInRange(config, "grow"); }

Result<DisparityImage> Grower::Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                       std::span<const Seed> seeds, const DisparityImage& prior) {
  const cv::Size size = left.size();
  if (right.size() != size) {
    return Fail("images of " + SizeText(size) + " and " + SizeText(right.size()) +
                ": allowed are two of one size");
  }
  if (size.width < kWindow || size.height < kWindow) {
    return Fail("images of " + SizeText(size) + ": smaller than the 5x5 window");
  }
  const double threshold = config_.threshold();
  switch (config_.similarity()) {
    case GrowConfig::MNCC:
      return RunGrowth(MnccCost(left, right), threshold, size, seeds, queue_);
    case GrowConfig::EXPSSD:
      return RunGrowth(ExpssdCost(left, right, config_.sigma_s_squared()), threshold, size, seeds,
                       queue_);
    case GrowConfig::EPC:
      if (prior.size() != size) {
        return Fail("prior of " + SizeText(prior.size()) + ": allowed is the images' size " +
                    SizeText(size));
      }
      return RunGrowth(EpcCost(left, right, prior, config_.sigma_s_squared(), config_.sigma_p_px()),
                       threshold, size, seeds, queue_);
  }
  return Fail("unknown similarity");
}

}  // namespace sprout
