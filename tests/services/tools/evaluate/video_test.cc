#include "services/tools/evaluate/video.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "common/config/config_error.h"
#include "common/core/read_text.h"
#include "services/pipeline/pipeline.h"
#include "tests/common/core/centred.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/scenes/kitti_folder.h"
#include "tests/common/testing/thrown.h"

namespace sprout::evaluate {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

cv::Mat1b All(cv::Size size) { return cv::Mat1b(size, uint8_t{255}); }

// What the filter's memory fills with, and is not scored.
void AddTwoFrames(VideoScore& score, const cv::Mat1f& truth) {
  for (int i = 0; i < VideoScore::kFirstScored; ++i) {
    score.Add(cv::Mat1f(truth.size(), 99.F), truth, All(truth.size()));
  }
}

TEST(VideoScore, CountsErrorsOfPixelsWithATruthInTheMask) {
  const cv::Mat1f truth = (cv::Mat1f(1, 7) << 10, 10, 10, 10, 10, 10, kNaN);
  const cv::Mat1f map = (cv::Mat1f(1, 7) << 10, 10.5F, 12, 15, kNaN, 99, 99);
  cv::Mat1b mask = All(truth.size());
  mask(0, 5) = 0;
  VideoScore score;
  AddTwoFrames(score, truth);
  score.Add(map, truth, mask);
  const VideoFigures figures = score.figures();
  EXPECT_DOUBLE_EQ(figures.bad1_percent, 60);
  EXPECT_DOUBLE_EQ(figures.bad3_percent, 40);
  EXPECT_DOUBLE_EQ(figures.mean_px, (0 + 0.5 + 2 + 5 + 50) / 5);
  EXPECT_FALSE(figures.trail_percent || figures.covered_percent);
}

TEST(VideoScore, ComparesChangesWithThoseOfTheTruth) {
  VideoScore score;
  const cv::Mat1f first(2, 2, 10.F), second(2, 2, 11.F);
  AddTwoFrames(score, first);
  score.Add(cv::Mat1f(2, 2, 10.25F), first,
            All(first.size()));  // 99 → 10.25 without a cause: at most 20
  score.Add(cv::Mat1f(2, 2, 11.75F), second,
            All(first.size()));  // half a pixel more than the truth
  EXPECT_DOUBLE_EQ(score.figures().change_px, (20 + 0.5) / 2);
}

// A wall at 2 m that the camera goes along, 4 px a frame, and comes nearer to: what is seen at u
// was seen 4 px to the right of it. Its errors go with it; those of the pixels do not.
TEST(VideoScore, FollowsPointsAlongTheMotion) {
  const RectifiedPair pair = CentredPair(40, 4, 50, 0.4);
  const cv::Size size(40, 4);
  const cv::Mat1f truth(size, 10.F);
  const auto map_at = [&](int frame, float more) {
    cv::Mat1f map(size);
    for (int v = 0; v < map.rows; ++v) {
      for (int u = 0; u < map.cols; ++u) {
        map(v, u) = 10.F + 0.5F * static_cast<float>((u + 4 * frame) % 5) + more;
      }
    }
    return map;
  };
  VideoScore::TrueMotion motion{.left_from_last = {}, .pair = pair};
  motion.left_from_last.translation_m = {-0.16, 0, 0};
  VideoScore score;
  for (int i = 0; i < 4; ++i) score.Add(map_at(i, i == 3 ? 0.25F : 0.F), truth, All(size), motion);
  EXPECT_NEAR(*score.figures().along_px, 0.125, 1e-6);  // nothing in frame 2, 0.25 in frame 3
  EXPECT_GT(score.figures().change_px, 0.5);

  // The scene is 1 m nearer, so at 20 px; other truths are of other surfaces.
  motion.left_from_last.translation_m = {0, 0, -1};
  VideoScore nearer;
  AddTwoFrames(nearer, truth);
  nearer.Add(cv::Mat1f(size, 22.F), cv::Mat1f(size, 20.F), All(size), motion);
  EXPECT_NEAR(*nearer.figures().along_px, 20, 1e-6);  // from 89 px off to 2
  VideoScore other;
  AddTwoFrames(other, cv::Mat1f(size, 12.F));
  other.Add(cv::Mat1f(size, 22.F), cv::Mat1f(size, 20.F), All(size), motion);
  EXPECT_FALSE(other.figures().along_px);
}

// A near thing of two pixels that goes one to the right each frame, and a map that lags behind.
TEST(VideoScore, FindsTrailsAndWhatIsNewlyCovered) {
  const auto scene = [](int at) {
    cv::Mat1f truth(1, 12, 10.F);
    truth(0, at) = truth(0, at + 1) = 20;
    return truth;
  };
  VideoScore score;
  for (int i = 0; i < 5; ++i) score.Add(scene(std::max(0, i - 1)), scene(i), All({12, 1}));
  const VideoFigures figures = score.figures();
  // Frames 2, 3 and 4: one pixel is newly covered, and shows what is behind. Two pixels, and three
  // from frame 3 on, showed the thing in the last three frames; the map shows it in one of them.
  EXPECT_DOUBLE_EQ(*figures.covered_percent, 100);
  EXPECT_DOUBLE_EQ(*figures.trail_percent, 100.0 * 3 / (2 + 3 + 3));
  EXPECT_DOUBLE_EQ(figures.bad3_percent, 100.0 * 6 / 36);
  EXPECT_FALSE(figures.flicker_median_px) << "the scene does not stand still";
}

TEST(VideoScore, MeasuresFlickerOfAStillScene) {
  VideoScore score;
  const cv::Mat1f truth(1, 100, 10.F);
  AddTwoFrames(score, truth);
  for (int i = 0; i < 4; ++i) {
    cv::Mat1f map(truth.size());
    // Of every pixel i its own swing, ± i/10.
    for (int u = 0; u < map.cols; ++u) map(0, u) = 10.F + (i % 2 == 0 ? 0.1F : -0.1F) * float(u);
    score.Add(map, truth, All(truth.size()));
  }
  const double spread = std::sqrt(4.0 / 3);  // of ±1 twice
  EXPECT_NEAR(*score.figures().flicker_median_px, 5.0 * spread, 1e-5);
  EXPECT_NEAR(*score.figures().flicker_p95_px, 9.5 * spread, 1e-5);
}

TEST(MotionScore, ComparesMotionsAndCountsResets) {
  CameraMotion measured;
  measured.reset = MemoryReset::kFirst;
  MotionScore score;
  score.Add(measured, Pose());
  measured.reset = MemoryReset::kNone;
  measured.last_from_left.translation_m = {0, 0, 1.03};
  Pose truth;  // 1 m on, turned by 0.02 rad
  truth.rotation = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY());
  truth.translation_m = truth.rotation * Eigen::Vector3d(0, 0, -1);
  score.Add(measured, truth);
  measured.reset = MemoryReset::kGap;
  score.Add(measured, truth);
  EXPECT_EQ(score.frames, 1);
  EXPECT_EQ(score.resets, 1);
  EXPECT_DOUBLE_EQ(score.way_m, 1);
  EXPECT_NEAR(score.error_m, 0.03, 1e-12);
  EXPECT_NEAR(score.largest_m, 0.03, 1e-12);
  EXPECT_NEAR(score.turn_error, 0.02, 1e-9);
}

