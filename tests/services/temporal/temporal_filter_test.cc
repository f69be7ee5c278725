#include "services/temporal/temporal_filter.h"

#include <gmock/gmock.h>

#include <functional>
#include <vector>

#include "tests/common/testing/instruction_sets.h"
#include "tests/services/temporal/drive.h"

namespace sprout::temporal {
namespace {

bool IsSame(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::countNonZero(a != b) == 0;
}

bool IsSame(const TemporalOutput& a, const TemporalOutput& b) {
  return IsSame(a.disparity.counts(), b.disparity.counts()) && IsSame(a.confidence, b.confidence) &&
         a.motion == b.motion;
}

TEST(TemporalFilter, GivesTheFirstFrameAsItIs) {
  TemporalFilter filter(Defaults());
  const TemporalInput input = Drive(1)[0];
  const TemporalOutput output = filter.Compute(input);
  EXPECT_TRUE(IsSame(output.disparity.counts(), input.disparity.counts()));
  EXPECT_TRUE(IsSame(output.confidence, input.confidence));
  EXPECT_EQ(output.motion.reset, MemoryReset::kFirst);
  EXPECT_EQ(output.motion.resets, 0);
}

TEST(TemporalFilter, SteadiesAStillSceneAndStandsStill) {
  const MovingScene scene = SceneFrom(MovedBy(0, 0, 0));
  std::vector<TemporalInput> frames;
  for (int i = 0; i < 12; ++i) frames.push_back(FrameFrom(scene, i, kNoisePx));
  const TemporalOutput output = LastOf(frames);
  const double single = ErrorOf(FrameFrom(scene, 11, kNoisePx).disparity, scene);
  EXPECT_LT(ErrorOf(output.disparity, scene), 0.45 * single);
  EXPECT_LT(output.motion.start_from_left.translation_m.norm(), 0.001);
  EXPECT_GT(cv::mean(output.confidence)[0], 230);
}

// The largest confidence after twelve frames of one confidence.
int MostAfterFramesOf(uint8_t confidence, const std::function<Pose(int)>& pose_at) {
  TemporalFilter filter(Defaults());
  TemporalOutput output;
  for (int i = 0; i < 12; ++i) {
    TemporalInput input = FrameFrom(SceneFrom(pose_at(i)), i, kNoisePx);
    input.confidence.setTo(confidence);
    output = filter.Compute(input);
  }
  double largest = 0;
  cv::minMaxLoc(output.confidence, nullptr, &largest);
  return static_cast<int>(largest);
}

// (T10): what errs alike makes nothing surer. What is seen from elsewhere errs alike by half.
TEST(TemporalFilter, IsSurerOnlyOfWhatIsSeenFromElsewhere) {
  constexpr uint8_t kOfOne = 200;
  const ConfidenceScale scale;
  const int of_half = scale.ConfidenceOf(scale.variances()[kOfOne] / 2);
  ASSERT_GT(of_half, kOfOne + 20);
  EXPECT_EQ(MostAfterFramesOf(kOfOne, [](int) { return MovedBy(0, 0, 0); }), kOfOne);
  EXPECT_EQ(MostAfterFramesOf(kOfOne, [](int i) { return MovedBy(0, 0, 0, 0.004 * i); }), kOfOne);
  EXPECT_EQ(MostAfterFramesOf(kOfOne, [](int i) { return PoseAt(2 * i); }), of_half);
}

// Where nothing is known from before, the confidence is that of the frame, however low.
TEST(TemporalFilter, IsNoSurerOfWhatIsNew) {
  constexpr uint8_t kUnsure = 20;
  const cv::Rect place(60, 60, 80, 50);
  TemporalFilter filter(Defaults());
  const MovingScene scene = SceneFrom(MovedBy(0, 0, 0));
  TemporalOutput output;
  for (int i = 0; i < 3; ++i) {
    TemporalInput input = FrameFrom(scene, i, kNoisePx);
    if (i < 2) input.disparity.counts()(place).setTo(DisparityImage::kInvalid);
    input.confidence(place).setTo(kUnsure);
    output = filter.Compute(input);
  }
  const cv::Rect inside(place.tl() + cv::Point(3, 3), place.br() - cv::Point(3, 3));
  EXPECT_EQ(cv::countNonZero(output.confidence(inside) != kUnsure), 0);
}

// A map that all later ones contradict: two frames, and what is claimed of it falls at once.
TEST(TemporalFilter, GivesUpWhatNewMapsContradict) {
  const MovingScene scene = SceneFrom(MovedBy(0, 0, 0));
  TemporalFilter filter(Defaults());
  TemporalOutput output;
  for (int i = 0; i < 12; ++i) {
    TemporalInput input = FrameFrom(scene, i, kNoisePx);
    input.confidence.setTo(245);
    if (i < 9) input.disparity.counts() += 10 * DisparityImage::kCountsPerPixel;
    output = filter.Compute(input);
    if (i == 9) {
      EXPECT_LT(cv::mean(output.confidence)[0], 150);
    }
  }
  EXPECT_LT(ErrorOf(output.disparity, scene), 0.5);
}

// What no map shows any more is not kept for ever.
TEST(TemporalFilter, ForgetsWhatNoNewMapShows) {
  const cv::Rect place(60, 60, 80, 50);
  const MovingScene scene = SceneFrom(MovedBy(0, 0, 0));
  TemporalFilter filter(Defaults());
  TemporalOutput output;
  for (int i = 0; i < 24; ++i) {
    TemporalInput input = FrameFrom(scene, i, kNoisePx);
    if (i >= 4) input.disparity.counts()(place).setTo(DisparityImage::kInvalid);
    output = filter.Compute(input);
    const cv::Mat known = output.disparity.counts()(place) != DisparityImage::kInvalid;
    if (i == 8) {
      EXPECT_GT(cv::countNonZero(known), place.area() * 9 / 10);
    }
  }
  EXPECT_EQ(cv::countNonZero(output.disparity.counts()(place) != DisparityImage::kInvalid), 0);
}

TEST(TemporalFilter, MovesTheMapWithTheCamera) {
  constexpr int kFrames = 10;
  const std::vector<TemporalInput> drive = Drive(kFrames);
  const TemporalOutput output = LastOf(drive);
  const MovingScene last = SceneFrom(PoseAt(kFrames - 1));
  EXPECT_LT(ErrorOf(output.disparity, last), 0.6 * ErrorOf(drive.back().disparity, last));
  EXPECT_EQ(output.motion.resets, 0);
  EXPECT_EQ(output.motion.start_seq, 0);
  EXPECT_EQ(output.motion.last_seq, kFrames - 2);
  // The way, and the last step, to 3 %: at the edges of the board windows see both surfaces.
  const Pose step = PoseAt(kFrames - 2).Inverse() * PoseAt(kFrames - 1);
  const Pose way = PoseAt(0).Inverse() * PoseAt(kFrames - 1);
  EXPECT_LT((output.motion.last_from_left.translation_m - step.translation_m).norm(),
            0.03 * step.translation_m.norm());
  EXPECT_LT((output.motion.start_from_left.translation_m - way.translation_m).norm(),
            0.03 * way.translation_m.norm());
  EXPECT_LT((output.motion.last_from_left.Inverse() * step).rotation.vec().norm(), 2e-4);
  EXPECT_GT(output.motion.covariance[0], 0);
}

// Of a right camera whose principal point lies farther right all disparities are that much smaller.
TEST(TemporalFilter, FusesNegativeDisparities) {
  constexpr int kShiftPx = 60;
  TemporalFilter filter(Defaults()), of_shifted(Defaults());
  TemporalOutput output, shifted;
  for (TemporalInput input : Drive(6)) {
    output = filter.Compute(input);
    input.disparity = DisparityImage(
        cv::Mat1s(input.disparity.counts() - kShiftPx * DisparityImage::kCountsPerPixel));
    input.pair.cx_right += kShiftPx;
    shifted = of_shifted.Compute(input);
  }
  EXPECT_EQ(shifted.motion.reset, MemoryReset::kNone);
  EXPECT_EQ(shifted.motion.inliers, output.motion.inliers);
  const cv::Mat difference = output.disparity.counts() - shifted.disparity.counts();
  const cv::Mat other = cv::abs(difference - kShiftPx * DisparityImage::kCountsPerPixel) > 1;
  EXPECT_LT(cv::countNonZero(other), 10);
}

TEST(TemporalFilter, FillsWhatTheNewMapLacks) {
  std::vector<TemporalInput> drive = Drive(4);
  const cv::Rect hole(60, 60, 80, 50);
  drive[3].disparity.counts()(hole).setTo(DisparityImage::kInvalid);
  const TemporalOutput output = LastOf(drive);
  const MovingScene last = SceneFrom(PoseAt(3));
  int filled = 0;
  for (int v = hole.y; v < hole.br().y; ++v) {
    for (int u = hole.x; u < hole.br().x; ++u) {
      filled += std::abs(output.disparity.Px(u, v) - last.truth(v, u)) < 1 ? 1 : 0;
    }
  }
  EXPECT_GT(filled, hole.area() * 9 / 10);
}

TEST(TemporalFilter, BelievesTheMemoryWhereTheNewMapIsUnsureAndWrong) {
  std::vector<TemporalInput> drive = Drive(4);
  const cv::Rect wrong(60, 60, 80, 50);
  drive[3].disparity.counts()(wrong) += 10 * DisparityImage::kCountsPerPixel;
  drive[3].confidence(wrong).setTo(60);
  EXPECT_LT(ErrorOf(LastOf(drive).disparity, SceneFrom(PoseAt(3))), 0.5);
}

// What was there before leaves no trail when the images say that it is gone.
TEST(TemporalFilter, ForgetsWhatMovedAway) {
  TemporalFilter filter(Defaults());
  const MovingScene scene = SceneFrom(MovedBy(0, 0, 0));
  MovingScene empty = scene;  // the board is gone: wall everywhere
  const MovingScene wall = SceneFrom(MovedBy(2, 0, 0));
  const cv::Mat gone = scene.truth > scene.truth(0, 0) + 1;
  wall.left.copyTo(empty.left, gone);
  wall.truth.copyTo(empty.truth, gone);
  for (int i = 0; i < 4; ++i) filter.Compute(FrameFrom(scene, i, kNoisePx));
  const TemporalOutput output = filter.Compute(FrameFrom(empty, 4, kNoisePx));
  int trail = 0;
  for (int v = 0; v < empty.truth.rows; ++v) {
    for (int u = 0; u < empty.truth.cols; ++u) {
      if (gone.at<uint8_t>(v, u) == 0) continue;
      trail += std::abs(output.disparity.Px(u, v) - empty.truth(v, u)) > 3 ? 1 : 0;
    }
  }
  EXPECT_LT(trail, cv::countNonZero(gone) / 50);
}

TEST(TemporalFilter, GivesTheNewestFrameTheSameAnswerAgain) {
  TemporalFilter filter(Defaults());
  TemporalFilter other(Defaults());
  TemporalOutput once, twice;
  for (const TemporalInput& input : Drive(4)) {
    once = filter.Compute(input);
    other.Compute(input);
    twice = other.Compute(input);
    EXPECT_TRUE(IsSame(once, twice)) << input.id.seq;
  }
}

// A camera that hangs: what is measured once is not surer when it comes again.
TEST(TemporalFilter, IsNoSurerOfAFrozenPicture) {
  TemporalFilter filter(Defaults());
  TemporalFilter other(Defaults());
  std::vector<TemporalInput> drive = Drive(5);
  TemporalOutput moving, frozen;
  for (int i = 0; i < 4; ++i) moving = filter.Compute(drive[static_cast<size_t>(i)]);
  TemporalInput again = drive[3];
  for (int i = 0; i < 20; ++i) {
    ++again.id.seq;
    again.id.utime += 100'000;
    frozen = filter.Compute(again);
    ASSERT_TRUE(IsSame(frozen.disparity.counts(), moving.disparity.counts())) << i;
    ASSERT_TRUE(IsSame(frozen.confidence, moving.confidence)) << i;
    ASSERT_EQ(frozen.motion.start_from_left, moving.motion.start_from_left) << i;
    ASSERT_EQ(frozen.motion.resets, 0) << i;
  }
  // It goes on where it was.
  drive[4].id.seq = again.id.seq + 1;
  drive[4].id.utime = again.id.utime + 100'000;
  EXPECT_EQ(filter.Compute(drive[4]).motion.resets, 0);
  // One grey level is a new picture.
  again.id = drive[3].id;
  ++again.id.seq;
  again.id.utime += 100'000;
  again.left = again.left.clone();
  again.left(0, 0) ^= 1;
  for (int i = 0; i < 4; ++i) moving = other.Compute(drive[static_cast<size_t>(i)]);
  EXPECT_FALSE(IsSame(other.Compute(again).disparity.counts(), moving.disparity.counts()));
}

TEST(TemporalFilter, BeginsAnewAfterReset) {
  TemporalFilter filter(Defaults());
  TemporalFilter fresh(Defaults());
  const std::vector<TemporalInput> drive = Drive(4);
  filter.Compute(drive[0]);
  filter.Compute(drive[1]);
  filter.Reset();
  for (size_t i = 2; i < 4; ++i) {
    EXPECT_TRUE(IsSame(filter.Compute(drive[static_cast<size_t>(i)]), fresh.Compute(drive[i])));
  }
}

TEST(TemporalFilter, GivesTheSameBytesWithAnyThreadsAndInstructionSet) {
  const std::vector<TemporalInput> drive = Drive(4);
  const auto run = [&](int threads) {
    cv::setNumThreads(threads);
    TemporalFilter filter(Defaults());
    std::vector<TemporalOutput> outputs;
    for (const TemporalInput& input : drive) outputs.push_back(filter.Compute(input));
    cv::setNumThreads(1);
    return outputs;
  };
  const std::vector<TemporalOutput> expected = run(1);
  const auto expect_same = [&](int threads) {
    const std::vector<TemporalOutput> outputs = run(threads);
    for (size_t i = 0; i < drive.size(); ++i) EXPECT_TRUE(IsSame(outputs[i], expected[i])) << i;
  };
  expect_same(2);
  expect_same(5);
  ForEachInstructionSet([&](const std::string&) { expect_same(1); });
}

// Images of odd sides, and of few pixels.
TEST(TemporalFilter, TakesImagesOfAnySize) {
  for (const cv::Size size : {cv::Size(1, 1), {2, 3}, {31, 1}, {33, 47}, {321, 239}, {515, 33}}) {
    TemporalFilter filter(Defaults());
    for (int i = 0; i < 3; ++i) {
      const MovingScene scene = SceneFrom(PoseAt(i), size);
      EXPECT_EQ(filter.Compute(FrameFrom(scene, i, kNoisePx)).disparity.size(), size);
    }
  }
}

// Each with its cause; the result is then the new map.
TEST(TemporalFilter, ForgetsBeforeAFrameThatDoesNotFollow) {
  const TemporalInput follows = Drive(4)[3];
  const auto expect = [&](MemoryReset reason, const std::function<void(TemporalInput&)>& change) {
    SCOPED_TRACE(static_cast<int>(reason));
    std::vector<TemporalInput> drive = Drive(3);
    TemporalInput next = follows;
    change(next);
    drive.push_back(next);
    const TemporalOutput output = LastOf(drive);
    EXPECT_EQ(output.motion.reset, reason);
    EXPECT_EQ(output.motion.resets, 1);
    EXPECT_EQ(output.motion.start_seq, next.id.seq);
    EXPECT_EQ(output.motion.start_from_left, Pose());
    EXPECT_TRUE(IsSame(output.disparity.counts(), next.disparity.counts()));
  };
  expect(MemoryReset::kOtherRig, [](TemporalInput& next) { next.id.rig_id = "another"; });
  expect(MemoryReset::kOtherRig, [](TemporalInput& next) {
    next = FrameFrom(SceneFrom(PoseAt(3), {160, 120}), 3, 0);
  });
  expect(MemoryReset::kBackwards, [](TemporalInput& next) { next.id.seq = 1; });
  expect(MemoryReset::kBackwards, [](TemporalInput& next) { next.id.utime = 1; });
  expect(MemoryReset::kGap, [](TemporalInput& next) { next.id.utime += 500'000; });
  for (const uint8_t level : {uint8_t{0}, uint8_t{130}}) {  // dark, and without texture
    expect(MemoryReset::kFewPoints,
           [&](TemporalInput& next) { next.left = cv::Mat1b(next.left.size(), level); });
  }
}

TEST(TemporalFilter, BridgesLostFrames) {
  TemporalFilter filter(Defaults());
  std::vector<TemporalInput> drive = Drive(8);
  filter.Compute(drive[0]);
  filter.Compute(drive[1]);
  const TemporalOutput output = filter.Compute(drive[5]);  // 0.4 s later
  EXPECT_EQ(output.motion.reset, MemoryReset::kNone);
  const MovingScene scene = SceneFrom(PoseAt(5));
  EXPECT_LT(ErrorOf(output.disparity, scene), 0.9 * ErrorOf(drive[5].disparity, scene));
}

// A hand before the lens for three frames: as good as single frames at once, and better again soon.
TEST(TemporalFilter, RecoversFromACoveredLens) {
  TemporalFilter filter(Defaults());
  std::vector<TemporalInput> drive = Drive(12);
  for (size_t i = 4; i < 7; ++i) {
    drive[i].left = cv::Mat1b(drive[i].left.size(), uint8_t{3});
    drive[i].disparity.counts().setTo(100 * DisparityImage::kCountsPerPixel);
    drive[i].confidence.setTo(20);
  }
  for (size_t i = 0; i < 12; ++i) {
    const TemporalOutput output = filter.Compute(drive[static_cast<size_t>(i)]);
    if (i < 7) continue;
    const MovingScene scene = SceneFrom(PoseAt(static_cast<int>(i)));
    const double single = ErrorOf(drive[i].disparity, scene);
    EXPECT_LT(ErrorOf(output.disparity, scene), (i < 9 ? 1.01 : 0.9) * single) << i;
    EXPECT_EQ(output.motion.resets, 4);  // three dark frames, and the first one after them
  }
}

// The light goes down by half: no reset, and no harm.
TEST(TemporalFilter, DoesNotMindTheLight) {
  std::vector<TemporalInput> drive = Drive(6);
  for (size_t i = 3; i < 6; ++i) drive[i].left = cv::Mat(drive[i].left * 0.5);
  const TemporalOutput output = LastOf(drive);
  EXPECT_EQ(output.motion.resets, 0);
  const MovingScene scene = SceneFrom(PoseAt(5));
  EXPECT_LT(ErrorOf(output.disparity, scene), 0.8 * ErrorOf(drive[5].disparity, scene));
}

TEST(TemporalFilter, RefusesValuesOutOfRange) {
  TemporalConfig config = Defaults();
  config.set_min_gain(2);
  EXPECT_THROW(TemporalFilter{config}, ConfigError);
  config = Defaults();
  config.set_gate_min_px(3);
  EXPECT_THROW(TemporalFilter{config}, ConfigError);
}

}  // namespace
}  // namespace sprout::temporal
