#include "common/picture/picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/picture/text.h"
#include "tests/common/core/centred.h"

namespace sprout {
namespace {

int CountPixels(const cv::Mat3b& picture, const cv::Vec3b& color) {
  return static_cast<int>(std::count(picture.begin(), picture.end(), color));
}

TEST(DisparityPicture, PaintsEachPixelByItsDisparityAndGapsDark) {
  const ValueRange range{0, 64};
  DisparityImage disparity(cv::Size(300, 200));
  disparity.counts().colRange(0, 100) = ToCounts(20);
  disparity.counts().colRange(100, 150) = ToCounts(44);
  const cv::Mat3b picture = DisparityPicture(disparity, range, "Disparity");
  EXPECT_EQ(CountPixels(picture, kNoValueColor), 150 * 200);
  // The scale shows the same colours, so there may be more.
  EXPECT_GE(CountPixels(picture, ColorOf(20, range)), 100 * 200);
  EXPECT_GE(CountPixels(picture, ColorOf(44, range)), 50 * 200);
}

TEST(DisparityPicture, DrawsTheScaleOutsideTheImage) {
  const DisparityImage without_disparity(cv::Size(300, 200));
  const cv::Mat3b picture = DisparityPicture(without_disparity, {0, 64}, "Disparity");
  EXPECT_GT(picture.cols, 300);
  EXPECT_GT(picture.rows, 200);
  EXPECT_EQ(CountPixels(picture, kNoValueColor), 300 * 200);
  EXPECT_GT(CountPixels(picture, ColorOf(64, {0, 64})), 0);
}

TEST(DisparityPicture, GrowsItsMarginsWithTheImage) {
  const auto margin = [](cv::Size size) {
    return DisparityPicture(DisparityImage(size), {0, 64}, "Disparity").rows - size.height;
  };
  EXPECT_GT(margin({1300, 1110}), 2 * margin({300, 200}));
}

struct Arrows {
  int above, below, cols;
  friend std::ostream& operator<<(std::ostream& out, const Arrows& arrows) {
    return out << arrows.above << " above, " << arrows.below << " below, " << arrows.cols
               << " cols";
  }
  bool operator==(const Arrows&) const = default;
};

// An image of 300x200 px has letters of 9 px, so it begins 9 px from the left and 27 px from above;
// the bar follows 9 px behind it and is 13 px wide. An arrow at an end of it is 6 px high and has
// 13 + 11 + 9 + 7 + 5 + 3 pixels of the end's colour.
TEST(DisparityPicture, MarksWhatItsScaleDoesNotReach) {
  const ValueRange range{0, 64};
  const auto arrows_with = [&](double disparity_px) {
    DisparityImage disparity(cv::Size(300, 200));
    disparity.counts() = ToCounts(20);
    disparity.counts()(3, 3) = ToCounts(disparity_px);
    const cv::Mat3b picture = DisparityPicture(disparity, range, "");
    const cv::Range bar(9 + 300 + 9, 9 + 300 + 9 + 13);
    return Arrows{CountPixels(picture(cv::Range(0, 27), bar), ColorOf(64, range)),
                  CountPixels(picture(cv::Range(27 + 200, picture.rows), bar), ColorOf(0, range)),
                  picture.cols};
  };
  const int cols = arrows_with(64).cols;
  EXPECT_EQ(arrows_with(64), (Arrows{0, 0, cols}));
  const auto wider_than_64 = [](const std::string& text) {
    return TextWidth(text, 9) - TextWidth("64", 9);
  };
  EXPECT_EQ(arrows_with(64.25), (Arrows{48, 0, cols + wider_than_64(">64")}));
  EXPECT_EQ(arrows_with(-0.25), (Arrows{0, 48, cols + wider_than_64("<0")}));
}

TEST(DisparityPicture, HasDepthsBesideDisparitiesWithAPair) {
  const RectifiedPair pair = CentredPair(300, 200, 500);
  const DisparityImage disparity(cv::Size(300, 200));
  EXPECT_GT(DisparityPicture(disparity, {8, 64}, "", &pair).cols,
            DisparityPicture(disparity, {8, 64}, "").cols);
  // Beyond infinity there is no depth.
  EXPECT_EQ(DisparityPicture(disparity, {-8, 64}, "", &pair).cols,
            DisparityPicture(disparity, {-8, 64}, "").cols);
}

TEST(ConfidencePicture, HasAScaleFromBlackToWhite) {
  const cv::Mat1b confidence(200, 300, uchar{77});
  const cv::Mat3b picture = ConfidencePicture(confidence, "Confidence");
  EXPECT_GE(CountPixels(picture, {77, 77, 77}), 200 * 300);
  EXPECT_GT(picture.cols, CameraPicture(confidence, "Confidence").cols);
}

TEST(ErrorPicture, TellsUnscoredPixelsFromThoseWithoutADisparity) {
  cv::Mat1f error_px(200, 300, std::numeric_limits<float>::quiet_NaN());
  error_px.colRange(0, 100) = 1;
  error_px.colRange(100, 150) = std::numeric_limits<float>::infinity();
  const cv::Mat3b picture = ErrorPicture(error_px, "Error");
  EXPECT_EQ(CountPixels(picture, kNoValueColor), 150 * 200);
  EXPECT_GE(CountPixels(picture, ColorOf(1, {0, kLargestErrorPx})), 100 * 200);
  EXPECT_GE(CountPixels(picture, ColorOf(4, {0, kLargestErrorPx})), 50 * 200);
}

TEST(DisparityPicture, WorksOnASinglePixel) {
  EXPECT_FALSE(DisparityPicture(DisparityImage(cv::Size(1, 1)), {0, 1}, "Tiny").empty());
}

TEST(SigmaPicture, PaintsHowSureThePriorIsFrom0To4Px) {
  PriorMap prior(cv::Size(300, 200));
  prior.disparity.counts().colRange(0, 200) = ToCounts(20);
  prior.sigma.colRange(0, 100) = SigmaToCounts(1);
  prior.sigma.colRange(100, 200) = SigmaToCounts(9);
  const cv::Mat3b picture = SigmaPicture(prior, "Sigma");
  EXPECT_EQ(CountPixels(picture, kNoValueColor), 100 * 200);
  EXPECT_GE(CountPixels(picture, ColorOf(1, {0, 4})), 100 * 200);
  EXPECT_GE(CountPixels(picture, ColorOf(4, {0, 4})), 100 * 200);
}

TEST(DepthPicture, EnlargesEachPixelToASquareAndLeavesNoReturnDark) {
  TofImage tof;
  tof.depth_m = cv::Mat1f(144, 176, 2.F);
  tof.depth_m(7, 9) = std::numeric_limits<float>::quiet_NaN();
  tof.depth_m(100, 150) = 0;
  const cv::Mat3b picture = DepthPicture(tof, {1300, 1110}, {1, 3}, "ToF");
  EXPECT_EQ(CountPixels(picture, kNoValueColor), 2 * 8 * 8);  // 1300·1110 / (176·144) = 7.5²
  EXPECT_GE(CountPixels(picture, ColorOfDepth(2, {1, 3})), (144 * 176 - 2) * 8 * 8);
}

TEST(DepthPicture, ShowsNoReturnWhereDriversWriteAHugeNumber) {
  for (const float code : {1e20F, 65535.F, std::numeric_limits<float>::max()}) {
    const TofImage tof{.depth_m = cv::Mat1f(12, 16, code), .amplitude = {}};
    const cv::Mat3b picture = DepthPicture(tof, {160, 120}, DepthRange(tof), "ToF");
    EXPECT_EQ(CountPixels(picture, kNoValueColor), 160 * 120) << code;
  }
}

TEST(DepthPicture, HasNoReturnWithoutATofCamera) {
  const TofImage none;
  const cv::Mat3b picture = DepthPicture(none, {160, 120}, DepthRange(none), "ToF");
  EXPECT_EQ(CountPixels(picture, kNoValueColor), 160 * 120);
}

TEST(SeedPicture, DrawsEachSeedWhereItIsInTheColorOfItsDisparity) {
  const cv::Mat1b left(200, 300, uchar{200});
  const std::vector<Seed> seeds{{.u = 40, .v = 30, .u_right = 20},
                                {.u = 250, .v = 160, .u_right = 200}};
  const ValueRange range{0, 64};
  const cv::Mat3b without = SeedPicture(left, {}, range, "Seeds");
  const cv::Mat3b with = SeedPicture(left, seeds, range, "Seeds");
  cv::Mat3b difference;
  cv::absdiff(with, without, difference);
  std::vector<cv::Point> changed;
  for (int y = 0; y < with.rows; ++y) {
    for (int x = 0; x < with.cols; ++x) {
      if (difference(y, x) != cv::Vec3b()) changed.emplace_back(x, y);
    }
  }
  ASSERT_FALSE(changed.empty());
  const cv::Rect around = cv::boundingRect(changed);
  EXPECT_NEAR(around.width, 210, 8) << "distance of the dots and their size";
  EXPECT_NEAR(around.height, 130, 8);
  EXPECT_EQ(with(around.y + 3, around.x + 3), ColorOf(20, range));
  EXPECT_EQ(with(around.br().y - 4, around.br().x - 4), ColorOf(50, range));
}

TEST(SeedPicture, LeavesOutSeedsOutsideTheImage) {
  const cv::Mat1b left(200, 300, uchar{200});
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Seed> seeds{{.u = -10, .v = 5, .u_right = -20},
                                {.u = 1e30F, .v = 5, .u_right = 0},
                                {.u = kNan, .v = kNan, .u_right = 0}};
  const cv::Mat3b with = SeedPicture(left, seeds, {0, 64}, "Seeds");
  EXPECT_EQ(cv::norm(with, SeedPicture(left, {}, {0, 64}, "Seeds")), 0);
}

TEST(CameraPicture, ShowsTheImageUnchangedBelowItsTitle) {
  const cv::Mat3b image(200, 300, cv::Vec3b(10, 90, 170));
  const cv::Mat3b picture = CameraPicture(image, "Left");
  EXPECT_EQ(CountPixels(picture, {10, 90, 170}), 200 * 300);
  EXPECT_EQ(CountPixels(CameraPicture(cv::Mat1b(200, 300, uchar{3}), "Left"), {3, 3, 3}),
            200 * 300);
}

TEST(CameraPicture, MakesThePaperWiderForATitleThatWouldBecomeTooSmall) {
  const cv::Mat3b picture = CameraPicture(cv::Mat1b(20, 30, uchar{90}), "A title of some length");
  EXPECT_GT(picture.cols, 120);
  const cv::Mat3b right_margin = picture.colRange(picture.cols - 5, picture.cols);
  EXPECT_EQ(CountPixels(right_margin, {255, 255, 255}), right_margin.rows * right_margin.cols);
}

TEST(CameraPicture, WritesALongTitleSmallerInsteadOfCuttingIt) {
  const cv::Mat3b image(200, 300, cv::Vec3b(10, 90, 170));
  const cv::Mat3b picture = CameraPicture(image, std::string(70, 'm'));
  const cv::Mat3b right_margin = picture.colRange(picture.cols - 5, picture.cols);
  EXPECT_EQ(CountPixels(right_margin, {255, 255, 255}), right_margin.rows * right_margin.cols);
}

}  // namespace
}  // namespace sprout
