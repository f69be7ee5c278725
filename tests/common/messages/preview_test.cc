#include "common/messages/preview.h"

#include <gtest/gtest.h>

#include <lcmtypes/bot_core/image_t.hpp>
#include <lcmtypes/bot_core/planar_lidar_t.hpp>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout {
namespace {

cv::Mat3b TwoColours() {
  cv::Mat3b picture(48, 80, cv::Vec3b(200, 30, 40));
  picture(cv::Rect(40, 0, 40, 48)) = cv::Vec3b(20, 40, 220);
  return picture;
}

void ExpectNear(const cv::Vec3b& a, const cv::Vec3b& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 4) << "channel " << i;
}

TEST(PreviewMessage, IsAJpegThatOthersDecode) {
  const std::vector<uint8_t> bytes =
      EncodePreview({.utime = 12345, .seq = 7, .rig_id = ""}, TwoColours());
  bot_core::image_t message;
  ASSERT_EQ(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  EXPECT_EQ(message.utime, 12345);
  EXPECT_EQ(cv::Size(message.width, message.height), cv::Size(80, 48));
  EXPECT_EQ(message.pixelformat, bot_core::image_t::PIXEL_FORMAT_MJPEG);
  EXPECT_EQ(message.nmetadata, 0);
  const cv::Mat3b picture = cv::imdecode(message.data, cv::IMREAD_COLOR);
  ASSERT_EQ(picture.size(), cv::Size(80, 48));
  ExpectNear(picture(24, 20), {200, 30, 40});
  ExpectNear(picture(24, 60), {20, 40, 220});
}

TEST(PreviewMessage, OfTheSamePictureHasTheSameBytes) {
  EXPECT_EQ(EncodePreview({.utime = 1, .seq = 0, .rig_id = ""}, TwoColours()),
            EncodePreview({.utime = 1, .seq = 0, .rig_id = ""}, TwoColours()));
}

TEST(PreviewMessage, IsKnownByItsFingerprint) {
  EXPECT_TRUE(IsPreview(EncodePreview({}, TwoColours())));
  EXPECT_FALSE(IsPreview(
      EncodePart({.utime = 1, .seq = 0, .rig_id = ""}, Part::kLeft, cv::Mat(TwoColours()))));
  EXPECT_FALSE(IsPreview({}));
  EXPECT_EQ(TypeOf(EncodePreview({}, TwoColours())), std::nullopt) << "it carries no part";
}

const PlanarScan kScan{
    .ranges_m = {1.5F, std::numeric_limits<float>::infinity(), 2}, .first = -2, .step_rad = 0.25};

TEST(ScanMessage, IsOneThatOthersDecode) {
  const std::vector<uint8_t> bytes = EncodeScan({.utime = 12345, .seq = 7, .rig_id = "r"}, kScan);
  bot_core::planar_lidar_t message;
  ASSERT_EQ(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  EXPECT_EQ(message.utime, 12345);
  EXPECT_EQ(message.nranges, 3);
  EXPECT_EQ(message.ranges, kScan.ranges_m);
  EXPECT_EQ(message.nintensities, 0);
  EXPECT_EQ(message.rad0, -0.5F);
  EXPECT_EQ(message.radstep, 0.25F);
}

TEST(ScanMessage, IsKnownByItsFingerprint) {
  const std::vector<uint8_t> bytes = EncodeScan({}, kScan);
  EXPECT_TRUE(IsScan(bytes));
  EXPECT_FALSE(IsScan({}));
  EXPECT_EQ(TypeOf(bytes), std::nullopt) << "it carries no part";
}

}  // namespace

}  // namespace sprout
