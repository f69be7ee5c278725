#include "services/tools/calibrate/scene/range_curve_fit.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/scenes/solid_texture.h"

namespace sprout::calibrate {
namespace {

constexpr int kParts = 48;

// Ranges of 0.8 to 3 m that are off by error(range), with noise, and some wild ones.
std::vector<RangeSample> Samples(int count, double sigma_m,
                                 const std::function<double(double)>& error) {
  std::vector<RangeSample> samples;
  for (int i = 0; i < count; ++i) {
    const double range_m = 0.8 + 2.2 * ((i * 7919) % count) / count;
    const auto key = static_cast<uint64_t>(100 * i);
    const bool is_wild = i % 10 == 3;
    samples.push_back(
        {.range_m = range_m,
         .error_m = error(range_m) + sigma_m * scenes::NormalDeviate(key) + (is_wild ? 0.3 : 0),
         .sigma_m = sigma_m,
         .part = static_cast<size_t>(i % kParts)});
  }
  return samples;
}

TEST(RangeCurveFit, FindsAWigglingToAMillimetre) {
  const auto error = [](double range_m) { return 0.01 * std::sin(2 * M_PI * range_m / 1.25); };
  const RangeCorrection curve = FitRangeCurve(Samples(5000, 0.004, error)).curve;
  ASSERT_GE(curve.size(), 10);
  double worst_m = 0;
  for (double range_m = 0.9; range_m < 2.9; range_m += 0.01) {
    const CorrectionKnot at = CorrectionAt(curve, range_m);
    worst_m = std::max(worst_m, std::abs(at.offset_m + error(range_m)));
    EXPECT_LT(at.sigma_m, 0.0015);
  }
  EXPECT_LT(worst_m, 0.002);
}

TEST(RangeCurveFit, StaysAwayFromARightSensorAndFromTooFewMatches) {
  EXPECT_TRUE(FitRangeCurve(Samples(5000, 0.004, [](double) { return 0; })).curve.empty());
  const auto far_off = [](double) { return 0.02; };
  EXPECT_TRUE(FitRangeCurve(Samples(39, 0.004, far_off)).curve.empty());
  EXPECT_TRUE(FitRangeCurve({}).curve.empty());
  const RangeCorrection one = FitRangeCurve(Samples(60, 0.004, far_off)).curve;
  ASSERT_EQ(one.size(), 1);
  EXPECT_NEAR(one[0].offset_m, -0.02, 0.002);
}

// The farther, the darker; but at each range there are dark and bright surfaces.
TEST(RangeCurveFit, TellsWhatDependsOnLightFromWhatDependsOnRange) {
  for (const double light_m : {0.01, -0.02, 0.0}) {
    std::vector<RangeSample> samples =
        Samples(5000, 0.004, [](double range_m) { return 0.01 * (range_m - 1.5); });
    for (size_t i = 0; i < samples.size(); ++i) {
      const double albedo = 0.2 + 0.1 * static_cast<double>((i * 31) % 9);
      samples[i].brightness =
          BrightnessOf(albedo / (samples[i].range_m * samples[i].range_m), 0.15);
      samples[i].error_m += light_m * samples[i].brightness;
    }
    const RangeFit fit = FitRangeCurve(samples);
    EXPECT_NEAR(fit.light_m, -light_m, 3 * fit.light_sigma_m) << light_m;
    EXPECT_LT(fit.light_sigma_m, light_m == 0 ? 0.021 : 0.0015) << light_m;
    EXPECT_NEAR(CorrectionAt(fit.curve, 2.5).offset_m, -0.01, 0.001) << light_m;
  }
}

// Ranges that few matches have, between two surfaces: they must not turn the line and so move its
// far end, which has few of its own.
TEST(RangeCurveFit, TakesNoStraightLineAcrossAGap) {
  std::vector<RangeSample> samples;
  const auto add = [&](int count, double range_m, double spread_m, double error_m, double sigma_m) {
    for (int i = 0; i < count; ++i) {
      const auto key = static_cast<uint64_t>(100 * samples.size());
      samples.push_back({.range_m = range_m + spread_m * i / count,
                         .error_m = error_m + sigma_m * scenes::NormalDeviate(key),
                         .sigma_m = sigma_m});
    }
  };
  add(160, 1.3, 0.2, 0.005, 0.003);
  add(19, 1.62, 0.05, -0.005, 0.003);
  add(30, 2.9, 0.1, 0, 0.02);
  add(40, 3.3, 0.2, 0, 0.02);
  const RangeCorrection curve = FitRangeCurve(samples).curve;
  ASSERT_GE(curve.size(), 3);
  EXPECT_NEAR(curve.front().offset_m, -0.005, 0.002);
  const auto far = std::ranges::find_if(curve, [](const auto& knot) { return knot.range_m > 2; });
  ASSERT_LT(far->range_m, 3);
  EXPECT_NEAR(far->offset_m, 0, 3 * far->sigma_m);
  EXPECT_NEAR(far->offset_m, 0, 0.009);
}

// Before its first knot the curve is flat: what nearer ranges are off by does not move the knot.
TEST(RangeCurveFit, TakesItsFirstKnotFromWhatIsNearIt) {
  std::vector<RangeSample> samples = Samples(2000, 0.004, [](double) { return 0.02; });
  for (RangeSample& sample : samples) {
    if (sample.range_m < 0.84) sample.range_m -= 0.4;
    if (sample.range_m < 0.5) sample.error_m -= 0.01;
  }
  const RangeCorrection curve = FitRangeCurve(samples).curve;
  ASSERT_FALSE(curve.empty());
  EXPECT_NEAR(curve[0].offset_m, -0.02, 0.002);
}

TEST(RangeCurveFit, IsUnsureWhereMatchesAreNoisy) {
  const auto error = [](double) { return 0.02; };
  const RangeCorrection sure = FitRangeCurve(Samples(2000, 0.002, error)).curve;
  const RangeCorrection unsure = FitRangeCurve(Samples(2000, 0.02, error)).curve;
  ASSERT_FALSE(sure.empty());
  ASSERT_FALSE(unsure.empty());
  EXPECT_GT(unsure[5].sigma_m, 5 * sure[5].sigma_m);
}

// Between 1.8 and 2.2 m matches have any error up to 8 cm.
TEST(RangeCurveFit, IsUnsureWhereMatchesDisagree) {
  std::vector<RangeSample> samples = Samples(2000, 0.004, [](double) { return 0.02; });
  for (size_t i = 0; i < samples.size(); ++i) {
    const double range_m = samples[i].range_m;
    const bool is_any = range_m > 1.8 && range_m < 2.2;
    if (is_any) samples[i].error_m -= 0.01 * static_cast<double>((i * 31) % 9);
  }
  const RangeCorrection curve = FitRangeCurve(samples).curve;
  const CorrectionKnot sure = CorrectionAt(curve, 1.2);
  EXPECT_NEAR(sure.offset_m, -0.02, 0.002);
  EXPECT_LT(sure.sigma_m, 0.002);
  EXPECT_GT(CorrectionAt(curve, 2).sigma_m, 3 * sure.sigma_m);
}

TEST(RangeCurveFit, IsNoSurerThanWhatMatchesShare) {
  std::vector<RangeSample> samples = Samples(2000, 0.004, [](double) { return 0.05; });
  for (RangeSample& sample : samples) sample.shared_m = 0.003 * sample.range_m;
  for (const CorrectionKnot& knot : FitRangeCurve(samples).curve) {
    EXPECT_GT(knot.sigma_m, 0.0029 * knot.range_m);
    EXPECT_LT(knot.sigma_m, 0.0035 * knot.range_m);
  }
}

// All columns are off by the same amount, so that errors grow with the square of the range.
TEST(RangeCurveFit, TakesAYawOfThePairForNoErrorOfTheRanges) {
  const auto yaw = [](double range_m) { return 0.002 * range_m * range_m; };
  const auto wiggling = [&](double range_m) { return yaw(range_m) + 0.01 * std::sin(5 * range_m); };
  const auto fit = [](std::vector<RangeSample> samples, double yaw_m) {
    for (RangeSample& s : samples) s.yaw_m = yaw_m * s.range_m * s.range_m;
    return FitRangeCurve(samples).curve;
  };
  EXPECT_FALSE(fit(Samples(2000, 0.004, yaw), 0).empty());
  EXPECT_FALSE(fit(Samples(2000, 0.004, yaw), 0.0001).empty()) << "a pair that is known";
  EXPECT_TRUE(fit(Samples(2000, 0.004, yaw), 0.003).empty());
  const RangeCorrection curve = fit(Samples(2000, 0.004, wiggling), 0.003);
  ASSERT_FALSE(curve.empty());
  for (const CorrectionKnot& knot : curve) {
    EXPECT_NEAR(knot.offset_m, -wiggling(knot.range_m), 0.002) << knot.range_m;
    EXPECT_NEAR(knot.sigma_m, 0.003 * knot.range_m * knot.range_m, 0.001) << knot.range_m;
  }
}

// Matches of a part of the image are off alike, by 5 mm: more of them tell no more.
TEST(RangeCurveFit, IsNoSurerThanPartsOfTheImageAgree) {
  for (const int count : {1000, 16000}) {
    std::vector<RangeSample> samples = Samples(count, 0.002, [](double) { return 0; });
    for (RangeSample& sample : samples) {
      sample.error_m += 0.005 * scenes::NormalDeviate(100 * sample.part + 50);
      sample.brightness = sample.part % 8 == 0 ? 0.3 : -0.1;
    }
    const RangeFit fit = FitRangeCurve(samples);
    EXPECT_TRUE(fit.curve.empty()) << count;
    EXPECT_EQ(fit.light_m, 0) << count;
    EXPECT_GT(fit.light_sigma_m, 0.004) << count;
  }
}

TEST(RangeCurveFit, PutsOneCurveBehindAnother) {
  const RangeCorrection first = {{1, 0.01, 0.001}, {2, -0.01, 0.001}};
  const RangeCorrection then = {{0.5, 0.002, 0.003}, {3, 0.007, 0.003}};
  EXPECT_EQ(Chained({}, then), then);
  EXPECT_EQ(Chained(first, {}), first);
  const RangeCorrection both = Chained(first, then);
  for (double range_m = 0.4; range_m < 4; range_m += 0.05) {
    const double once_m = range_m + CorrectionAt(first, range_m).offset_m;
    const double twice_m = once_m + CorrectionAt(then, once_m).offset_m;
    EXPECT_NEAR(range_m + CorrectionAt(both, range_m).offset_m, twice_m, 2e-4) << range_m;
  }
  RangeCorrection long_one;
  for (int i = 0; i < 64; ++i) long_one.push_back({1 + 0.1 * i, 0, 0});
  RangeCorrection other;
  for (int i = 0; i < 64; ++i) other.push_back({1.05 + 0.1 * i, 0, 0});
  EXPECT_LE(Chained(long_one, other).size(), 64);
}

}  // namespace
}  // namespace sprout::calibrate
