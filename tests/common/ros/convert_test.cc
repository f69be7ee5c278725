#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "common/messages/jpeg.h"
#include "common/ros/from_ros.h"
#include "tests/common/ros/ros_examples.h"

namespace sprout {
namespace {

using examples::ErrorOf;
using examples::Place;
using testing::HasSubstr;

RosMessage<RosImage> Image(std::string_view encoding, cv::Size size, uint32_t step,
                           const std::vector<uint8_t>& bytes) {
  RosMessage<RosImage> message;
  SetRosText(message->encoding, encoding);
  message->width = static_cast<uint32_t>(size.width);
  message->height = static_cast<uint32_t>(size.height);
  message->step = step;
  std::ranges::copy(bytes, ResizeRos(message->data, bytes.size()).begin());
  return message;
}

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(FromRos, ImagesComeBack) {
  for (const cv::Mat& image : {examples::GreyImage(), examples::BgrImage()}) {
    const Result<cv::Mat> back = FromRosImage(*ToRosImage(Place(), image));
    ASSERT_TRUE(back) << ErrorOf(back);
    EXPECT_TRUE(SamePixels(*back, image));
  }
}

TEST(FromRos, RowsMayBeLongerThanTheirPixels) {
  const auto message = Image("mono8", {2, 2}, 3, {1, 2, 99, 3, 4, 99});
  const Result<cv::Mat> image = FromRosImage(*message);
  ASSERT_TRUE(image) << ErrorOf(image);
  EXPECT_TRUE(SamePixels(*image, (cv::Mat1b(2, 2) << 1, 2, 3, 4)));
}

TEST(FromRos, TurnsColoursAndDepthsOfPixels) {
  EXPECT_EQ((*FromRosImage(*Image("rgb8", {1, 1}, 3, {10, 20, 30}))).at<cv::Vec3b>(0, 0),
            cv::Vec3b(30, 20, 10));
  // 256·200 + 255 in little, 256·3 in big endian.
  EXPECT_EQ((*FromRosImage(*Image("mono16", {1, 1}, 2, {255, 200}))).at<uint16_t>(0, 0),
            256 * 200 + 255);
  auto big = Image("mono16", {1, 1}, 2, {3, 0});
  big->is_bigendian = 1;
  EXPECT_EQ((*FromRosImage(*big)).at<uint16_t>(0, 0), 256 * 3);
}

TEST(FromRos, TurnsTheEncodingsOfStereoDrivers) {
  EXPECT_EQ((*FromRosImage(*Image("bgra8", {1, 1}, 4, {10, 20, 30, 255}))).at<cv::Vec3b>(0, 0),
            cv::Vec3b(10, 20, 30));
  EXPECT_EQ((*FromRosImage(*Image("rgba8", {1, 1}, 4, {10, 20, 30, 255}))).at<cv::Vec3b>(0, 0),
            cv::Vec3b(30, 20, 10));
  // Without colour U = V = 128; of the rest ITU-R BT.601 makes 1.164 (Y − 16).
  for (const char* name : {"yuv422", "uyvy"}) {
    const Result<cv::Mat> image = FromRosImage(*Image(name, {2, 1}, 4, {128, 16, 128, 235}));
    ASSERT_TRUE(image) << ErrorOf(image);
    EXPECT_EQ(image->at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0)) << name;
    EXPECT_NEAR(image->at<cv::Vec3b>(0, 1)[0], 255, 1) << name;
  }
  for (const char* name : {"yuv422_yuy2", "yuyv"}) {
    // Red: U = 90, V = 240.
    const Result<cv::Mat> image = FromRosImage(*Image(name, {2, 1}, 4, {82, 90, 82, 240}));
    ASSERT_TRUE(image) << ErrorOf(image);
    const auto pixel = image->at<cv::Vec3b>(0, 1);
    EXPECT_LT(pixel[0], 3) << name;
    EXPECT_LT(pixel[1], 3) << name;
    EXPECT_GT(pixel[2], 250) << name;
  }
}

TEST(FromRos, OfPicturesWithColoursBelowThemTheGreyIsTaken) {
  const Result<cv::Mat> image = FromRosImage(*Image("nv12", {2, 2}, 2, {1, 2, 3, 4, 128, 90}));
  ASSERT_TRUE(image) << ErrorOf(image);
  EXPECT_TRUE(SamePixels(*image, (cv::Mat1b(2, 2) << 1, 2, 3, 4)));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("nv12", {2, 2}, 2, {1, 2, 3}))),
              HasSubstr("data length = 3: allowed is step × height"));
}

