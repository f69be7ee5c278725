#include "services/pipeline/pipeline.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/geometry/projection.h"
#include "common/scenes/dataset.h"
#include "services/grow/grow_adapter.h"
#include "services/prior/prior_adapter.h"
#include "services/refine/refine_adapter.h"
#include "services/temporal/temporal_adapter.h"
#include "services/tools/evaluate/evaluate.h"
#include "tests/services/tools/evaluate/small_scene.h"

namespace sprout {
namespace {

using testing::HasSubstr;

Result<DepthFrame> Compute(Pipeline& pipeline, const evaluate::Scene& scene,
                           const std::optional<FrameTime>& time = {}) {
  return pipeline.Compute(scene.frame.left, scene.frame.right, scene.frame.tof,
                          scene.projector.rig(), time);
}

std::string ErrorFor(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                     const Rig& rig) {
  const auto result = Pipeline(LoadConfig({"default"})).Compute(left, right, tof, rig);
  return result ? "no error" : result.error().text;
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

// The answers of refine, prior and grow.
class Services {
 public:
  explicit Services(const SproutConfig& config)
      : refine_(config.refine()), prior_(config.prior()), grow_(config.grow()) {}

  void Answer(Frame& frame) {
    for (StageAdapter* adapter : std::initializer_list<StageAdapter*>{&refine_, &prior_, &grow_}) {
      AddAnswer(*adapter, frame);
    }
  }

 private:
  refine::RefineAdapter refine_;
  prior::PriorAdapter prior_;
  grow::GrowAdapter grow_;
};

TEST(Pipeline, GivesWhatTheServicesGive) {
  const evaluate::Scene scene = evaluate::SmallScene();
  for (const char* preset : {"default", "fast", "paper"}) {
    const SproutConfig config = LoadConfig({preset});
    Frame frame = evaluate::FrameOf(scene);
    Services(config).Answer(frame);
    Pipeline pipeline(config);
    const DepthFrame result = Compute(pipeline, scene).value();
    EXPECT_GT(result.disparity.CountValid(), 0) << preset;
    EXPECT_TRUE(SameBytes(result.disparity.counts(), frame.disparity->counts())) << preset;
    EXPECT_TRUE(SameBytes(result.prior.sigma, frame.prior->sigma)) << preset;
    EXPECT_EQ(result.seeds, *frame.seeds) << preset;
    EXPECT_EQ(result.left_seeds, *frame.left_seeds) << preset;
    EXPECT_EQ(result.confidence.empty(), !config.grow().publish_confidence()) << preset;
    EXPECT_TRUE(result.confidence.empty() || SameBytes(result.confidence, frame.confidence));
    EXPECT_EQ(result.sigma.empty(), result.confidence.empty());
    EXPECT_TRUE(result.sigma.empty() || SameBytes(result.sigma, frame.sigma));
    EXPECT_THAT(result.warnings, testing::IsEmpty()) << preset;
  }
}

TEST(Pipeline, SaysHowSureItIsInEveryPresetWhenAskedTo) {
  const evaluate::Scene scene = evaluate::SmallScene();
  for (const char* preset : {"fast", "paper"}) {
    Pipeline without(LoadConfig({preset}));
    Pipeline with(LoadConfig({preset, "grow { publish_confidence: true }"}));
    const DepthFrame as_shipped = Compute(without, scene).value();
    const DepthFrame judged = Compute(with, scene).value();
    EXPECT_TRUE(as_shipped.confidence.empty()) << preset;
    EXPECT_TRUE(SameBytes(as_shipped.disparity.counts(), judged.disparity.counts())) << preset;
    ASSERT_EQ(judged.confidence.size(), scene.size()) << preset;
    EXPECT_EQ(cv::countNonZero(judged.confidence &
                               (judged.disparity.counts() == DisparityImage::kInvalid)),
              0)
        << preset;
    // Better on what is sure, to 90 %, than on all.
    const auto calibration = [&](const cv::Mat1b& mask) {
      return evaluate::Calibrate(ToPx(judged.disparity), scene.frame.truth.left, mask,
                                 judged.confidence, judged.sigma);
    };
    cv::Mat1b sure_pixels;
    cv::bitwise_and(scene.nonoccluded, judged.confidence >= 230, sure_pixels);
    const evaluate::Calibration sure = calibration(sure_pixels);
    const evaluate::Calibration all = calibration(scene.nonoccluded);
    EXPECT_LT(sure.bad1_percent, all.bad1_percent) << preset;
    EXPECT_LT(sure.bad1_percent, 20) << preset;
    // 2σ hold more than one σ of normal errors would.
    EXPECT_GT(all.within_2_sigma_percent, 68.3) << preset;
  }
}

TEST(Pipeline, SaysThatAPoseIsOffOfTheFirstFrameAndEveryNthOfItsNumber) {
  CaptureConfig capture;
  capture.mutable_sr4000()->set_calibration_error_px(4);
  const evaluate::Scene scene =
      evaluate::LoadScene("synthetic:640x480", evaluate::TofChoice("sr4000"), capture);
  for (const bool aligns : {true, false}) {
    SproutConfig config = LoadConfig({"default", "refine { check_tof_every: 10 }"});
    config.mutable_refine()->set_align_tof(aligns);
    Pipeline pipeline(config);
    for (const int64_t seq : {7, 8, 10}) {
      const std::string text =
          Compute(pipeline, scene, FrameTime{.utime = seq, .seq = seq}).value().range_error;
      EXPECT_EQ(text.ends_with("px in the left image: calibrate again"), seq != 8)
          << aligns << ", " << seq << ": " << text;
    }
  }
}

TEST(Pipeline, GivesTheSameBytesForAnyNumberOfThreadsAndWhateverCameBefore) {
  const evaluate::Scene scene = evaluate::SmallScene();
  const evaluate::Scene other =
      evaluate::LoadScene("synthetic:64x48", evaluate::TofChoice("none"), {});
  const int threads = cv::getNumThreads();
  Pipeline pipeline(LoadConfig({"default"}));
  cv::setNumThreads(1);
  const DepthFrame once = Compute(pipeline, scene).value();
  const cv::Mat1f kept = once.depth_m.clone();
  ASSERT_TRUE(Compute(pipeline, other));
  cv::setNumThreads(3);
  Pipeline moved = std::move(pipeline);
  const DepthFrame again = Compute(moved, scene).value();
  cv::setNumThreads(threads);
  EXPECT_TRUE(SameBytes(once.depth_m, again.depth_m));
  EXPECT_TRUE(SameBytes(once.disparity.counts(), again.disparity.counts()));
  EXPECT_TRUE(SameBytes(kept, once.depth_m)) << "a result changed after it was given out";
}

TEST(Pipeline, LeavesTheImagesOfTheCallerAsTheyAre) {
  const evaluate::Scene scene = evaluate::SmallScene();
  const cv::Mat left = scene.left_grey.clone(), right = scene.right_grey.clone();
  Pipeline pipeline(LoadConfig({"default"}));
  const auto result = pipeline.Compute(left, right, scene.frame.tof, scene.projector.rig());
  ASSERT_TRUE(result.has_value());
  EXPECT_TRUE(SameBytes(left, scene.left_grey));
  EXPECT_TRUE(SameBytes(right, scene.right_grey));
}

TEST(Pipeline, GivesDepthInMetresAndNaNWhereThereIsNone) {
  const evaluate::Scene scene = evaluate::SmallScene();
  SproutConfig config = LoadConfig({"default"});
  config.mutable_grow()->set_min_confidence(160);  // takes some pixels away
  Pipeline pipeline(config);
  const DepthFrame result = Compute(pipeline, scene).value();
  const RectifiedPair& pair = scene.projector.rig().pair;
  int64_t with_depth = 0;
  for (int v = 0; v < scene.size().height; ++v) {
    for (int u = 0; u < scene.size().width; ++u) {
      const float depth_m = result.depth_m(v, u);
      EXPECT_EQ(std::isnan(depth_m), !result.disparity.IsValid(u, v));
      if (std::isnan(depth_m)) continue;
      ++with_depth;
      EXPECT_FLOAT_EQ(
          depth_m, static_cast<float>(pair.DepthFromDisparity(double{result.disparity.Px(u, v)})));
    }
  }
  EXPECT_GT(with_depth, 1000);
  EXPECT_LT(with_depth, scene.size().area());
}

TEST(Pipeline, DoesWithoutAToFImage) {
  const evaluate::Scene scene = evaluate::SmallScene();
  const SproutConfig config = LoadConfig({"default"});
  Rig rig = scene.projector.rig();
  Pipeline pipeline(config);
  const auto blind = pipeline.Compute(scene.frame.left, scene.frame.right, {}, rig);
  ASSERT_TRUE(blind);
  EXPECT_GT(blind->disparity.CountValid(), 0);
  rig.tof = {};
  const auto no_camera = pipeline.Compute(scene.frame.left, scene.frame.right, {}, rig);
  ASSERT_TRUE(no_camera);
  EXPECT_TRUE(SameBytes(blind->depth_m, no_camera->depth_m));
}

// A multi-zone sensor that sees everything half as far again, so that nothing near may be a seed.
class PipelineWithZones : public testing::Test {
 protected:
  PipelineWithZones() {
    zones_ = *scene_.frame.tof_zones;
    for (ZoneTarget& target : zones_.targets) target.depth_m *= 1.5F;
  }

  Result<DepthFrame> ComputeWith(Pipeline& pipeline, const TofZones& zones) const {
    return pipeline.Compute(scene_.frame.left, scene_.frame.right, {}, scene_.projector.rig(), {},
                            zones);
  }

  SproutConfig config_ = LoadConfig({"default", "refine { zones: true }"});
  evaluate::Scene scene_ =
      evaluate::LoadScene("synthetic:160x120", evaluate::TofChoice("zones:8x8"), {});
  TofZones zones_;
};

TEST_F(PipelineWithZones, GivesWhatTheServicesGive) {
  Frame frame = evaluate::FrameOf(scene_);
  frame.tof = TofImage();
  frame.tof_zones = zones_;
  EXPECT_TRUE(refine::RefineAdapter(config_.refine()).Inputs().Has(Part::kTofZones));
  Services(config_).Answer(frame);
  Pipeline pipeline(config_);
  const DepthFrame result = ComputeWith(pipeline, zones_).value();
  EXPECT_TRUE(SameBytes(result.disparity.counts(), frame.disparity->counts()));
  EXPECT_EQ(result.seeds, *frame.seeds);
  EXPECT_EQ(result.left_seeds, *frame.left_seeds);
  const DepthFrame without = ComputeWith(pipeline, {}).value();
  EXPECT_LT(result.seeds.seeds.size(), without.seeds.seeds.size());
  EXPECT_GT(result.left_seeds.seeds.size(), without.left_seeds.seeds.size());
  Pipeline other(LoadConfig({"default"}));
  const DepthFrame never = ComputeWith(other, {}).value();
  EXPECT_TRUE(SameBytes(without.disparity.counts(), never.disparity.counts()));
}

TEST_F(PipelineWithZones, SaysWhatDoesNotFit) {
  const auto error_of = [&](const char* refine, const TofZones& zones) -> std::string {
    Pipeline pipeline(LoadConfig({"default", refine}));
    const auto result = ComputeWith(pipeline, zones);
    return result ? "no error" : result.error().text;
  };
  EXPECT_EQ(error_of("refine { zones: true }", zones_), "no error");
  EXPECT_EQ(error_of("refine { zones: false }", zones_),
            "zones: 8x8, but refine.zones is false; allowed: 0x0, or refine.zones: true");
  TofZones wrong = zones_;
  wrong.rows = 7;
  EXPECT_EQ(error_of("refine { zones: true }", wrong),
            "zones: views = 64: allowed is columns × rows = 56");
  wrong = zones_;
  wrong.targets.pop_back();
  EXPECT_THAT(error_of("refine { zones: true }", wrong), HasSubstr("zones: targets = "));
  wrong = zones_;
  wrong.targets[3] = {.depth_m = -1, .sigma_m = 1, .status = TargetStatus::kValid};
  EXPECT_THAT(error_of("refine { zones: true }", wrong),
              HasSubstr("zones: target 3: depth_m = -1: allowed is above 0"));
}

TEST(Pipeline, WarnsOfAFrameInWhichThereIsNothing) {
  const evaluate::Scene scene = evaluate::SmallScene();
  const cv::Mat black(scene.size(), CV_8UC3, cv::Scalar());
  Pipeline pipeline(LoadConfig({"default"}));
  const auto result = pipeline.Compute(black, black, {}, scene.projector.rig());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->disparity.CountValid(), 0);
  EXPECT_EQ(result->disparity.size(), scene.size());
  EXPECT_THAT(result->warnings, testing::ElementsAre(HasSubstr("refine: "), HasSubstr("prior: "),
                                                     HasSubstr("grow: no seeds")));
}

// A video of things that move before a camera that stands.
class PipelineWithMemory : public testing::Test {
 protected:
  PipelineWithMemory() {
    CaptureConfig capture;
    capture.set_source("synthetic:240x180");
    capture.set_tof_grid_px(6);
    const auto dataset = scenes::OpenDataset(capture);
    rig_ = dataset->rig();
    for (int64_t i = 0; i < 4; ++i) frames_.push_back(dataset->Get(i));
  }

