#include "services/capture/genicam/pixels.h"

#include <gmock/gmock.h>

#include <vector>

#include "common/config/required.h"

namespace sprout::capture {
namespace {

using testing::HasSubstr;

PayloadPart PartOf(PixelFormat format, int width, int height, const std::vector<uint8_t>& bytes) {
  return {.format = static_cast<uint32_t>(format),
          .width = width,
          .height = height,
          .row_padding = 0,
          .bytes = bytes,
          .content = PartContent::kUnknown};
}

TEST(Pixels, GreyIsCopied) {
  std::vector<uint8_t> bytes = {1, 2, 3, 4, 5, 6};
  const cv::Mat image = Required(ToImage(PartOf(PixelFormat::kMono8, 3, 2, bytes)));
  bytes.assign(6, 0);
  EXPECT_EQ(image.type(), CV_8UC1);
  EXPECT_EQ(image.at<uint8_t>(1, 2), 6);
}

TEST(Pixels, PaddingBehindRowsIsLeftOut) {
  const std::vector<uint8_t> bytes = {1, 2, 3, 99, 4, 5, 6};
  PayloadPart part = PartOf(PixelFormat::kMono8, 3, 2, bytes);
  part.row_padding = 1;
  const cv::Mat image = Required(ToImage(part));
  EXPECT_EQ(image.at<uint8_t>(1, 0), 4);
}

TEST(Pixels, ColoursBecomeBgr) {
  const std::vector<uint8_t> bytes = {200, 100, 50};
  EXPECT_EQ(ToImage(PartOf(PixelFormat::kRGB8, 1, 1, bytes))->at<cv::Vec3b>(0, 0),
            cv::Vec3b(50, 100, 200));
  EXPECT_EQ(ToImage(PartOf(PixelFormat::kBGR8, 1, 1, bytes))->at<cv::Vec3b>(0, 0),
            cv::Vec3b(200, 100, 50));
}

TEST(Pixels, BayerPatternsOfOneColourBecomeThatColour) {
  // What a camera with a filter of this order sees of blue 50, green 100, red 200.
  const struct {
    PixelFormat format;
    std::vector<uint8_t> order;  // first two of the first row, first two of the second
  } patterns[] = {{PixelFormat::kBayerRG8, {200, 100, 100, 50}},
                  {PixelFormat::kBayerGR8, {100, 200, 50, 100}},
                  {PixelFormat::kBayerGB8, {100, 50, 200, 100}},
                  {PixelFormat::kBayerBG8, {50, 100, 100, 200}}};
  for (const auto& [format, order] : patterns) {
    std::vector<uint8_t> bytes;
    for (size_t v = 0; v < 8; ++v) {
      for (size_t u = 0; u < 10; ++u) bytes.push_back(order[v % 2 * 2 + u % 2]);
    }
    const cv::Mat image = Required(ToImage(PartOf(format, 10, 8, bytes)));
    for (int v = 0; v < 8; ++v) {
      for (int u = 0; u < 10; ++u) {
        EXPECT_EQ(image.at<cv::Vec3b>(v, u), cv::Vec3b(50, 100, 200))
            << PixelFormatName(static_cast<uint32_t>(format)) << " " << u << "," << v;
      }
    }
  }
}

TEST(Pixels, SayWhatIsWrongWithAPayload) {
  const std::vector<uint8_t> bytes(12);
  const auto error = [&](const PayloadPart& part) { return ToImage(part).error().text; };
  EXPECT_EQ(error(PartOf(PixelFormat::kMono8, 4, 4, bytes)),
            "12 bytes for 4x4 pixels of Mono8; needed: 16");
  EXPECT_THAT(error(PartOf(PixelFormat::kMono8, 0, 4, bytes)), HasSubstr("0x4 pixels"));
  EXPECT_THAT(error(PartOf(PixelFormat::kMono8, -3, -4, bytes)), HasSubstr("-3x-4 pixels"));
  EXPECT_THAT(error(PartOf(PixelFormat::kMono8, 1 << 30, 1 << 30, bytes)), HasSubstr("pixels"));
  EXPECT_THAT(error(PartOf(PixelFormat::kCoord3dC16, 2, 2, bytes)),
              HasSubstr("Coord3D_C16 is not a stereo camera's; allowed: Mono8, BayerRG8"));
  EXPECT_THAT(error(PartOf(static_cast<PixelFormat>(0x010C0006), 2, 2, bytes)),
              HasSubstr("pixel format 0x010C0006 is not understood; allowed: Mono8"));
  PayloadPart padded = PartOf(PixelFormat::kMono8, 3, 2, bytes);
  padded.row_padding = SIZE_MAX;
  EXPECT_THAT(error(padded), HasSubstr("needed"));
}

TEST(Pixels, FormatsAreKnownByName) {
  EXPECT_EQ(PixelFormatNamed("BayerGB8"), PixelFormat::kBayerGB8);
  EXPECT_FALSE(PixelFormatNamed("Mono12"));
  EXPECT_TRUE(IsTofFormat(PixelFormat::kMono16));
  EXPECT_FALSE(IsStereoFormat(PixelFormat::kMono16));
  EXPECT_FALSE(IsTofFormat(PixelFormat::kConfidence16));
}

}  // namespace
}  // namespace sprout::capture
