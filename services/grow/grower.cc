#include "services/grow/grower.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

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
  int step;  // from the disparity to the sub-pixel one, counts
};

// Where between d − 1 and d + 1 the parabola through their costs has its minimum, from d, counts.
// Whole numbers only; at most half a pixel, as d is the best of the three.
int SubPixelStep(const CostTriple& costs) {
  const int64_t before = int64_t{costs[0]} - costs[1];
  const int64_t behind = int64_t{costs[2]} - costs[1];
  if (before < 0 || behind < 0 || before + behind == 0) return 0;
  // Half a pixel times (before − behind) / (before + behind), rounded to nearest.
  constexpr int64_t kHalf = DisparityImage::kCountsPerPixel / 2;
  const int64_t sum = before + behind;
  return static_cast<int>((2 * kHalf * (before - behind) + 2 * kHalf * sum + sum) / (2 * sum) -
                          kHalf);
}

// Standard deviation of the seeds' disparities from the prior, px, from the median: what the
// prior's smoothing took off, so an estimate of the seeds' noise.
double NoiseOfSeeds(std::span<const Seed> seeds, const DisparityImage& prior) {
  std::vector<double> deviations;
  for (const Seed& seed : seeds) {
    const cv::Point pixel(static_cast<int>(std::lround(seed.u)),
                          static_cast<int>(std::lround(seed.v)));
    if (!cv::Rect({}, prior.size()).contains(pixel) || !prior.IsValid(pixel.x, pixel.y)) continue;
    deviations.push_back(std::abs(double{seed.disparity()} - prior.Px(pixel.x, pixel.y)));
  }
  if (deviations.empty()) return 0;
  const auto middle = deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2);
  std::nth_element(deviations.begin(), middle, deviations.end());
  constexpr double kMedianOfNormal = 0.6745;  // of the absolute value, in standard deviations
  return *middle / kMedianOfNormal;
}

// One run of Alg. 1 over one pair of images.
template <typename Cost>
class Growth {
 public:
  Growth(const Cost& cost, const GrowConfig& config, cv::Size size, SeedQueue& queue)
      : cost_(cost),
        limit_(Cost::Limit(config.threshold())),
        sub_pixel_(config.sub_pixel()),
        centres_(WindowCentres(size)),
        queue_(queue),
        map_(size),  // Alg. 1, step 3
        right_matched_(size, uint8_t{0}) {
    queue_.Reset(limit_);
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
        Write(u, v, best);                                                          // Step 10
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
    Match best{d, kNoMatch, 0};
    if (u - d < kWindowRadius - 1) return best;  // even d − 1 leaves the right image
    const CostTriple costs = cost_.At(u, v, d);
    for (const int i : {1, 0, 2}) {
      if (costs[i] < best.cost && Fits(u, v, d - 1 + i)) best = {d - 1 + i, costs[i], 0};
    }
    if (sub_pixel_ && best.cost <= limit_)
      best.step = SubPixelStepAt(u, v, best.disparity, d, costs);
    return best;
  }

  // @param costs  around `centre`, a neighbour of d or d itself. None where a disparity beside d
  //               leaves the right image.
  int SubPixelStepAt(int u, int v, int d, int centre, const CostTriple& costs) const {
    if (!Fits(u, v, d - 1) || !Fits(u, v, d + 1)) return 0;
    return SubPixelStep(d == centre ? costs : cost_.At(u, v, d));
  }

  bool IsRightMatched(int u_right, int v) const { return right_matched_(v, u_right) != 0; }

  void Write(int u, int v, const Match& match) {
    const int counts = match.disparity * DisparityImage::kCountsPerPixel + match.step;
    map_.counts()(v, u) = static_cast<int16_t>(counts);
    right_matched_(v, u - match.disparity) = 1;
  }

  const Cost& cost_;
  int32_t limit_;
  bool sub_pixel_;
  cv::Rect centres_;
  SeedQueue& queue_;
  DisparityImage map_;
  cv::Mat1b right_matched_;
};

template <typename Cost>
DisparityImage RunGrowth(const Cost& cost, const GrowConfig& config, cv::Size size,
                         std::span<const Seed> seeds, SeedQueue& queue) {
  Growth<Cost> growth(cost, config, size, queue);
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
  switch (config_.similarity()) {
    case GrowConfig::MNCC:
      return RunGrowth(MnccCost(left, right), config_, size, seeds, queue_);
    case GrowConfig::EXPSSD:
      return RunGrowth(ExpssdCost(left, right, config_.sigma_s_squared()), config_, size, seeds,
                       queue_);
    case GrowConfig::EPC:
      if (prior.size() != size) {
        return Fail("prior of " + SizeText(prior.size()) + ": allowed is the images' size " +
                    SizeText(size));
      }
      return RunGrowth(EpcCost(left, right, prior, config_.sigma_s_squared(), SigmaP(seeds, prior)),
                       config_, size, seeds, queue_);
  }
  return Fail("unknown similarity");
}

double Grower::SigmaP(std::span<const Seed> seeds, const DisparityImage& prior) const {
  if (config_.sigma_p_noise() == 0) return config_.sigma_p_px();
  return std::max(config_.sigma_p_px(), config_.sigma_p_noise() * NoiseOfSeeds(seeds, prior));
}

}  // namespace sprout
