#include "common/measure/frame_quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace sprout {
namespace {

constexpr int kDisparity = 9;  // px, of the scene's plane

cv::Mat1b Texture(cv::Size size) {
  cv::Mat1b texture(size);
  cv::RNG random(7);
  for (uchar& grey : texture) grey = static_cast<uchar>(random.uniform(60, 160));
  return texture;
}

// A frame of a plane in front of the cameras, all of it true.
Frame TrueFrame() {
  const cv::Mat1b texture = Texture({200, 60});
  Frame frame;
  // left(u) = right(u − d), both cut out of one texture
  frame.left = texture.colRange(0, 160).clone();
  frame.right = texture.colRange(kDisparity, 160 + kDisparity).clone();
  frame.disparity = DisparityImage(cv::Mat1s(60, 160, static_cast<int16_t>(kDisparity * 32)));
  frame.confidence = cv::Mat1b(60, 160, uchar{255});
  SeedSet seeds;
  for (int v = 0; v < 60; v += 4) {
    for (int u = 0; u < 160; u += 4) {
      seeds.seeds.push_back({.u = static_cast<float>(u),
                             .v = static_cast<float>(v),
                             .u_right = static_cast<float>(u - kDisparity)});
    }
  }
  seeds.raw = static_cast<int32_t>(std::ssize(seeds.seeds));
  frame.seeds = seeds;
  return frame;
}

cv::Mat1b WithGain(const cv::Mat1b& image, double gain, double offset) {
  cv::Mat1b changed;
  image.convertTo(changed, CV_8U, gain, offset);
  return changed;
}

void Shift(DisparityImage& disparity, double px) {
  disparity.counts() += static_cast<int16_t>(px * DisparityImage::kCountsPerPixel);
}

TEST(FrameQuality, OfATrueFrameIsTheBest) {
  const FrameQuality quality = QualityOf(TrueFrame());
  EXPECT_DOUBLE_EQ(quality.valid_share.value(), 1);
  EXPECT_DOUBLE_EQ(quality.confidence.value(), 1);
  EXPECT_DOUBLE_EQ(quality.misfit.value(), 0);
  EXPECT_EQ(quality.seeds, 15 * 40);
  EXPECT_DOUBLE_EQ(quality.seeds_kept.value(), 1);
  EXPECT_DOUBLE_EQ(quality.tof_coverage.value(), 1);
  EXPECT_DOUBLE_EQ(quality.score().value(), 1);
}

TEST(FrameQuality, SampledMisfitIsNearThatOfAllRows) {
  // 480 rows, of which every third band of 40 is off by 3 px.
  const cv::Mat1b texture = Texture({200, 480});
  Frame frame;
  frame.left = texture.colRange(0, 160);
  frame.right = texture.colRange(kDisparity, 160 + kDisparity);
  frame.disparity = DisparityImage(cv::Mat1s(480, 160, static_cast<int16_t>(kDisparity * 32)));
  for (int v = 0; v < 480; v += 120) {
    DisparityImage wrong(cv::Mat1s(frame.disparity->counts().rowRange(v, v + 40)));
    Shift(wrong, 3);
  }
  const double all = QualityOf(frame).misfit.value();
  EXPECT_GT(all, 0.1);
  EXPECT_NEAR(QualityOf(frame, 4).misfit.value(), all, 0.1 * all);
  EXPECT_NE(QualityOf(frame, 4).misfit.value(), all);
}

TEST(FrameQuality, IsWorseTheMoreOfTheMapIsWrong) {
  double before = 1;
  for (const int wrong_columns : {40, 80, 120}) {
    Frame frame = TrueFrame();
    DisparityImage wrong(cv::Mat1s(frame.disparity->counts().colRange(20, 20 + wrong_columns)));
    Shift(wrong, 3);
    const double score = QualityOf(frame).score().value();
    EXPECT_LT(score, before - 0.05) << wrong_columns << " columns off by 3 px";
    before = score;
  }
}

TEST(FrameQuality, MultipliesWhatIsValidTrustedAndFits) {
  Frame frame = TrueFrame();
  frame.disparity->counts().rowRange(0, 15) = DisparityImage::kInvalid;
  frame.confidence.rowRange(0, 15) = 0;     // does not count, nothing is there
  frame.confidence.rowRange(15, 60) = 204;  // 0.8
  const FrameQuality quality = QualityOf(frame);
  EXPECT_DOUBLE_EQ(quality.valid_share.value(), 0.75);
  EXPECT_DOUBLE_EQ(quality.confidence.value(), 0.8);
  EXPECT_DOUBLE_EQ(quality.misfit.value(), 0);
  EXPECT_DOUBLE_EQ(quality.score().value(), 0.6);
  frame.left = Texture({160, 60});
  cv::flip(frame.left, frame.left, 1);
  const FrameQuality unrelated = QualityOf(frame);
  EXPECT_NEAR(unrelated.misfit.value(), 0.5, 0.05);
  EXPECT_DOUBLE_EQ(unrelated.score().value(), 0.6 * (1 - *unrelated.misfit));
}

TEST(FrameQuality, KnowsNothingOfPartsThatAreMissing) {
  const FrameQuality none = QualityOf(Frame());
  for (const QualityColumn& column : QualityColumns()) {
    EXPECT_FALSE(column.value(none)) << column.name;
    EXPECT_EQ(QualityText(column, none), "-") << column.name;
  }
  Frame frame = TrueFrame();
  frame.right.release();
  frame.confidence.release();
  frame.seeds->raw = 0;
  const FrameQuality quality = QualityOf(frame);
  EXPECT_FALSE(quality.misfit);
  EXPECT_FALSE(quality.confidence);
  EXPECT_FALSE(quality.seeds_kept);
  EXPECT_DOUBLE_EQ(quality.score().value(), 1) << "of what is known";
  frame.disparity.reset();
  EXPECT_FALSE(QualityOf(frame).score());
}

TEST(FrameQuality, TakesPartsOfOtherSizesForMissing) {
  Frame frame = TrueFrame();
  frame.right = frame.right.colRange(0, 150).clone();
  frame.confidence = frame.confidence.rowRange(0, 50).clone();
  const FrameQuality quality = QualityOf(frame);
  EXPECT_FALSE(quality.misfit);
  EXPECT_FALSE(quality.confidence);
  EXPECT_TRUE(quality.valid_share);
}

TEST(FrameQuality, OfAnEmptyMapIsTheWorst) {
  Frame frame = TrueFrame();
  frame.disparity = DisparityImage(cv::Size(160, 60));
  const FrameQuality quality = QualityOf(frame);
  EXPECT_DOUBLE_EQ(quality.valid_share.value(), 0);
  EXPECT_FALSE(quality.misfit) << "nothing to compare";
  EXPECT_FALSE(quality.confidence);
  EXPECT_DOUBLE_EQ(quality.score().value(), 0);
}

TEST(FrameQuality, CountsSeedsByWhereTheyComeFrom) {
  Frame frame = TrueFrame();
  std::vector<Seed>& seeds = frame.seeds->seeds;
  for (size_t i = 0; i < seeds.size() / 2; ++i) seeds[i].origin = SeedOrigin::kStereo;
  const FrameQuality quality = QualityOf(frame);
  EXPECT_EQ(quality.seeds, 600);
  EXPECT_DOUBLE_EQ(quality.seeds_kept.value(), 0.5);
  EXPECT_LT(quality.tof_coverage.value(), 0.7);
}

TEST(Misfit, DoesNotSeeGainAndOffset) {
  const Frame frame = TrueFrame();
  const double misfit =
      Misfit(frame.left, WithGain(frame.right, 0.5, 40), *frame.disparity).value();
  EXPECT_LT(misfit, 0.002) << "of rounding to whole grey levels";
}

TEST(Misfit, IsHalfOfUnrelatedAndOneOfInvertedImages) {
  const Frame frame = TrueFrame();
  DisparityImage wrong(frame.disparity->counts().clone());
  Shift(wrong, 20);
  EXPECT_NEAR(Misfit(frame.left, frame.right, wrong).value(), 0.5, 0.05);
  EXPECT_NEAR(Misfit(frame.left, WithGain(frame.right, -1, 255), *frame.disparity).value(), 1,
              0.02);
}

TEST(Misfit, DoesNotCountTheNoiseOfPlainSurfaces) {
  cv::Mat1b left(40, 80);
  cv::Mat1b right(40, 80);
  cv::RNG random(3);
  for (uchar& grey : left) grey = static_cast<uchar>(random.uniform(127, 130));
  for (uchar& grey : right) grey = static_cast<uchar>(random.uniform(127, 130));
  EXPECT_LT(Misfit(left, right, DisparityImage(cv::Mat1s(40, 80, int16_t{0}))).value(), 0.1);
}

TEST(Misfit, FindsMatchesBetweenPixels) {
  // A ramp of grey values in waves, moved by half a pixel.
  cv::Mat1b left(30, 120);
  cv::Mat1b right(30, 120);
  for (int v = 0; v < left.rows; ++v) {
    for (int u = 0; u < left.cols; ++u) {
      left(v, u) = cv::saturate_cast<uchar>(128 + 80 * std::sin(0.5 * u));
      right(v, u) = cv::saturate_cast<uchar>(128 + 80 * std::sin(0.5 * (u + 2.5)));
    }
  }
  const auto misfit = [&](double px) {
    return Misfit(left, right, DisparityImage(cv::Mat1s(30, 120, ToCounts(px)))).value();
  };
  EXPECT_LT(misfit(2.5), 0.001);
  EXPECT_GT(misfit(2.0), 10 * misfit(2.5));
  EXPECT_GT(misfit(3.0), 10 * misfit(2.5));
}

TEST(Misfit, LeavesOutWhatLiesBesideTheRightImage) {
  const Frame frame = TrueFrame();
  DisparityImage beside(cv::Mat1s(60, 160, static_cast<int16_t>(200 * 32)));
  EXPECT_FALSE(Misfit(frame.left, frame.right, beside));
}

TEST(QualityColumns, HaveDifferentNamesAndAreFound) {
  std::set<std::string_view> names;
  for (const QualityColumn& column : QualityColumns()) {
    EXPECT_TRUE(names.insert(column.name).second) << column.name;
    EXPECT_EQ(FindQualityColumn(column.name), &column);
  }
  EXPECT_EQ(QualityColumns().front().name, "score");
  EXPECT_EQ(FindQualityColumn("beauty"), nullptr);
}

TEST(QualityColumns, ShowFiguresForPeople) {
  FrameQuality quality;
  quality.valid_share = 0.98765;
  quality.seeds = 1234;
  EXPECT_EQ(QualityText(*FindQualityColumn("valid_share"), quality), "0.988");
  EXPECT_EQ(QualityText(*FindQualityColumn("seeds"), quality), "1234");
  EXPECT_EQ(QualityText(*FindQualityColumn("misfit"), quality), "-");
}

}  // namespace
}  // namespace sprout