  static FrameTime TimeOf(size_t i) {
    return {.utime = 5'000'000 + 100'000 * static_cast<int64_t>(i),
            .seq = 40 + static_cast<int64_t>(i)};
  }

  DepthFrame ComputeFrame(Pipeline& pipeline, size_t i,
                          std::optional<FrameTime> time = std::nullopt) const {
    return pipeline.Compute(frames_[i].left, frames_[i].right, frames_[i].tof, rig_, time).value();
  }

  static bool SameMemory(const DepthFrame& a, const DepthFrame& b) {
    return SameBytes(a.fused.counts(), b.fused.counts()) &&
           SameBytes(a.fused_confidence, b.fused_confidence) && a.motion == b.motion;
  }

  SproutConfig config_ = LoadConfig({"default", "temporal { in_pipeline: true }"});
  Rig rig_;
  std::vector<scenes::DatasetFrame> frames_;
};

TEST_F(PipelineWithMemory, GivesWhatTheServicesGive) {
  Services services(config_);
  temporal::TemporalAdapter temporal(config_.temporal());
  Pipeline pipeline(config_);
  for (size_t i = 0; i < frames_.size(); ++i) {
    Frame frame;
    frame.id = {.utime = TimeOf(i).utime, .seq = TimeOf(i).seq, .rig_id = RigId(rig_)};
    frame.left = frames_[i].left;
    frame.right = frames_[i].right;
    frame.tof = frames_[i].tof;
    frame.rig = rig_;
    services.Answer(frame);
    AddAnswer(temporal, frame);
    const DepthFrame result = ComputeFrame(pipeline, i, TimeOf(i));
    EXPECT_TRUE(SameBytes(result.disparity.counts(), frame.disparity->counts()));
    EXPECT_TRUE(SameBytes(result.fused.counts(), frame.fused->counts()));
    EXPECT_TRUE(SameBytes(result.fused_confidence, frame.fused_confidence));
    EXPECT_EQ(result.motion, frame.motion);
    EXPECT_EQ(result.motion->reset, i == 0 ? MemoryReset::kFirst : MemoryReset::kNone);
    EXPECT_EQ(SameBytes(result.fused.counts(), result.disparity.counts()), i == 0);
  }
}

TEST_F(PipelineWithMemory, NeedsNoTimesAndForgetsWhenTold) {
  Pipeline pipeline(config_), timed(config_);
  DepthFrame last;
  for (size_t i = 0; i < 3; ++i) {
    last = ComputeFrame(pipeline, i);
    const DepthFrame expected = ComputeFrame(timed, i, TimeOf(i));
    EXPECT_TRUE(SameBytes(last.fused.counts(), expected.fused.counts()));
  }
  EXPECT_EQ(last.motion->reset, MemoryReset::kNone);
  pipeline.Reset();
  const DepthFrame first = ComputeFrame(pipeline, 3);
  EXPECT_EQ(first.motion->reset, MemoryReset::kFirst);
  EXPECT_TRUE(SameBytes(first.fused.counts(), first.disparity.counts()));
}

TEST_F(PipelineWithMemory, ListensToTimes) {
  Pipeline pipeline(config_);
  ComputeFrame(pipeline, 0, TimeOf(0));
  const DepthFrame once = ComputeFrame(pipeline, 1, TimeOf(1));
  EXPECT_TRUE(SameMemory(once, ComputeFrame(pipeline, 1, TimeOf(1))));  // the same frame again
  const FrameTime late{.utime = TimeOf(1).utime + 600'000, .seq = TimeOf(2).seq};
  EXPECT_EQ(ComputeFrame(pipeline, 2, late).motion->reset, MemoryReset::kGap);
  const auto bad = pipeline.Compute(frames_[3].left, frames_[3].right, {}, rig_,
                                    FrameTime{.utime = 1, .seq = -1});
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().text, "time.seq: -1; allowed: 0 to 2^62");
}

TEST_F(PipelineWithMemory, GivesDepthOfTheFusedMapWhenAsked) {
  Pipeline pipeline(config_);
  config_.mutable_depth()->set_input(DepthConfig::FUSED);
  Pipeline of_fused(config_);
  for (size_t i = 0; i < 2; ++i) {
    const DepthFrame single = ComputeFrame(pipeline, i), fused = ComputeFrame(of_fused, i);
    EXPECT_TRUE(SameMemory(single, fused));
    EXPECT_TRUE(SameBytes(single.depth_m, DepthMap(rig_.pair, single.disparity)));
    EXPECT_TRUE(SameBytes(fused.depth_m, DepthMap(rig_.pair, single.fused)));
  }
}

TEST_F(PipelineWithMemory, RefusesWhatContradictsItself) {
  config_.mutable_grow()->set_publish_confidence(false);
  EXPECT_THROW(Pipeline{config_}, ConfigError);
  config_ = LoadConfig({"default", "depth { input: FUSED }"});
  EXPECT_THROW(Pipeline{config_}, ConfigError);
  Pipeline without(LoadConfig({"default"}));
  without.Reset();
  const DepthFrame result = ComputeFrame(without, 0);
  EXPECT_TRUE(result.fused.counts().empty() && result.fused_confidence.empty() && !result.motion);
}

TEST(Pipeline, SaysWhatDoesNotFit) {
  const evaluate::Scene scene = evaluate::SmallScene();
  const scenes::DatasetFrame& frame = scene.frame;
  const cv::Mat &left = frame.left, &right = frame.right;
  const TofImage& tof = frame.tof;
  const Rig& rig = scene.projector.rig();
  EXPECT_EQ(ErrorFor(left, right, tof, rig), "no error");
  EXPECT_THAT(ErrorFor({}, right, tof, rig),
              HasSubstr("left: 0x0; allowed: the calibrated size 96x72"));
  EXPECT_THAT(ErrorFor(left, right.colRange(0, 90), tof, rig), HasSubstr("right: 90x72"));
  EXPECT_THAT(ErrorFor(cv::Mat1f(scene.size(), 0.F), right, tof, rig),
              HasSubstr("left: of OpenCV's type CV_32FC1; allowed: CV_8UC1, CV_8UC3"));
  EXPECT_THAT(ErrorFor(left, right, {.depth_m = cv::Mat1f(3, 3, 1.F), .amplitude = {}}, rig),
              HasSubstr("3x3"));
  EXPECT_THAT(
      ErrorFor(left, right, {.depth_m = tof.depth_m, .amplitude = cv::Mat1f(1, 1, 1.F)}, rig),
      HasSubstr("tof.amplitude: 1x1"));
  Rig bad = rig;
  bad.pair.baseline_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorFor(left, right, tof, bad), HasSubstr("baseline_m"));
  SproutConfig config = LoadConfig({"default"});
  config.mutable_grow()->set_threshold(7);
  EXPECT_THROW(Pipeline{config}, ConfigError);
}

}  // namespace
}  // namespace sprout
