#include "services/grow/grow_adapter.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "tests/common/config/with.h"
#include "tests/common/core/even_prior.h"

namespace sprout::grow {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;
using testing::StartsWith;

Frame FlatFrame(cv::Size size) {
  Frame frame;
  frame.left = cv::Mat(size, CV_8UC3, cv::Scalar(10, 120, 200));
  frame.right = cv::Mat(size, CV_8UC1, cv::Scalar(126));  // the grey value of the left one
  frame.seeds = SeedSet{.seeds = {{10, 10, 8}, {20, 10, 18}, {15, 20, 13}}, .raw = 3};
  frame.prior = EvenPrior(DisparityImage(cv::Mat1s(size, ToCounts(2))), 1);
  return frame;
}

const DisparityImage& MapOf(const StageResult& outcome, Part part) {
  for (const PartOutput& output : outcome.outputs) {
    if (output.part == part) return std::get<DisparityImage>(output.value);
  }
  throw std::runtime_error("part is missing");
}

GrowAdapter Adapter(const std::string& config) { return GrowAdapter(With<GrowConfig>(config)); }

TEST(GrowAdapter, AsksForWhatItsConfigurationNeeds) {
  const PartSet with_prior = {Part::kLeft, Part::kRight, Part::kSeeds, Part::kPrior};
  EXPECT_EQ(Adapter("").Inputs(), with_prior);
  EXPECT_EQ(Adapter("similarity: MNCC").Inputs(), with_prior);
  EXPECT_EQ(Adapter("similarity: MNCC fill: NONE").Inputs(),
            (PartSet{Part::kLeft, Part::kRight, Part::kSeeds}));
}

TEST(GrowAdapter, AnswersWithAFilledMap) {
  const StageResult outcome = GrowAdapter(GrowConfig()).Process(FlatFrame({40, 30}));
  EXPECT_EQ(outcome.degenerate, "");
  EXPECT_EQ(MapOf(outcome, Part::kDisparity).CountValid(), 40 * 30);
}

TEST(GrowAdapter, LeavesOutWhatItIsNotSureOf) {
  GrowConfig config;
  config.set_publish_unfilled(true);
  GrowAdapter keeps_all(config);
  const StageResult all = keeps_all.Process(FlatFrame({40, 30}));
  const cv::Mat1b confidence = std::get<cv::Mat>(all.outputs.at(2).value);
  double least = 0;
  double most = 0;
  cv::minMaxLoc(confidence, &least, &most);
  ASSERT_LT(least, most);
  const int bound = static_cast<int>(most);
  config.set_min_confidence(bound);
  for (const GrowConfig::Fill fill : {GrowConfig::PRIOR, GrowConfig::NONE}) {
    config.set_fill(fill);
    config.set_publish_confidence(fill == GrowConfig::NONE);
    const StageResult sure = GrowAdapter(config).Process(FlatFrame({40, 30}));
    EXPECT_EQ(sure.outputs.size(), fill == GrowConfig::NONE ? 4U : 2U);
    EXPECT_LT(MapOf(sure, Part::kDisparity).CountValid(), 40 * 30);
    EXPECT_EQ(MapOf(sure, Part::kUnfilled).CountValid(), MapOf(all, Part::kUnfilled).CountValid());
    if (fill == GrowConfig::NONE) continue;
    EXPECT_EQ(MapOf(sure, Part::kDisparity).CountValid(), cv::countNonZero(confidence >= bound));
  }
}

TEST(GrowAdapter, AddsTheUnfilledMapOnDemand) {
  const StageResult outcome = Adapter("publish_unfilled: true").Process(FlatFrame({40, 30}));
  EXPECT_LT(MapOf(outcome, Part::kUnfilled).CountValid(),
            MapOf(outcome, Part::kDisparity).CountValid());
}

TEST(GrowAdapter, AddsConfidenceAndSigmaUnlessTold) {
  const StageResult outcome = Adapter("").Process(FlatFrame({40, 30}));
  ASSERT_EQ(outcome.outputs.size(), 3u);
  EXPECT_EQ(outcome.outputs[1].part, Part::kConfidence);
  const auto& confidence = std::get<cv::Mat>(outcome.outputs[1].value);
  EXPECT_EQ(confidence.size(), cv::Size(40, 30));
  EXPECT_EQ(confidence.type(), CV_8UC1);
  EXPECT_GT(cv::countNonZero(confidence), 0);
  EXPECT_EQ(outcome.outputs[2].part, Part::kSigma);
  const auto& sigma = std::get<cv::Mat>(outcome.outputs[2].value);
  EXPECT_EQ(sigma.size(), cv::Size(40, 30));
  EXPECT_EQ(sigma.type(), CV_8UC1);
  EXPECT_LT(cv::mean(sigma)[0], kMaxSigmaCounts);
  GrowAdapter without = Adapter("publish_confidence: false");
  EXPECT_EQ(without.Process(FlatFrame({40, 30})).outputs.size(), 1u);
}

TEST(GrowAdapter, SaysWhyAFrameHasNoDisparity) {
  GrowAdapter adapter = Adapter("publish_confidence: true");
  Frame no_seeds = FlatFrame({40, 30});
  no_seeds.seeds->seeds.clear();
  EXPECT_THAT(adapter.Process(no_seeds).degenerate, HasSubstr("no seeds"));

  Frame no_prior = FlatFrame({40, 30});
  no_prior.prior = PriorMap(cv::Size(40, 30));
  EXPECT_THAT(adapter.Process(no_prior).degenerate, HasSubstr("prior is empty"));

  Frame tiny = FlatFrame({4, 4});
  EXPECT_THAT(adapter.Process(tiny).degenerate, HasSubstr("smaller than the 5x5 window"));

  Frame sizes_differ = FlatFrame({40, 30});
  sizes_differ.right = cv::Mat(31, 40, CV_8UC1, cv::Scalar(0));
  const StageResult outcome = adapter.Process(sizes_differ);
  EXPECT_THAT(outcome.degenerate, HasSubstr("allowed are two of one size"));
  EXPECT_EQ(MapOf(outcome, Part::kDisparity).size(), cv::Size(40, 30));
  EXPECT_EQ(MapOf(outcome, Part::kDisparity).CountValid(), 0);
}

TEST(GrowAdapter, SaysThatThePriorIsNotThatOfTheSeeds) {
  GrowAdapter adapter{GrowConfig()};
  const auto degenerate_with = [&](double left_px, double right_px) {
    Frame frame = FlatFrame({40, 30});
    frame.prior->disparity.counts().colRange(0, 18) = ToCounts(left_px);
    frame.prior->disparity.counts().colRange(18, 40) = ToCounts(right_px);
    return adapter.Process(frame).degenerate;
  };
  EXPECT_THAT(degenerate_with(-3, -3),
              MatchesRegex("nothing grew from 3 seeds; the prior contradicts 3 of 3 seeds: it has "
                           "-3 px at \\(10, 10\\), the seed 2"));
  EXPECT_THAT(degenerate_with(2, 12), HasSubstr("1 of 3 seeds: it has 12 px at (20, 10)"));
  EXPECT_EQ(degenerate_with(2, 2), "");
}

TEST(GrowAdapter, SaysThatThePriorIsNotThatOfTheSeedsWhereSomethingGrows) {
  GrowAdapter adapter = Adapter("sigma_p_px: 17.4 sigma_p_noise: 0");  // as of preset paper
  Frame frame = FlatFrame({40, 30});
  frame.prior->disparity.counts() = ToCounts(-3);
  EXPECT_THAT(adapter.Process(frame).degenerate, StartsWith("the prior contradicts 3 of 3 seeds"));
}

TEST(GrowAdapter, IsSureOfNothingBesideAPriorThatIsNotThatOfTheSeeds) {
  GrowAdapter adapter{GrowConfig()};
  Frame frame = FlatFrame({40, 30});
  const auto sure_with = [&](double px) {
    frame.prior->disparity.counts() = ToCounts(px);
    return cv::countNonZero(std::get<cv::Mat>(adapter.Process(frame).outputs.at(1).value));
  };
  EXPECT_GT(sure_with(2), 0);
  EXPECT_EQ(sure_with(12), 0);
}

TEST(GrowAdapter, SaysThatTheImagesDoNotShowTheSeeds) {
  constexpr int kDisparity = 6;
  cv::Mat1b scene(120, 170);
  cv::RNG(1).fill(scene, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(scene, scene, {}, 2);
  Frame frame;
  frame.left = scene.colRange(0, 160);
  frame.right = scene.colRange(kDisparity, 160 + kDisparity);
  GrowAdapter adapter = Adapter("similarity: MNCC fill: NONE");
  const auto degenerate_with = [&](float disparity) {
    frame.seeds = SeedSet{};
    for (float v = 5; v < 115; v += 3) {
      for (float u = 25; u < 150; u += 3) frame.seeds->seeds.push_back({u, v, u - disparity});
    }
    return adapter.Process(frame).degenerate;
  };
  EXPECT_EQ(degenerate_with(kDisparity), "");
  EXPECT_THAT(degenerate_with(2 * kDisparity), HasSubstr("fewer than by chance"));
  EXPECT_THAT(degenerate_with(-kDisparity), HasSubstr("fewer than by chance"));
}

// A camera that is covered: stereo still finds a few seeds at its border.
TEST(GrowAdapter, IsSureOfNothingWhereNothingGrew) {
  GrowAdapter adapter{GrowConfig()};
  Frame frame = FlatFrame({40, 30});
  cv::RNG(1).fill(frame.left, cv::RNG::UNIFORM, 0, 256);
  const auto confidence_of = [&](SeedOrigin origin) {
    for (Seed& seed : frame.seeds->seeds) seed.origin = origin;
    const StageResult outcome = adapter.Process(frame);
    EXPECT_THAT(outcome.degenerate, HasSubstr("nothing grew"));
    return cv::countNonZero(std::get<cv::Mat>(outcome.outputs.at(1).value));
  };
  EXPECT_EQ(confidence_of(SeedOrigin::kStereo), 0);
  EXPECT_GT(confidence_of(SeedOrigin::kTof), 0);
}

TEST(GrowAdapter, GoesOnAfterADegenerateFrame) {
  GrowAdapter adapter{GrowConfig()};
  const StageResult before = adapter.Process(FlatFrame({40, 30}));
  Frame no_seeds = FlatFrame({40, 30});
  no_seeds.seeds->seeds.clear();
  adapter.Process(no_seeds);
  const StageResult after = adapter.Process(FlatFrame({40, 30}));
  EXPECT_EQ(cv::countNonZero(MapOf(before, Part::kDisparity).counts() !=
                             MapOf(after, Part::kDisparity).counts()),
            0);
}

TEST(GrowAdapter, SaysWhenThePriorHasAnotherSize) {
  for (const std::string similarity : {"EPC", "MNCC", "EXPSSD"}) {
    Frame frame = FlatFrame({64, 48});
    frame.prior = EvenPrior(DisparityImage(cv::Mat1s({8, 8}, ToCounts(2))), 1);
    const StageResult outcome = Adapter("similarity: " + similarity).Process(frame);
    EXPECT_THAT(outcome.degenerate, HasSubstr("of 8x8: allowed is the images' size 64x48"));
    EXPECT_EQ(MapOf(outcome, Part::kDisparity).size(), cv::Size(64, 48));
  }
}

TEST(GrowAdapter, SaysWhenTheImagesHaveTwoSizes) {
  Frame frame = FlatFrame({40, 30});
  frame.right = cv::Mat(8, 8, CV_8UC1, cv::Scalar(0));
  EXPECT_THAT(GrowAdapter(GrowConfig()).Process(frame).degenerate, HasSubstr("two of one size"));
}

}  // namespace
}  // namespace sprout::grow
