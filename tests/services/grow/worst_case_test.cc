// Seeds that crowd must not take growth longer than those that are spread.
#include <gtest/gtest.h>

#include "services/grow/grow_adapter.h"
#include "tests/common/testing/worst_seeds.h"
#include "tests/services/grow/grow_scenes.h"

namespace sprout::grow {
namespace {

// How much the images and the prior say.
enum class Texture { kNone, kNoise };

PriorMap NoisyPrior(cv::Size size) {
  PriorMap prior(size);
  cv::RNG(3).fill(prior.disparity.counts(), cv::RNG::UNIFORM, 0,
                  100 * DisparityImage::kCountsPerPixel);
  cv::RNG(4).fill(prior.sigma, cv::RNG::UNIFORM, 1, 256);
  return prior;
}

void PrintTo(Texture texture, std::ostream* out) {
  *out << (texture == Texture::kNone ? "no texture" : "noise");
}

class WorstGrowth : public testing::TestWithParam<Texture> {};

TEST_P(WorstGrowth, TakesATimeInProportionToSeedsAndPixels) {
  const cv::Size size(640, 480);
  const bool noisy = GetParam() == Texture::kNoise;
  GrowConfig config;
  config.set_fill(GrowConfig::ONE_PASS);  // the longest one
  config.set_publish_confidence(true);
  Frame frame;
  frame.left = noisy ? Noise(size, 1, 256) : cv::Mat1b(size, uint8_t{100});
  frame.right = noisy ? Noise(size, 2, 256) : cv::Mat1b(size, uint8_t{100});
  frame.prior = noisy ? NoisyPrior(size) : ConstantPrior(size, 20);
  for (auto& [name, seeds] : MakeWorstSeeds(size)) {
    frame.seeds = SeedSet{.seeds = std::move(seeds), .raw = kWorstCount};
    GrowAdapter adapter(config);
    StageResult outcome;
    const double seconds = CpuSeconds([&] { outcome = adapter.Process(frame); });
    EXPECT_LT(seconds, kWorstSeconds) << name;
    EXPECT_FALSE(outcome.outputs.empty()) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Textures, WorstGrowth, testing::Values(Texture::kNone, Texture::kNoise));

}  // namespace
}  // namespace sprout::grow