TEST(FromRos, BayerPatternsBeginWithTheirFirstPixels) {
  // A red scene: only the red pixels of the pattern are bright.
  for (const auto& [name, red_u, red_v] :
       {std::tuple("bayer_rggb8", 0, 0), std::tuple("bayer_bggr8", 1, 1),
        std::tuple("bayer_grbg8", 1, 0), std::tuple("bayer_gbrg8", 0, 1)}) {
    std::vector<uint8_t> bytes(64);
    for (int v = red_v; v < 8; v += 2) {
      for (int u = red_u; u < 8; u += 2) bytes[static_cast<size_t>(8 * v + u)] = 200;
    }
    const Result<cv::Mat> image = FromRosImage(*Image(name, {8, 8}, 8, bytes));
    ASSERT_TRUE(image) << ErrorOf(image);
    EXPECT_EQ(image->at<cv::Vec3b>(4, 4), cv::Vec3b(0, 0, 200)) << name;
  }
}

TEST(FromRos, PicturesOf16BitsKeepThem) {
  // Red 1000 of a red scene, low byte first.
  std::vector<uint8_t> bytes(128, 0);
  for (size_t v = 0; v < 8; v += 2) {
    for (size_t u = 0; u < 8; u += 2) {
      bytes[2 * (8 * v + u)] = 1000 % 256;
      bytes[2 * (8 * v + u) + 1] = 1000 / 256;
    }
  }
  const Result<cv::Mat> mosaic = FromRosImage(*Image("bayer_rggb16", {8, 8}, 16, bytes));
  ASSERT_TRUE(mosaic) << ErrorOf(mosaic);
  EXPECT_EQ(mosaic->type(), CV_16UC3);
  EXPECT_EQ(mosaic->at<cv::Vec3w>(4, 4), cv::Vec3w(0, 0, 1000));
  const Result<cv::Mat> red = FromRosImage(*Image("rgb16", {1, 1}, 6, {232, 3, 0, 0, 1, 0}));
  ASSERT_TRUE(red) << ErrorOf(red);
  EXPECT_EQ(red->at<cv::Vec3w>(0, 0), cv::Vec3w(1, 0, 1000));
  const Result<cv::Mat> thermal = FromRosImage(*Image("16UC1", {8, 8}, 16, bytes));
  ASSERT_TRUE(thermal) << ErrorOf(thermal);
  EXPECT_EQ(thermal->at<uint16_t>(4, 4), 1000);
}

TEST(FromRos, RefusesImagesThatCannotBe) {
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("rgba16", {1, 1}, 2, {1, 2}))),
              HasSubstr("encoding = 'rgba16': allowed is mono8, "));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("yuv422", {1, 1}, 2, {1, 2}))),
              HasSubstr("width = 1: allowed with yuv422 are even ones"));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("mono8", {4, 1}, 3, {1, 2, 3}))),
              HasSubstr("step = 3: allowed is at least 4"));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("mono8", {4, 2}, 4, {1, 2, 3, 4}))),
              HasSubstr("data length = 4: allowed is step × height"));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("mono8", {300, 1}, 900, std::vector<uint8_t>(900, 7)))),
              HasSubstr("step = 900: allowed is 300, or little more: are there more channels"));
  EXPECT_TRUE(FromRosImage(*Image("mono8", {300, 1}, 600, std::vector<uint8_t>(600, 7))));
  auto huge = Image("mono8", {4, 1}, 4, {1, 2, 3, 4});
  huge->width = 0xffffffff;
  EXPECT_THAT(ErrorOf(FromRosImage(*huge)), HasSubstr("width = 2147483647: allowed is 1 to 16384"));
}