TEST(TrueMotions, AreThoseOfPosesAtThePlaceOfTheLeftCamera) {
  const scenes::KittiFolder folder;
  for (const std::string id : {"000000", "000001", "000002"}) {
    folder.WriteStereo(id);
    folder.WriteCalibration(id, "P2", "100 0 20 30 0 100 15 0 0 0 1 0");  // 0.3 m from camera 0
  }
  const std::string source = folder.Config("").source();
  EXPECT_THAT(TrueMotions(source, 3), testing::IsEmpty());
  // Turned by a right angle about y, then 2 m along its own z, which is the world's x.
  folder.files().WriteText("poses.txt",
                           "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 0 0 1 0 0 -1 0 0 0\n"
                           "0 0 1 2 0 1 0 0 -1 0 0 0\n");
  const std::vector<Pose> motions = TrueMotions(source, 3);
  ASSERT_THAT(motions, SizeIs(3));
  EXPECT_EQ(motions[0], Pose());
  // left_from_last: the camera of the last frame seen from now. The left camera is 0.3 m to the
  // left of camera 0 (what P2 adds), and swings around it.
  const Eigen::Vector3d turned = motions[1].rotation * Eigen::Vector3d::UnitX();
  EXPECT_NEAR((turned - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-12);
  EXPECT_NEAR((motions[1].translation_m - Eigen::Vector3d(0.3, 0, -0.3)).norm(), 0, 1e-12);
  EXPECT_NEAR(motions[2].rotation.vec().norm(), 0, 1e-12);
  EXPECT_NEAR((motions[2].translation_m - Eigen::Vector3d(0, 0, -2)).norm(), 0, 1e-12);

  // A part of a sequence that has the poses of the whole: a row a number.
  const std::string whole =
      "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n"
      "1 0 0 0 0 1 0 0 0 0 1 3\n1 0 0 0 0 1 0 0 0 0 1 6\n";
  const scenes::KittiFolder part;
  for (const std::string id : {"000001", "000002"}) {
    part.WriteStereo(id);
    part.WriteCalibration(id, "P2", "100 0 20 30 0 100 15 0 0 0 1 0");
  }
  part.files().WriteText("poses.txt", whole);
  EXPECT_EQ(TrueMotions(part.Config("").source(), 2)[1].translation_m.z(), -2);
  part.files().WriteText("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(Thrown<ConfigError>([&] { TrueMotions(part.Config("").source(), 2); }),
              HasSubstr("poses.txt: 1 rows, and none is known to be that of "));

  folder.files().WriteText("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 2 3\n");
  EXPECT_THROW(TrueMotions(source, 2), ConfigError);
  EXPECT_THAT(TrueMotions("synthetic:64x48", 4), SizeIs(4));
}

TEST(AwayFromPoints, LeavesOutWhatIsNearThePointsOfThreeFrames) {
  Rig rig;  // a ToF camera of one pixel in the left camera's place
  rig.pair = CentredPair(60, 20, 50);
  rig.tof = {.width = 1, .height = 1, .fx = 50, .fy = 50, .cx = 0, .cy = 0};
  const TofImage one{.depth_m = cv::Mat1f(1, 1, 2.F), .amplitude = {}};
  Pose aside;  // the scene goes 0.4 m to the right: 10 px at 2 m
  aside.translation_m = {0.4, 0, 0};
  AwayFromPoints away;
  const auto expected = [](std::initializer_list<int> columns) {
    cv::Mat1b mask(20, 60, uint8_t{255});
    for (const int u : columns) mask(cv::Rect(u - 2, 8, 5, 5)) = 0;
    return mask;
  };
  const auto same = [](const cv::Mat1b& a, const cv::Mat1b& b) {
    return cv::countNonZero(a != b) == 0;
  };
  EXPECT_TRUE(same(away.Add(one, rig, Pose()), expected({30})));
  EXPECT_TRUE(same(away.Add(one, rig, aside), expected({30, 40})));
  EXPECT_TRUE(same(away.Add({}, rig, Pose()), expected({30, 40})));
  EXPECT_TRUE(same(away.Add({}, rig, Pose()), expected({30})));  // the first is forgotten
}

TEST(VideoPictures, ShowErrorsOfSixFramesAndAllInAPlot) {
  const TemporaryDirectory folder;
  VideoPictures pictures("synthetic:8x6?tof=none", 12);
  const cv::Size size(8, 6);
  const cv::Mat1f truth(size, 10.F);
  for (int i = 0; i < 12; ++i) {
    cv::Mat1f half_wrong(size, 10.F);
    half_wrong.colRange(0, 4).setTo(i < 6 ? 14.F : kNaN);
    pictures.Add(i, cv::Mat1b(size, uint8_t{90}), truth, All(size),
                 {cv::Mat1f(size, 13.F), half_wrong, cv::Mat1f(size, 14.F)});
  }
  EXPECT_EQ(pictures.bad3_percent()[0], std::vector<double>(12, 0));
  EXPECT_EQ(pictures.bad3_percent()[1], std::vector<double>(12, 50));
  EXPECT_EQ(pictures.bad3_percent()[2], std::vector<double>(12, 100));
  pictures.Write(folder / "");
  const std::string name = folder / "synthetic_8x6_tof_none";
  const cv::Mat strip = cv::imread(name + "_strip.png");
  EXPECT_GT(strip.cols, 4 * kFigureCellWidth);
  EXPECT_GT(strip.rows, 6 * kFigureCellWidth * 3 / 4);
  EXPECT_LT(strip.rows, 7 * kFigureCellWidth);
  const std::string plot = ReadText(name + ".svg", 100'000).value();
  EXPECT_THAT(plot, HasSubstr(">synthetic:8x6?tof=none</text>"));
  // Half of the height, from the left to the right edge.
  EXPECT_THAT(plot, HasSubstr("stroke=\"#3070c0\" stroke-width=\"1\" points=\"56.0,156.0 "));
  EXPECT_THAT(plot, HasSubstr(" 536.0,156.0\"/>"));
}

TEST(EvaluateVideo, SaysWhatIsNoVideo) {
  VideoSettings settings;
  settings.config = LoadConfig({"fast"});
  settings.frames = 2;
  const auto complaint = [&](const std::string& source) {
    return Thrown<ConfigError>([&] { EvaluateVideo(source, settings, [](int) {}); });
  };
  EXPECT_THAT(complaint("synthetic:160x120"), HasSubstr("2 frames (--frames): allowed are 3"));
  const scenes::KittiFolder folder("000000");
  folder.WriteCalibration("000000", "P2", "100 0 20 30 0 100 15 0 0 0 1 0");
  settings.frames = 5;
  EXPECT_THAT(complaint(folder.Config("/000000").source()),
              HasSubstr("000000: 1 frames (--frames): allowed are 3"));
}

// The pipeline with memory, which computes the same from the outside.
TEST(EvaluateVideo, ScoresWhatThePipelineGives) {
  VideoSettings settings;
  settings.config = LoadConfig({"default", "temporal { in_pipeline: true }"});
  settings.frames = 5;
  const std::string source = "synthetic:160x120";
  int frames_seen = 0;
  const VideoResult result =
      EvaluateVideo(source, settings, [&](int frame) { EXPECT_EQ(frame, frames_seen++); });
  EXPECT_EQ(frames_seen, 5);
  EXPECT_EQ(result.frames, 5);
  EXPECT_TRUE(result.motion_known);

  CaptureConfig capture = settings.config.capture();
  capture.set_source(source);
  const auto dataset = scenes::OpenDataset(capture);
  Pipeline pipeline(settings.config);
  VideoScore single, fused;
  for (int64_t i = 0; i < 5; ++i) {
    const scenes::DatasetFrame frame = dataset->Get(i);
    const FrameTime time{.utime = 100'000 * (i + 1), .seq = i};
    const DepthFrame depth =
        pipeline.Compute(frame.left, frame.right, frame.tof, dataset->rig(), time).value();
    single.Add(ToPx(depth.disparity), frame.truth.left, All(frame.truth.left.size()));
    fused.Add(ToPx(depth.fused), frame.truth.left, All(frame.truth.left.size()));
  }
  EXPECT_EQ(result.single.bad1_percent, single.figures().bad1_percent);
  EXPECT_EQ(result.single.change_px, single.figures().change_px);
  EXPECT_EQ(result.fused.mean_px, fused.figures().mean_px);
  EXPECT_EQ(result.fused.covered_percent, fused.figures().covered_percent);
  EXPECT_NE(result.fused.mean_px, result.single.mean_px);
  EXPECT_THAT(VideoTable({result, result}), HasSubstr("| mean | single | "));
}

}  // namespace
}  // namespace sprout::evaluate
