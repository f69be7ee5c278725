#include "services/refine/refine_adapter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "common/core/tof_coverage.h"
#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

using testing::HasSubstr;

TEST(RefineAdapter, MakesNoRaysForAFrameWithoutToFImage) {
  RefineAdapter adapter{RefineConfig()};
  Scene scene = TexturedScene();
  scene.tof = {};
  scene.rig.tof.width = scene.rig.tof.height = 16384;  // rays would take gigabytes
  const StageResult outcome = adapter.Process(FrameOf(scene));
  EXPECT_EQ(outcome.degenerate, "");
  EXPECT_FALSE(std::get<SeedSet>(outcome.outputs.at(0).value).seeds.empty());
}

TEST(RefineAdapter, SaysThatACameraHangs) {
  RefineAdapter adapter{RefineConfig()};
  Frame frame = FrameOf(TexturedScene());
  std::string said;
  for (int64_t seq = 0; seq < 10; ++seq) {
    frame.id.seq = seq;
    frame.right.row(frame.right.rows - 1) = cv::Scalar(static_cast<double>(seq));
    said = adapter.Process(frame).degenerate;
  }
  EXPECT_THAT(said, HasSubstr("10 left, 10 range images in a row are the same"));
}

TEST(RefineAdapter, SaysOfTheFirstAndOfEachNthFrameWhatIsWrongWithItsInput) {
  RefineConfig config;
  config.set_check_inputs_every(100);
  RefineAdapter adapter{config};
  const Scene good = TexturedScene();
  Scene scene = good;
  std::swap(scene.left, scene.right);
  Frame frame = FrameOf(scene);
  const auto says = [&](const Scene& of, int64_t seq) {
    frame = FrameOf(of);
    frame.id.seq = seq;
    return adapter.Process(frame).degenerate;
  };
  EXPECT_THAT(says(scene, 7), HasSubstr("swapped"));
  // Not looked at, but it has no seeds, and the cure is known.
  EXPECT_THAT(says(scene, 8), HasSubstr("stereo found none; left and right are swapped"));
  const std::string of_good = says(good, 99);
  EXPECT_EQ(of_good.find("swapped"), std::string::npos) << of_good;
  says(good, 100);
  EXPECT_EQ(says(scene, 101).find("swapped"), std::string::npos);
  EXPECT_THAT(says(scene, 200), HasSubstr("swapped"));
  config.set_check_inputs_every(0);
  RefineAdapter unchecked{config};
  const StageResult without = unchecked.Process(frame);
  EXPECT_EQ(without.degenerate.find("swapped"), std::string::npos);
  EXPECT_EQ(std::get<SeedSet>(without.outputs.at(0).value),
            std::get<SeedSet>(adapter.Process(frame).outputs.at(0).value));
}

TEST(RefineAdapter, SaysThatAPairIsNearerThanStereoIsSearched) {
  RefineConfig config;
  Scene scene = TexturedScene();
  scene.tof = TofImage();
  EXPECT_THAT(RefineAdapter(config).Process(FrameOf(scene)).degenerate,
              testing::Not(HasSubstr("stereo is searched")));
  config.set_stereo_max_disparity_px(2);
  EXPECT_THAT(RefineAdapter(config).Process(FrameOf(scene)).degenerate,
              HasSubstr("stereo is searched up to 2 px"));
}

// The boxes are within the unambiguous range, the wall is not.
TEST(RefineAdapter, ChecksRangesBeyondTheUnambiguousOneWhereTheyAre) {
  BoxScene scene;
  const TofProjector projector(scene.rig);
  const double range_m = 0.6 * scene.rig.pair.DepthFromDisparity(12);
  for (int v = 0; v < scene.tof.depth_m.rows; ++v) {
    for (int u = 0; u < scene.tof.depth_m.cols; ++u) {
      if (BoxScene::DisparityAt(5 * u, 5 * v) > 12) continue;
      scene.tof.depth_m(v, u) -= static_cast<float>(range_m / projector.ray(u, v).norm());
    }
  }
  RefineConfig config;
  const Frame frame = FrameOf(scene);
  EXPECT_NE(RefineAdapter(config).Process(frame).degenerate, "");
  config.set_unambiguous_range_m(range_m);
  EXPECT_EQ(RefineAdapter(config).Process(frame).degenerate, "");
}