TEST(FromRos, DepthIsInMetres) {
  const auto millimetres = Image("16UC1", {3, 1}, 6, {0xdc, 5, 0, 0, 255, 255});
  const Result<cv::Mat1f> depth = FromRosDepth(*millimetres);
  ASSERT_TRUE(depth) << ErrorOf(depth);
  EXPECT_FLOAT_EQ((*depth)(0, 0), 1.5F);
  EXPECT_FALSE(IsReturn((*depth)(0, 1)));
  EXPECT_FALSE(IsReturn((*depth)(0, 2)));
  const cv::Mat1f metres = (cv::Mat1f(1, 2) << NAN, 2.25F);
  const Result<cv::Mat1f> same = FromRosDepth(*ToRosImage(Place(), metres));
  ASSERT_TRUE(same) << ErrorOf(same);
  EXPECT_TRUE(std::isnan((*same)(0, 0)));
  EXPECT_EQ((*same)(0, 1), 2.25F);
}

TEST(FromRos, JpegMustHaveTheSizeThatIsExpected) {
  const std::string jpeg = WriteJpeg(cv::Mat1b(8, 16, uint8_t{77}), JpegColors::kFull);
  RosMessage<RosCompressedImage> message;
  SetRosText(message->format, "jpeg");
  std::ranges::copy(jpeg, ResizeRos(message->data, jpeg.size()).begin());
  const Result<cv::Mat> image = FromRosImage(*message, cv::Size(16, 8));
  ASSERT_TRUE(image) << ErrorOf(image);
  EXPECT_NEAR(image->at<uint8_t>(3, 3), 77, 1);
  EXPECT_THAT(ErrorOf(FromRosImage(*message, cv::Size(8, 8))),
              HasSubstr("allowed is width x height = 8x8"));
}

RosMessage<RosCompressedImage> CompressedMessage(const std::string& format,
                                                 const std::vector<uint8_t>& data) {
  RosMessage<RosCompressedImage> message;
  SetRosText(message->format, format);
  std::ranges::copy(data, ResizeRos(message->data, data.size()).begin());
  return message;
}

std::vector<uint8_t> PngOf(const cv::Mat& image) {
  std::vector<uint8_t> png;
  cv::imencode(".png", image, png);
  return png;
}

TEST(FromRos, CompressedImagesAreKnownByTheirBytes) {
  const std::string jpeg = WriteJpeg(cv::Mat1b(8, 16, uint8_t{77}), JpegColors::kFull);
  const std::vector<uint8_t> jpeg_bytes(jpeg.begin(), jpeg.end());
  const cv::Mat bgr(8, 16, CV_8UC3, cv::Scalar(1, 2, 3));
  for (const char* format : {"", "JPEG", "jpg", "bgr8; jpeg compressed bgr8", "png"}) {
    const Result<cv::Mat> grey = FromRosImage(*CompressedMessage(format, jpeg_bytes), {});
    ASSERT_TRUE(grey) << format << ErrorOf(grey);
    EXPECT_NEAR(grey->at<uint8_t>(3, 3), 77, 1) << format;
    const Result<cv::Mat> png =
        FromRosImage(*CompressedMessage(format, PngOf(bgr)), cv::Size(16, 8));
    ASSERT_TRUE(png) << format << ErrorOf(png);
    EXPECT_TRUE(SamePixels(*png, bgr)) << format;
  }
  // Grey, with 16 bits, with transparency, a mosaic.
  const cv::Mat1b grey(8, 16, uint8_t{9});
  EXPECT_TRUE(SamePixels(*FromRosImage(*CompressedMessage("", PngOf(grey)), {}), grey));
  const cv::Mat1w deep(8, 16, uint16_t{9 * 256 + 200});
  EXPECT_TRUE(SamePixels(*FromRosImage(*CompressedMessage("", PngOf(deep)), {}), deep));
  const cv::Mat bgra(8, 16, CV_8UC4, cv::Scalar(1, 2, 3, 255));
  EXPECT_TRUE(SamePixels(*FromRosImage(*CompressedMessage("", PngOf(bgra)), {}), bgr));
  cv::Mat1b red(8, 16, uint8_t{0});
  for (int v = 0; v < 8; v += 2) {
    for (int u = 0; u < 16; u += 2) red(v, u) = 200;
  }
  const Result<cv::Mat> colours =
      FromRosImage(*CompressedMessage("bayer_rggb8; png compressed ", PngOf(red)), {});
  ASSERT_TRUE(colours) << ErrorOf(colours);
  EXPECT_EQ(colours->at<cv::Vec3b>(4, 4), cv::Vec3b(0, 0, 200));
}

