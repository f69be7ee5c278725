#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/messages/examples.h"

// Images that travel as JPEG streams.
namespace sprout {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string ErrorOf(image_t message) {
  message.size = static_cast<int32_t>(message.data.size());
  const Result<cv::Mat> image = FromMessage(message);
  return image ? "" : image.error().text;
}

// Where the frame header (SOF) of a baseline stream stands: FF C0, length, precision, then height
// and width.
size_t FindFrameHeader(const std::vector<uint8_t>& data) {
  for (size_t i = 0; i + 1 < data.size(); ++i) {
    if (data[i] == 0xff && data[i + 1] == 0xc0) return i;
  }
  ADD_FAILURE() << "no frame header";
  return 0;
}

TEST(JpegImageMessage, IsDecodedToBgr) {
  const Result<cv::Mat> image = FromMessage(examples::Jpeg());
  ASSERT_TRUE(image) << image.error().text;
  ASSERT_EQ(image->type(), CV_8UC3);
  ASSERT_EQ(image->size(), cv::Size(24, 16));
  const cv::Vec3b pixel = image->at<cv::Vec3b>(8, 12);
  EXPECT_NEAR(pixel[0], 20, 3);
  EXPECT_NEAR(pixel[1], 120, 3);
  EXPECT_NEAR(pixel[2], 220, 3);
}

TEST(JpegImageMessage, StaysGreyWhenTheStreamIs) {
  image_t message = examples::Jpeg();
  cv::imencode(".jpg", cv::Mat(16, 24, CV_8UC1, cv::Scalar(77)), message.data);
  message.size = static_cast<int32_t>(message.data.size());
  const Result<cv::Mat> image = FromMessage(message);
  ASSERT_TRUE(image) << image.error().text;
  ASSERT_EQ(image->type(), CV_8UC1);
  EXPECT_NEAR(image->at<uint8_t>(3, 3), 77, 2);
}

TEST(JpegImageMessage, MayBePaddedWithZeros) {  // as many cameras do
  image_t message = examples::Jpeg();
  message.data.resize(message.data.size() + 7, 0);
  EXPECT_EQ(ErrorOf(message), "");
}

TEST(JpegImageMessage, IsRefusedWhenItsSizeIsNotTheMessages) {
  image_t message = examples::Jpeg();
  message.width = 25;
  EXPECT_THAT(ErrorOf(message), HasSubstr("24x16"));
  EXPECT_THAT(ErrorOf(message), HasSubstr("25x16"));
}

TEST(JpegImageMessage, IsRefusedBeforeAHugePictureIsDecoded) {
  image_t message = examples::Jpeg();
  const size_t header = FindFrameHeader(message.data);
  // 0x7000 x 0x7000 px: more than 2 GB, if anything were to decode it.
  message.data[header + 5] = message.data[header + 7] = 0x70;
  message.data[header + 6] = message.data[header + 8] = 0x00;
  const auto started = std::chrono::steady_clock::now();
  EXPECT_THAT(ErrorOf(message), HasSubstr("28672x28672"));
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::milliseconds(100));
}

TEST(JpegImageMessage, IsRefusedWhenItIsNoJpegStream) {
  image_t message = examples::Jpeg();
  message.data = {};
  EXPECT_THAT(ErrorOf(message), StartsWith("data: "));
  message.data = {0xff};
  EXPECT_THAT(ErrorOf(message), StartsWith("data: "));
  message.data = std::vector<uint8_t>(500, 0x5a);
  EXPECT_THAT(ErrorOf(message), StartsWith("data: "));
  cv::imencode(".png", cv::Mat(16, 24, CV_8UC3, cv::Scalar(1, 2, 3)), message.data);
  EXPECT_THAT(ErrorOf(message), StartsWith("data: ")) << "a PNG is no JPEG";
}

TEST(JpegImageMessage, IsRefusedWhenItIsCutShort) {
  const image_t whole = examples::Jpeg();
  for (size_t size = 0; size < whole.data.size(); ++size) {
    image_t message = whole;
    message.data.resize(size);
    EXPECT_THAT(ErrorOf(message), StartsWith("data: ")) << size << " bytes";
  }
}

}  // namespace
}  // namespace sprout