TEST(RefineAdapter, ChecksInputAlsoWhenFramesAreSkippedAndOfAnotherCalibration) {
  RefineConfig config;
  config.set_check_inputs_every(100);
  RefineAdapter adapter{config};
  const Scene good = TexturedScene();
  Scene swapped = good;
  std::swap(swapped.left, swapped.right);
  const auto says = [&](const Scene& of, int64_t seq, const std::string& rig_id) {
    Frame frame = FrameOf(of);
    frame.id.seq = seq;
    frame.id.rig_id = rig_id;
    return adapter.Process(frame).degenerate;
  };
  EXPECT_EQ(says(good, 1, "a").find("swapped"), std::string::npos);
  EXPECT_THAT(says(swapped, 101, "a"), HasSubstr("swapped")) << "frame 100 was skipped";
  EXPECT_EQ(says(good, 103, "b").find("swapped"), std::string::npos) << "it was mended";
  EXPECT_THAT(says(swapped, 104, "c"), HasSubstr("swapped"));
}

TEST(RefineAdapter, SaysWhyAFrameHasNoSeeds) {
  RefineAdapter adapter{RefineConfig()};
  Scene scene;
  EXPECT_THAT(adapter.Process(FrameOf(scene)).degenerate,
              HasSubstr("no ToF point has a return, and stereo found none"));
  RefineConfig without_stereo;
  without_stereo.set_stereo_seeds(false);
  EXPECT_THAT(RefineAdapter(without_stereo).Process(FrameOf(scene)).degenerate,
              HasSubstr("no ToF point has a return; seeds of stereo take refine { stereo_seeds"));
  scene.SetDisparity(0, 0, 5);
  EXPECT_THAT(adapter.Process(FrameOf(scene)).degenerate, HasSubstr("none of 1 ToF points"));
  scene.right = cv::Mat1b(10, 10, uint8_t{0});
  const StageResult outcome = adapter.Process(FrameOf(scene));
  EXPECT_THAT(outcome.degenerate, HasSubstr("10x10"));
  ASSERT_EQ(outcome.outputs.size(), 2u);
  for (const PartOutput& output : outcome.outputs) {
    EXPECT_TRUE(std::get<SeedSet>(output.value).seeds.empty());
  }
}

// One zone in the left camera's place that sees all of its image, z = 10 / (d + 2).
TofZones OneZone(double disparity_px, ZoneMode mode = ZoneMode::kMean) {
  return {.columns = 1,
          .rows = 1,
          .targets_per_zone = 1,
          .mode = mode,
          .left_from_sensor = {},
          .views = {{-0.52F, 0.52F, -0.42F, 0.42F}},
          .targets = {{static_cast<float>(10 / (disparity_px + 2)), 0.01F, TargetStatus::kValid}}};
}

TEST(RefineAdapter, SaysWhatStereoContradicts) {
  BoxScene scene;
  for (int j = 30; j < 60; ++j) {
    for (int i = 12; i < 40; ++i) scene.SetDisparity(i, j, 250);
  }
  RefineAdapter adapter{RefineConfig()};
  const StageResult result = adapter.Process(FrameOf(scene));
  EXPECT_FALSE(result.ranges_refused);
  EXPECT_THAT(result.finding.value_or(""), HasSubstr("stereo contradicts the range points at"));
  Frame without = FrameOf(scene);
  without.tof.reset();
  EXPECT_EQ(adapter.Process(without).finding.value_or(""), "") << "what is over is not said";
}

TEST(RefineAdapter, SaysThatARangeImageIsSmoothed) {
  BoxScene scene;
  for (int j = 12; j < 40; ++j) {
    for (int i = 40; i < 60; ++i) scene.SetDisparity(i, j, 30);
  }
  RefineAdapter adapter{RefineConfig()};
  const auto said = [&] { return adapter.Process(FrameOf(scene)).finding.value_or(""); };
  EXPECT_THAT(said(), testing::Not(HasSubstr("smoothed")));
  cv::GaussianBlur(scene.tof.depth_m, scene.tof.depth_m, {}, 1.5);
  EXPECT_THAT(said(), HasSubstr("the range image is smoothed, its depth edges are 3."));
}