TEST(FromRos, RefusesCompressedImagesThatCannotBe) {
  EXPECT_THAT(ErrorOf(FromRosImage(*CompressedMessage("h264", {0, 0, 0, 1}), {})),
              HasSubstr("format = 'h264': its data is none that can be read; allowed is JPEG or"));
  std::vector<uint8_t> png = PngOf(cv::Mat1b(8, 16, uint8_t{9}));
  EXPECT_THAT(ErrorOf(FromRosImage(*CompressedMessage("png", png), cv::Size(8, 8))),
              HasSubstr("PNG of 16x8, allowed is width x height = 8x8"));
  png[17] = 1;  // 65536 px wide and more
  EXPECT_THAT(ErrorOf(FromRosImage(*CompressedMessage("png", png), {})),
              HasSubstr("allowed is up to 16384 px a side"));
  png = PngOf(cv::Mat1b(8, 16, uint8_t{9}));
  png.resize(30);
  EXPECT_THAT(ErrorOf(FromRosImage(*CompressedMessage("png", png), {})),
              HasSubstr("not a whole PNG stream"));
}

// image_transport's: an enumeration and two floats, then a PNG.
std::vector<uint8_t> CompressedDepth(const cv::Mat1w& values, float a, float b) {
  std::vector<uint8_t> bytes(4);
  for (const float parameter : {a, b}) {
    const auto four = std::bit_cast<std::array<uint8_t, 4>>(parameter);
    bytes.insert(bytes.end(), four.begin(), four.end());
  }
  const std::vector<uint8_t> png = PngOf(values);
  bytes.insert(bytes.end(), png.begin(), png.end());
  return bytes;
}

TEST(FromRos, CompressedDepthIsInMetres) {
  const cv::Mat1w millimetres = (cv::Mat1w(1, 3) << 0, 1500, 65000);
  for (const std::vector<uint8_t>& data :
       {CompressedDepth(millimetres, 0, 0), PngOf(millimetres)}) {
    const auto message = CompressedMessage("16UC1; compressedDepth png", data);
    const Result<cv::Mat1f> depth = FromRosDepth(*message, cv::Size(3, 1));
    ASSERT_TRUE(depth) << ErrorOf(depth);
    EXPECT_FALSE(IsReturn((*depth)(0, 0)));
    EXPECT_FLOAT_EQ((*depth)(0, 1), 1.5F);
    EXPECT_FLOAT_EQ((*depth)(0, 2), 65);
    EXPECT_THAT(ErrorOf(FromRosDepth(*message, cv::Size(4, 1))), HasSubstr("PNG of 3x1"));
  }
  // Quantised as its encoder does: value = a / z + b.
  const float a = 10000, b = -5;
  const cv::Mat1w quantised = (cv::Mat1w(1, 2) << 0, static_cast<uint16_t>(a / 2.5F + b));
  const Result<cv::Mat1f> depth = FromRosDepth(
      *CompressedMessage("32FC1; compressedDepth", CompressedDepth(quantised, a, b)), {});
  ASSERT_TRUE(depth) << ErrorOf(depth);
  EXPECT_FALSE(IsReturn((*depth)(0, 0)));
  EXPECT_NEAR((*depth)(0, 1), 2.5, 1e-3);
  EXPECT_THAT(ErrorOf(FromRosDepth(*CompressedMessage("32FC1; png", PngOf(quantised)), {})),
              HasSubstr("no parameters of the quantised inverse depths"));
  EXPECT_THAT(ErrorOf(FromRosDepth(
                  *CompressedMessage("16UC1; compressedDepth rvl", std::vector<uint8_t>(100)), {})),
              HasSubstr("'16UC1; compressedDepth rvl': its data is none that can be read"));
  EXPECT_THAT(ErrorOf(FromRosDepth(*CompressedMessage("", PngOf(cv::Mat1b(1, 2, uint8_t{7}))), {})),
              HasSubstr("1 channels and 8 bits"));
}

