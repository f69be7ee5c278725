#include "common/messages/jpeg.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>

#include "common/config/required.h"
#include "tests/common/messages/examples.h"
#include "tests/common/testing/allocation_guard.h"
#include "tests/common/testing/thrown.h"

// Images that travel as JPEG streams.
namespace sprout {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string ErrorOf(image_t message) {
  message.size = static_cast<int32_t>(message.data.size());
  return WhyNot(FromMessage(message, message.data));
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
  const image_t message = examples::Jpeg();
  const cv::Mat image = Required(FromMessage(message, message.data));
  ASSERT_EQ(image.type(), CV_8UC3);
  ASSERT_EQ(image.size(), cv::Size(24, 16));
  const cv::Vec3b pixel = image.at<cv::Vec3b>(8, 12);
  EXPECT_NEAR(pixel[0], 20, 3);
  EXPECT_NEAR(pixel[1], 120, 3);
  EXPECT_NEAR(pixel[2], 220, 3);
}

TEST(JpegImageMessage, StaysGreyWhenTheStreamIs) {
  image_t message = examples::Jpeg();
  cv::imencode(".jpg", cv::Mat(16, 24, CV_8UC1, cv::Scalar(77)), message.data);
  message.size = static_cast<int32_t>(message.data.size());
  const cv::Mat image = Required(FromMessage(message, message.data));
  ASSERT_EQ(image.type(), CV_8UC1);
  EXPECT_NEAR(image.at<uint8_t>(3, 3), 77, 2);
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

// Gives the frame header another size, wherever it stands.
void SetSize(std::vector<uint8_t>& data, size_t header, int side) {
  for (const size_t at : {header + 5, header + 7}) {
    data[at] = static_cast<uint8_t>(side >> 8);
    data[at + 1] = static_cast<uint8_t>(side & 0xff);
  }
}

void ExpectRefusedAtOnce(const image_t& message, const char* error) {
  const AllocationGuard guard;
  const auto started = std::chrono::steady_clock::now();
  EXPECT_THAT(ErrorOf(message), HasSubstr(error));
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::milliseconds(100));
  EXPECT_LT(guard.largest(), 4096U) << "no picture was allocated";
}

TEST(JpegImageMessage, IsRefusedBeforeAHugePictureIsDecoded) {
  image_t message = examples::Jpeg();
  SetSize(message.data, FindFrameHeader(message.data), 0x7000);
  ExpectRefusedAtOnce(message, "28672x28672");
}

TEST(JpegImageMessage, IsRefusedWhenTheFramesImagesHaveAnotherSize) {
  const auto bytes = examples::Encode(examples::Jpeg());
  EXPECT_TRUE(DecodePart(Part::kLeft, bytes, cv::Size(24, 16)));
  EXPECT_THAT(WhyNot(DecodePart(Part::kLeft, bytes, cv::Size(16, 24))),
              HasSubstr("size of the frame's images, 16x24"));
}

TEST(JpegImageMessage, IsRefusedWhenItsBytesCannotHoldThePicture) {
  image_t message = examples::Jpeg();
  message.width = message.height = 8192;
  SetSize(message.data, FindFrameHeader(message.data), 8192);
  ExpectRefusedAtOnce(message, "allowed is at least one for 512 pixels");
}

TEST(JpegImageMessage, IsMeasuredByTheHeaderThatLibjpegReads) {
  image_t message = examples::Jpeg();
  const size_t header = FindFrameHeader(message.data);
  const std::vector<uint8_t> honest(
      message.data.begin() + static_cast<std::ptrdiff_t>(header),
      message.data.begin() + static_cast<std::ptrdiff_t>(header) + 19);
  SetSize(message.data, header, 32000);
  // TEM and RST0 have no length. Who reads one behind them lands in the middle of an APP0 segment,
  // and takes what stands there for the frame header.
  for (const uint8_t marker : {uint8_t{0x01}, uint8_t{0xd0}}) {
    image_t fake = message;
    std::vector<uint8_t> inserted = {0xff, marker, 0x00, 0x06, 0xff, 0xe0, 0x00, 2 + 19};
    inserted.insert(inserted.end(), honest.begin(), honest.end());
    fake.data.insert(fake.data.begin() + 2, inserted.begin(), inserted.end());
    ExpectRefusedAtOnce(fake, "data: ");
  }
}

TEST(JpegImageMessage, IsRefusedWithMoreScansThanAnyCameraSends) {
  image_t message = examples::Jpeg();
  cv::imencode(".jpg", cv::Mat(16, 24, CV_8UC1, cv::Scalar(77)), message.data,
               {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  EXPECT_EQ(ErrorOf(message), "") << "a progressive stream is none the worse for it";
  const uint8_t start_of_scan[] = {0xff, 0xda};
  const auto scan =
      std::find_end(message.data.begin(), message.data.end(), start_of_scan, start_of_scan + 2);
  const std::vector<uint8_t> last(scan, message.data.end() - 2);
  for (int i = 0; i < 100; ++i) {
    message.data.insert(message.data.end() - 2, last.begin(), last.end());
  }
  ExpectRefusedAtOnce(message, "scans: allowed are up to 32");
}

TEST(JpegImageMessage, IsRefusedWhenAByteIsMissingInsideAndNothingIsPrinted) {
  image_t message = examples::Jpeg();
  message.data.erase(message.data.end() - 4);
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(ErrorOf(message), StartsWith("data: not a whole JPEG stream ("));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "not past the log";
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

// libjpeg wants room for a picture that is nothing but noise.
TEST(WriteJpeg, HoldsNoMoreMemoryThanItsStream) {
  const cv::Mat even(600, 800, CV_8UC3, cv::Scalar(1, 2, 3));
  const std::string stream = WriteJpeg(even, JpegColors::kFull);
  EXPECT_GT(stream.size(), 1000U);
  EXPECT_LT(stream.capacity(), stream.size() + 64);
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