TEST(RefineAdapter, SaysThatNearSurfacesReachTooFar) {
  BoxScene scene;
  cv::erode(scene.tof.depth_m, scene.tof.depth_m, cv::Mat1b::ones(3, 3));
  EXPECT_THAT(RefineAdapter{RefineConfig()}.Process(FrameOf(scene)).finding.value_or(""),
              HasSubstr("near surfaces of the range image reach up to 1 pixel beyond"));
}

TEST(RefineAdapter, SaysWhereADisplacedSensorBelongs) {
  RefineAdapter adapter{RefineConfig()};
  const StageResult displaced = adapter.Process(FrameOf(BoxScene(25)));
  EXPECT_TRUE(displaced.ranges_refused);
  EXPECT_THAT(displaced.degenerate, HasSubstr("px further left"));
  EXPECT_THAT(displaced.degenerate, HasSubstr("none is believed"));
  EXPECT_FALSE(displaced.finding.has_value());
  const StageResult right = adapter.Process(FrameOf(BoxScene()));
  EXPECT_FALSE(right.ranges_refused);
  EXPECT_EQ(right.degenerate, "");
}

TEST(RefineAdapter, SaysThatAPairDoesNotFit) {
  auto scene = BoxScene();
  cv::flip(scene.right, scene.right, 0);
  const StageResult result = RefineAdapter{RefineConfig()}.Process(FrameOf(scene));
  EXPECT_THAT(result.degenerate, HasSubstr("say nothing of the range sensor"));
}

TEST(RefineAdapter, TakesAnEnlargedRangeImageAsItsSensorGaveIt) {
  RefineAdapter adapter{RefineConfig()};
  Scene scene = BoxScene();
  cv::RNG random(7);
  for (float& depth_m : scene.tof.depth_m) depth_m *= 1 + 0.002F * random.uniform(-1.0F, 1.0F);
  Scene enlarged = scene;
  constexpr int kTimes = 3;
  cv::resize(scene.tof.depth_m, enlarged.tof.depth_m, {}, kTimes, kTimes, cv::INTER_NEAREST);
  enlarged.tof.amplitude.release();
  TofCamera& camera = enlarged.rig.tof;
  camera.width *= kTimes;
  camera.height *= kTimes;
  camera.fx *= kTimes;
  camera.fy *= kTimes;
  camera.cx = (camera.cx + 0.5) * kTimes - 0.5;
  camera.cy = (camera.cy + 0.5) * kTimes - 0.5;
  const StageResult expected = adapter.Process(FrameOf(scene));
  const StageResult found = adapter.Process(FrameOf(enlarged));
  EXPECT_THAT(found.finding.value_or(""), HasSubstr("was enlarged"));
  const SeedSet seeds = std::get<SeedSet>(found.outputs.at(0).value);
  SeedSet of_sensor = std::get<SeedSet>(expected.outputs.at(0).value);
  EXPECT_GT(CountTofSeeds(of_sensor.seeds), 1000);
  EXPECT_EQ(seeds.raw, of_sensor.raw);
  ASSERT_EQ(seeds.seeds.size(), of_sensor.seeds.size());
  for (size_t i = 0; i < seeds.seeds.size(); ++i) {
    Seed& seed = of_sensor.seeds[i];
    EXPECT_NEAR(seeds.seeds[i].disparity(), seed.disparity(), 1e-3);
    if (seed.tof_u < 0) continue;
    EXPECT_EQ(seeds.seeds[i].tof_u, kTimes * seed.tof_u + 1);
    EXPECT_EQ(seeds.seeds[i].tof_v, kTimes * seed.tof_v + 1);
  }
}

