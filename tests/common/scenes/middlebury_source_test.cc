#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/common/scenes/scene_folder.h"

namespace sprout::scenes {
namespace {

bool EqualBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(MiddleburyDataset, ReadsTheLayoutOf2005) {
  const SceneFolder folder(cv::Size(40, 1110));
  folder.WriteImage("disp5.png", cv::Mat1b(1110, 40, uchar{50}));
  const auto source = folder.Open();
  EXPECT_EQ(source->frame_count(), 1);

  const DatasetFrame frame = source->Get(0);
  EXPECT_TRUE(EqualBytes(frame.left, SomePicture({40, 1110})));
  EXPECT_TRUE(EqualBytes(frame.right, SomePicture({40, 1110})));
  EXPECT_TRUE(std::isnan(frame.truth.left(0, 0)));
  EXPECT_EQ(frame.truth.left(2, 3), 60.0f);
  EXPECT_EQ(frame.truth.left(1109, 39), 40.0f);
  EXPECT_EQ(frame.truth.right(1109, 39), 50.0f);
}

struct ScaleCase {
  int rows;
  int configured;
  int scale;
};

void PrintTo(const ScaleCase& scale, std::ostream* out) {
  *out << scale.rows << " rows, " << scale.configured << " configured";
}

class MiddleburyScale : public testing::TestWithParam<ScaleCase> {};

TEST_P(MiddleburyScale, DividesCodesFocalLengthAndDmin) {
  const ScaleCase& c = GetParam();
  const SceneFolder folder(cv::Size(41, c.rows));
  folder.WriteText("dmin.txt", " 270\r\n");
  CaptureConfig config = folder.Config();
  config.set_gt_scale(c.configured);
  const auto source = OpenDataset(config);

  const RectifiedPair& pair = source->rig().pair;
  EXPECT_EQ(pair.size(), cv::Size(41, c.rows));
  EXPECT_DOUBLE_EQ(pair.focal_px, 3740.0 / c.scale);
  EXPECT_DOUBLE_EQ(pair.baseline_m, 0.160);
  EXPECT_DOUBLE_EQ(pair.cx, 20);
  EXPECT_DOUBLE_EQ(pair.cy, (c.rows - 1) / 2.0);
  EXPECT_NEAR(pair.cx_right - pair.cx, 270.0 / c.scale, 1e-12);
  const GroundTruth truth = source->Get(0).truth;
  EXPECT_FLOAT_EQ(truth.left(5, 5), 40.0f / static_cast<float>(c.scale));
  // The same point at every scale: Z = f·b / (d + dmin).
  EXPECT_NEAR(pair.DepthFromDisparity(truth.left(5, 5)), 3740 * 0.160 / (40 + 270), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Sizes, MiddleburyScale,
                         testing::Values(ScaleCase{1110, 0, 1}, ScaleCase{555, 0, 2},
                                         ScaleCase{370, 0, 3}, ScaleCase{4000, 0, 1},
                                         ScaleCase{1110, 2, 2}, ScaleCase{20, 3, 3}));

TEST(MiddleburyDataset, TakesAMissingDminForZeroAndAMissingDisp5ForUnknown) {
  const SceneFolder folder(cv::Size(40, 555));
  const auto source = folder.Open();
  EXPECT_EQ(source->rig().pair.cx_right, source->rig().pair.cx);
  EXPECT_TRUE(source->Get(0).truth.right.empty());
}

TEST(MiddleburyDataset, ReadsTheLayoutOf2014) {
  const SceneFolder folder(SceneFolder::k2014);
  folder.WritePfm("disp1.pfm", cv::Mat1f(20, 30, 4.125f), "-1");
  const auto source = folder.Open();

  const RectifiedPair& pair = source->rig().pair;
  EXPECT_EQ(pair.size(), cv::Size(30, 20));
  EXPECT_EQ(pair.focal_px, 100.5);
  EXPECT_EQ(pair.cx, 14.25);
  EXPECT_EQ(pair.cy, 9.5);
  EXPECT_EQ(pair.cx_right, 17.5);
  EXPECT_DOUBLE_EQ(pair.baseline_m, 0.1935);

  const DatasetFrame frame = source->Get(0);
  EXPECT_TRUE(EqualBytes(frame.left, SomePicture({30, 20})));
  EXPECT_TRUE(std::isnan(frame.truth.left(0, 0)));  // top left: rows are the right way round
  EXPECT_EQ(frame.truth.left(2, 3), 7.5f);
  EXPECT_EQ(frame.truth.left(19, 29), 5.25f);
  EXPECT_EQ(frame.truth.right(7, 7), 4.125f);
}

TEST(MiddleburyDataset, RefusesAScaleOfTheTruthWhereThatIsInPx) {
  const SceneFolder folder(SceneFolder::k2014);
  CaptureConfig config = folder.Config();
  config.set_gt_scale(2);
  EXPECT_THAT(OpenError(config),
              ::testing::MatchesRegex("capture.gt_scale = 2: of no use for .*, whose ground truth "
                                      "is in px; allowed: 0"));
}

TEST(MiddleburyDataset, ReadsPfmRowsInTheOrderOfOpenCv) {
  const SceneFolder folder(SceneFolder::k2014);
  const cv::Mat1f by_opencv = cv::imread(folder.File("disp0.pfm"), cv::IMREAD_UNCHANGED);
  const cv::Mat1f truth = folder.Open()->Get(0).truth.left;
  ASSERT_EQ(by_opencv.size(), truth.size());
  EXPECT_EQ(by_opencv(2, 3), truth(2, 3));
  EXPECT_EQ(by_opencv(17, 3), truth(17, 3));
}

TEST(MiddleburyDataset, TakesOnlyTheByteOrderFromThePfmScale) {
  for (const std::string scale : {"-0.003922", "-1.0", "1", "255"}) {
    const SceneFolder folder(SceneFolder::k2014);
    folder.WritePfm("disp0.pfm", cv::Mat1f(20, 30, 6.75f), scale);
    EXPECT_EQ(folder.Open()->Get(0).truth.left(3, 4), 6.75f) << scale;
  }
}

TEST(MiddleburyDataset, KeepsGreyImagesGreyAndDropsAlpha) {
  const SceneFolder folder(cv::Size(40, 30));
  folder.WriteImage("view1.png", cv::Mat1b(30, 40, uchar{77}));
  folder.WriteImage("view5.png", cv::Mat4b(30, 40, cv::Vec4b(1, 2, 3, 4)));
  const DatasetFrame frame = folder.Open()->Get(0);
  EXPECT_TRUE(EqualBytes(frame.left, cv::Mat1b(30, 40, uchar{77})));
  EXPECT_TRUE(EqualBytes(frame.right, cv::Mat3b(30, 40, cv::Vec3b(1, 2, 3))));
}

TEST(MiddleburyDataset, ReadsEveryImageExtension) {
  for (const std::string extension : {".png", ".jpg", ".ppm"}) {
    const SceneFolder folder;
    folder.WriteImage("view1" + extension, SomePicture({40, 30}));
    folder.WriteImage("view5" + extension, SomePicture({40, 30}));
    folder.WriteImage("disp1.png", cv::Mat1b(30, 40, uchar{40}));
    EXPECT_EQ(folder.Open()->Get(0).left.type(), CV_8UC3) << extension;
  }
  const SceneFolder folder;
  folder.WriteImage("view1.pgm", cv::Mat1b(30, 40, uchar{77}));
  folder.WriteImage("view5.pgm", cv::Mat1b(30, 40, uchar{78}));
  folder.WriteImage("disp1.png", cv::Mat1b(30, 40, uchar{40}));
  EXPECT_TRUE(EqualBytes(folder.Open()->Get(0).left, cv::Mat1b(30, 40, uchar{77})));
}

TEST(MiddleburyDataset, SimulatesTheTofCameraFromTheLeftTruth) {
  const SceneFolder folder(cv::Size(40, 1110));
  const auto source = folder.Open();
  const TofImage tof = source->Get(0).tof;
  EXPECT_EQ(tof.depth_m.size(), cv::Size(8, 222));
  EXPECT_EQ(source->rig().tof.width, 8);
  EXPECT_FLOAT_EQ(tof.depth_m(4, 4), 3740 * 0.160f / 40);
  EXPECT_TRUE(tof.amplitude.empty());
}

TEST(MiddleburyDataset, GivesTheSameFrameAfterTheFirstWasChanged) {
  const SceneFolder folder(cv::Size(40, 30));
  folder.WriteImage("disp5.png", cv::Mat1b(30, 40, uchar{50}));
  const auto source = folder.Open();
  DatasetFrame first = source->Get(0);
  DatasetFrame kept;
  kept.left = first.left.clone();
  kept.right = first.right.clone();
  kept.tof.depth_m = first.tof.depth_m.clone();
  kept.truth = {first.truth.left.clone(), first.truth.right.clone()};
  for (cv::Mat* image : {&first.left, &first.right}) image->setTo(0);
  for (cv::Mat1f* map : {&first.tof.depth_m, &first.truth.left, &first.truth.right}) map->setTo(1);

  const DatasetFrame second = source->Get(0);
  EXPECT_TRUE(EqualBytes(second.left, kept.left));
  EXPECT_TRUE(EqualBytes(second.right, kept.right));
  EXPECT_EQ(second.tof.depth_m(3, 3), kept.tof.depth_m(3, 3));
  EXPECT_EQ(second.truth.left(3, 3), kept.truth.left(3, 3));
  EXPECT_EQ(second.truth.right(3, 3), kept.truth.right(3, 3));
}

TEST(MiddleburyDataset, ShowsTheSceneToAnSr4000) {
  SceneFolder folder(cv::Size(96, 72));
  CaptureConfig config = folder.Config();
  config.set_source(config.source() + "?tof=sr4000");
  const auto source = OpenDataset(config);
  const TofImage tof = source->Get(0).tof;
  ASSERT_EQ(tof.depth_m.size(), cv::Size(176, 144));
  EXPECT_EQ(source->rig().tof.width, 176);
  EXPECT_EQ(tof.amplitude.size(), tof.depth_m.size());
  // Code 40 at 1110 / 72 = 15 codes a pixel.
  EXPECT_NEAR(tof.depth_m(72, 88), source->rig().pair.DepthFromDisparity(40 / 15.0), 0.05);
}

}  // namespace
}  // namespace sprout::scenes
