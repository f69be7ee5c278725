
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "services/pipeline/pipeline.h"
#include "services/tools/evaluate/evaluate.h"
#include "tests/services/tools/evaluate/small_scene.h"

namespace sprout::evaluate {
namespace {

std::vector<std::string> Names(const std::vector<Method>& methods) {
  std::vector<std::string> names;
  for (const Method& method : methods) names.push_back(method.name);
  return names;
}

ChainSettings Preset(const std::string& name) {
  return {.config = LoadConfig({name}), .noise = {}};
}

bool HasDisparity(float px) { return !std::isnan(px); }

auto CountDisparities(const cv::Mat1f& map_px) {
  return std::count_if(map_px.begin(), map_px.end(), HasDisparity);
}

bool SameMaps(const cv::Mat1f& a, const cv::Mat1f& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float in_a, float in_b) {
    return in_a == in_b || (!HasDisparity(in_a) && !HasDisparity(in_b));
  });
}

TEST(Methods, AreSelectedByNameAndGroupInTheOrderAskedForAndOnce) {
  EXPECT_THAT(Names(SelectMethods({"fgs", "sprout", "fgs"})),
              testing::ElementsAre("fgs", "sprout"));
  EXPECT_THAT(Names(SelectMethods({"prior", "paper"})),
              testing::ElementsAre("prior", "mncc-harris", "mncc-tof", "expssd-harris",
                                   "expssd-tof", "epc", "epc-filled"));
  EXPECT_THAT(Names(SelectMethods({"all"})),
              testing::ElementsAre("sprout", "mncc-harris", "mncc-tof", "expssd-harris",
                                   "expssd-tof", "epc", "epc-filled", "prior", "paper-filled",
                                   "sgbm-3way", "sgbm-5way", "bm", "bm-wls", "fgs"));
}

TEST(Methods, AllRunAndGiveAMapOfTheImagesSize) {
  const Scene scene = SmallScene();
  for (const Method& method : AllMethods()) {
    const MethodOutput output = method.run(scene, Preset("paper"));
    EXPECT_EQ(output.map_px.size(), scene.size()) << method.name;
    EXPECT_GT(CountDisparities(output.map_px), 0) << method.name << ": empty map";
    EXPECT_GT(output.ms.total_ms, 0) << method.name;
  }
}

TEST(Methods, GiveTheSameMapEveryTimeWithAnyNumberOfThreads) {
  const Scene scene = SmallScene();
  const ChainSettings settings{.config = LoadConfig({"default"}),
                               .noise = {.disparity_px = 1, .jitter_px = 1, .seed = 4}};
  const int threads = cv::getNumThreads();
  for (const Method& method : AllMethods()) {
    cv::setNumThreads(1);
    const cv::Mat1f once = method.run(scene, settings).map_px;
    cv::setNumThreads(3);
    EXPECT_TRUE(SameMaps(once, method.run(scene, settings).map_px)) << method.name;
  }
  cv::setNumThreads(threads);
}

TEST(Methods, SproutIsThePipeline) {
  const Scene scene = SmallScene();
  for (const char* preset : {"default", "paper"}) {
    {
      const ChainSettings settings = Preset(preset);
      const MethodOutput output = SelectMethods({"sprout"}).front().run(scene, settings);
      Pipeline pipeline(settings.config);
      const DepthFrame expected =
          pipeline
              .Compute(scene.frame.left, scene.frame.right, scene.frame.tof, scene.projector.rig())
              .value();
      EXPECT_TRUE(SameMaps(output.map_px, ToPx(expected.disparity))) << preset;
      ASSERT_EQ(output.confidence.size(), expected.confidence.size()) << preset;
      EXPECT_TRUE(output.confidence.empty() ||
                  cv::countNonZero(output.confidence != expected.confidence) == 0)
          << preset;
    }
  }
}

TEST(Methods, FillingIsWhatSetsEpcFilledApartFromEpc) {
  const Scene scene = SmallScene();
  const cv::Mat1f grown = SelectMethods({"epc"}).front().run(scene, Preset("paper")).map_px;
  const cv::Mat1f filled = SelectMethods({"epc-filled"}).front().run(scene, Preset("paper")).map_px;
  EXPECT_EQ(cv::countNonZero(grown == filled), CountDisparities(grown));
  EXPECT_GT(CountDisparities(filled), CountDisparities(grown));
}

TEST(Methods, NoiseReachesThoseThatUseTofSeedsOnly) {
  const Scene scene = SmallScene();
  ChainSettings noisy = Preset("paper");
  noisy.noise = {.disparity_px = 2, .jitter_px = 2, .seed = 1};
  for (const Method& method : AllMethods()) {
    const bool uses_tof = method.name != "mncc-harris" && method.name != "expssd-harris" &&
                          method.name != "sgbm-3way" && method.name != "sgbm-5way" &&
                          method.name != "bm" && method.name != "bm-wls";
    EXPECT_NE(SameMaps(method.run(scene, Preset("paper")).map_px, method.run(scene, noisy).map_px),
              uses_tof)
        << method.name;
  }
}

TEST(EvaluateScene, ScoresBothKindsOfPixelsAndTellsWhatRuns) {
  const Scene scene = SmallScene();
  std::vector<std::string> seen;
  const SceneResult result =
      EvaluateScene(scene, SelectMethods({"prior", "epc"}), Preset("paper"), 3,
                    [&](const Method& method) { seen.push_back(method.name); });
  EXPECT_THAT(seen, testing::ElementsAre("prior", "epc"));
  ASSERT_EQ(result.methods.size(), 2);
  const MethodResult& prior = result.methods[0];
  EXPECT_EQ(prior.nonoccluded.scored, cv::countNonZero(scene.nonoccluded));
  EXPECT_GT(prior.all.scored, prior.nonoccluded.scored);
  EXPECT_GT(prior.nonoccluded.correct_le1_percent(), 50);
  EXPECT_GT(prior.ms.refine_ms, 0);
  EXPECT_GT(prior.ms.prior_ms, 0);
  EXPECT_EQ(prior.ms.grow_ms, 0);
}

}  // namespace
}  // namespace sprout::evaluate