// Velodyne's driver: x y z intensity ring time, 22 bytes; here z stands in front.
TEST(FromRos, PointsOfAnyLayout) {
  RosMessage<RosPointCloud> cloud;
  cloud->height = 2;
  cloud->width = 2;
  cloud->point_step = 22;
  cloud->row_step = 50;
  const std::span fields = ResizeRos(cloud->fields, 4);
  const char* const names[] = {"z", "ring", "x", "y"};
  const uint32_t offsets[] = {0, 4, 6, 18};
  for (size_t i = 0; i < 4; ++i) {
    SetRosText(fields[i].name, names[i]);
    fields[i].offset = offsets[i];
    fields[i].datatype = i == 1 ? 4 : 7;
    fields[i].count = 1;
  }
  uint8_t* const data = ResizeRos(cloud->data, 100).data();
  const float xyz[4][3] = {{1, 2, 3}, {NAN, 0, 0}, {4, -5, 6}, {0, 0, 2000}};
  for (size_t i = 0; i < 4; ++i) {
    uint8_t* const at = data + 50 * (i / 2) + 22 * (i % 2);
    std::memcpy(at + 6, &xyz[i][0], 4);
    std::memcpy(at + 18, &xyz[i][1], 4);
    std::memcpy(at, &xyz[i][2], 4);
  }
  const auto points = FromRosCloud(*cloud);
  ASSERT_TRUE(points) << ErrorOf(points);
  EXPECT_THAT(*points, testing::ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, -5, 6)));
  cloud->row_step = 51;
  EXPECT_THAT(ErrorOf(FromRosCloud(*cloud)), HasSubstr("data length = 100"));
  cloud->row_step = 50;
  fields[0].offset = 19;
  EXPECT_THAT(ErrorOf(FromRosCloud(*cloud)), HasSubstr("fields x, y and z of FLOAT32"));
  // A double of z where it is now, in the bytes of ring and x.
  fields[0].offset = 0;
  fields[0].datatype = 8;
  fields[2].offset = 14;
  for (size_t i = 0; i < 4; ++i) {
    const double z = 7;
    std::memcpy(data + 50 * (i / 2) + 22 * (i % 2), &z, 8);
    std::memcpy(data + 50 * (i / 2) + 22 * (i % 2) + 14, &xyz[0][0], 4);
  }
  ASSERT_EQ(FromRosCloud(*cloud)->size(), 4U);
  EXPECT_EQ((*FromRosCloud(*cloud))[2], Eigen::Vector3d(1, -5, 7));
  fields[0].offset = 15;
  EXPECT_THAT(ErrorOf(FromRosCloud(*cloud)), HasSubstr("FLOAT64 within point_step"));
}

TEST(FromRos, ACloudOfEmptyRowsTakesNoTime) {
  auto cloud = ToRosCloud(Place(), PointCloud{});
  cloud->height = std::numeric_limits<uint32_t>::max();
  const auto begun = std::chrono::steady_clock::now();
  const auto points = FromRosCloud(*cloud);
  ASSERT_TRUE(points) << ErrorOf(points);
  EXPECT_TRUE(points->empty());
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(100));
}

}  // namespace
}  // namespace sprout