TEST(RefineAdapter, FillsWithZonesWhereNothingElseIsKnown) {
  RefineAdapter adapter{RefineConfig()};
  Scene scene;  // without texture or ToF points
  scene.tof = {};
  Frame frame = FrameOf(scene);
  frame.tof_zones = OneZone(12);
  const StageResult outcome = adapter.Process(frame);
  const auto& seeds = std::get<SeedSet>(outcome.outputs.at(0).value);
  const auto& left_seeds = std::get<SeedSet>(outcome.outputs.at(1).value);
  EXPECT_TRUE(seeds.seeds.empty()) << "an area is no correspondence";
  // 25 × 20 cells of 4 px.
  ASSERT_EQ(left_seeds.seeds.size(), 500);
  EXPECT_EQ(left_seeds.raw, 500);
  for (const Seed& seed : left_seeds.seeds) {
    EXPECT_NEAR(seed.disparity(), 12, 1e-3);
    EXPECT_EQ(seed.origin, SeedOrigin::kTof);
    EXPECT_EQ(seed.tof_u, -1);
    // σ of d at z = 10 / 14 m ± 0.01: 0.196 px, and once more for the mean.
    EXPECT_GT(seed.sigma_px, 0.27F);
  }
  frame.tof_zones = OneZone(12, ZoneMode::kNearest);
  EXPECT_TRUE(std::get<SeedSet>(adapter.Process(frame).outputs.at(1).value).seeds.empty());
  frame.tof_zones = TofZones();
  EXPECT_TRUE(std::get<SeedSet>(adapter.Process(frame).outputs.at(1).value).seeds.empty());
}

TEST(RefineAdapter, FillsNoCellWithinTwoCellsOfASeed) {
  RefineConfig config = PaperRules();  // a single point is loose otherwise
  RefineAdapter adapter(config);
  Scene scene;
  scene.SetDisparity(5, 4, 40);  // at (50, 40), in cell (12, 10); far nearer than the zone says
  Frame frame = FrameOf(scene);
  TofZones zones = OneZone(4);
  zones.columns = zones.rows = 3;  // one alone does not know its slant
  zones.targets.resize(9, zones.targets[0]);
  zones.views.clear();
  for (const float v : {-0.42F, -0.14F, 0.14F}) {
    for (const float u : {-0.54F, -0.18F, 0.18F})
      zones.views.push_back({u, u + 0.36F, v, v + 0.28F});
  }
  frame.tof_zones = zones;
  const StageResult outcome = adapter.Process(frame);
  ASSERT_EQ(std::get<SeedSet>(outcome.outputs.at(0).value).seeds.size(), 1);
  const auto& filled = std::get<SeedSet>(outcome.outputs.at(1).value).seeds;
  ASSERT_FALSE(filled.empty());
  for (const Seed& seed : filled) {
    // Cells of 4 px: the point's own begins at 48 and 40, two more on either side are free.
    const bool near = seed.u > 40 && seed.u < 60 && seed.v > 32 && seed.v < 52;
    EXPECT_FALSE(near) << seed.u << ", " << seed.v;
  }
}

TEST(RefineAdapter, DropsStereoSeedsThatAreNearerThanZonesAllow) {
  RefineAdapter adapter{RefineConfig()};
  Scene scene = TexturedScene();  // 12 px everywhere
  scene.tof = {};
  Frame frame = FrameOf(scene);
  const auto stereo = [&] {
    return std::get<SeedSet>(adapter.Process(frame).outputs.at(0).value).seeds;
  };
  const std::vector<Seed> without = stereo();
  ASSERT_GT(without.size(), 50);
  for (const ZoneMode mode : {ZoneMode::kMean, ZoneMode::kNearest}) {
    // z − 3 σ is 10 / 13.5 − 0.03 m: up to 12.07 px.
    frame.tof_zones = OneZone(11.5, mode);
    EXPECT_GT(stereo().size(), without.size() / 2);
    // 10 / 12 − 0.03 m: up to 10.4 px.
    frame.tof_zones = OneZone(10, mode);
    EXPECT_TRUE(stereo().empty());
    frame.tof_zones = OneZone(20, mode);
    EXPECT_EQ(stereo(), without) << "what lies behind may be hidden from the zone, or dark";
  }
}

// A pair that is toed in or cropped, cx > cx_right: 32 px are beyond a fifth of the width, 20 px,
// but 12 px nearer than infinity.
TEST(RefineAdapter, SearchesBeyondTheDisparityOfInfinity) {
  constexpr int kInfinity = 20;
  Scene scene = TexturedScene();
  scene.tof = {};
  scene.rig.pair.cx_right = scene.rig.pair.cx;
  const auto seeds = [](const Scene& of) {
    const StageResult outcome = RefineAdapter{RefineConfig()}.Process(FrameOf(of));
    return std::get<SeedSet>(outcome.outputs.at(0).value).seeds;
  };
  const size_t before = seeds(scene).size();
  scene.rig.pair.cx_right -= kInfinity;
  scene.right.colRange(kInfinity, 100).clone().copyTo(scene.right.colRange(0, 100 - kInfinity));
  scene.right.colRange(100 - kInfinity, 100).setTo(0);
  const std::vector<Seed> after = seeds(scene);
  EXPECT_GT(after.size(), before / 2);  // fewer columns are in both images
  for (const Seed& seed : after) EXPECT_NEAR(seed.disparity(), 12 + kInfinity, 0.5);
}

TEST(RefineAdapter, SaysWhatIsWrongWithZones) {
  RefineAdapter adapter{RefineConfig()};
  Frame frame = FrameOf(TexturedScene());
  TofZones zones = OneZone(12);
  zones.columns = 65;
  zones.views.resize(65, zones.views[0]);
  zones.targets.resize(65, zones.targets[0]);
  frame.tof_zones = zones;
  const StageResult outcome = adapter.Process(frame);
  EXPECT_THAT(outcome.degenerate, HasSubstr("zones overlap: allowed are 64"));
  EXPECT_EQ(outcome.outputs.size(), 2u);
}

TEST(RefineAdapter, AnswersAToFImageOfAnotherSizeThanCalibratedEmpty) {
  RefineAdapter adapter{RefineConfig()};
  Scene scene;
  scene.rig.tof.width = scene.rig.tof.height = 16384;  // rays would take gigabytes
  const StageResult outcome = adapter.Process(FrameOf(scene));
  EXPECT_THAT(outcome.degenerate, HasSubstr("ToF image of 10x8"));
  EXPECT_EQ(outcome.outputs.size(), 2u);
}

TEST(RefineAdapter, AnswersFramesWithoutToF) {
  const Scene scene;
  std::vector<std::pair<const char*, Frame>> frames = {
      {"a ToF image of NaN", FrameOf(scene)},
      {"no ToF image", FrameOf(scene)},
      {"no image of a huge camera", FrameOf(scene)},
      {"no ToF camera", FrameOf(scene)}};
  for (size_t i = 1; i < frames.size(); ++i) frames[i].second.tof = TofImage();
  // Rays would take gigabytes.
  frames[2].second.rig->tof.width = frames[2].second.rig->tof.height = 10000;
  frames[3].second.rig->tof = {};
  RefineAdapter adapter{RefineConfig()};
  for (const auto& [name, frame] : frames) {
    const StageResult outcome = adapter.Process(frame);
    ASSERT_EQ(outcome.outputs.size(), 2u) << name;
    const auto& set = std::get<SeedSet>(outcome.outputs[0].value);
    EXPECT_EQ(TofCoverage(set.seeds, frame.left.size()), 0) << name;
    EXPECT_EQ(set.raw, 0) << name;
    EXPECT_THAT(outcome.degenerate, testing::Not(HasSubstr("ToF image of"))) << name;
  }
}

TEST(RefineAdapter, AnswersWithTheSeedsOfEachFrameOnly) {
  RefineAdapter adapter{PaperRules()};
  Scene scene;
  scene.SetDisparity(1, 4, 9);
  const auto left_seeds_of = [&](const StageResult& outcome) {
    EXPECT_EQ(outcome.outputs.at(1).part, Part::kLeftSeeds);
    return std::get<SeedSet>(outcome.outputs.at(1).value);
  };
  EXPECT_EQ(left_seeds_of(adapter.Process(FrameOf(scene))).seeds.size(), 1u);
  scene.tof.depth_m = cv::Mat1f(4, 4, 1.0F);
  EXPECT_EQ(left_seeds_of(adapter.Process(FrameOf(scene))), SeedSet());
}

TEST(RefineAdapter, FollowsAChangeOfCalibration) {
  RefineAdapter adapter{PaperRules()};
  Scene scene;
  scene.SetDisparity(3, 2, 8);
  const auto seed_of = [&](const StageResult& outcome) {
    return std::get<SeedSet>(outcome.outputs.at(0).value).seeds.at(0);
  };
  EXPECT_NEAR(seed_of(adapter.Process(FrameOf(scene))).v, 20, 1e-3);
  scene.rig.pair.cy = 45;
  EXPECT_NEAR(seed_of(adapter.Process(FrameOf(scene))).v, 25, 1e-3);
}

}  // namespace
}  // namespace sprout::refine
