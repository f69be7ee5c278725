#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>

#include "common/geometry/lens.h"
#include "common/messages/jpeg.h"
#include "common/ros2/frame_topics.h"
#include "common/ros2/from_ros.h"
#include "tests/common/ros2/ros_examples.h"

namespace sprout {
namespace {

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

std::string ErrorOf(const auto& result) { return result ? "none" : result.error().text; }

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
  const Result<cv::Mat> thermal = FromRosImage(*Image("16UC1", {8, 8}, 16, bytes));
  ASSERT_TRUE(thermal) << ErrorOf(thermal);
  EXPECT_EQ(thermal->at<uint16_t>(4, 4), 1000);
}

TEST(FromRos, RefusesImagesThatCannotBe) {
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("nv12", {1, 1}, 2, {1, 2}))),
              HasSubstr("encoding = 'nv12': allowed is mono8, "));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("yuv422", {1, 1}, 2, {1, 2}))),
              HasSubstr("width = 1: allowed with yuv422 are even ones"));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("mono8", {4, 1}, 3, {1, 2, 3}))),
              HasSubstr("step = 3: allowed is at least 4"));
  EXPECT_THAT(ErrorOf(FromRosImage(*Image("mono8", {4, 2}, 4, {1, 2, 3, 4}))),
              HasSubstr("data length = 4: allowed is step × height"));
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

TEST(FromRos, ThePairComesBack) {
  const RectifiedPair pair = examples::Rig().pair;
  const auto left = FromRosInfo(*ToRosLeftInfo(Place(), pair));
  const auto right = FromRosInfo(*ToRosRightInfo(Place(), pair));
  ASSERT_TRUE(left && right);
  EXPECT_EQ(right->tx, -500 * 0.125);
  const Result<RectifiedPair> back = PairOf(*left, *right);
  ASSERT_TRUE(back) << ErrorOf(back);
  EXPECT_EQ(RigId({.pair = *back, .tof = {}}), RigId({.pair = pair, .tof = {}}));
  EXPECT_THAT(ErrorOf(PairOf(*right, *left)),
              HasSubstr("right p[3] = 0: allowed is −f·b, below the left camera's, -62.5; are they "
                        "swapped?"));
}

// KITTI's third and fourth camera, whose Tx is relative to the first one.
TEST(FromRos, TheBaselineIsTheDifferenceOfBothTx) {
  const RectifiedPair pair = examples::Rig().pair;
  auto left_info = ToRosLeftInfo(Place(), pair);
  auto right_info = ToRosRightInfo(Place(), pair);
  for (const double shift : {44.86, -100.0}) {
    left_info->p[3] = shift;
    right_info->p[3] = shift - 500 * 0.125;
    const Result<RectifiedPair> back = PairOf(*FromRosInfo(*left_info), *FromRosInfo(*right_info));
    ASSERT_TRUE(back) << ErrorOf(back);
    EXPECT_NEAR(back->baseline_m, 0.125, 1e-12);
  }
}

// The same camera with another lens in K and D.
RosMessage<RosCameraInfo> WithLens(const RosCameraInfo& of, const std::string& model,
                                   const std::vector<double>& d) {
  RosMessage<RosCameraInfo> info;
  info->width = of.width;
  info->height = of.height;
  std::ranges::copy(of.k, info->k);
  std::ranges::copy(of.r, info->r);
  std::ranges::copy(of.p, info->p);
  info->k[0] *= 1.5;
  SetRosText(info->distortion_model, model);
  std::ranges::copy(d, ResizeRos(info->d, d.size()).begin());
  return info;
}

// Rectified images whose drivers keep the lens of the raw ones in their messages.
TEST(FromRos, ThePairIsPWhateverTheLens) {
  const RectifiedPair pair = examples::Rig().pair;
  for (const char* model : {"rational_polynomial", "equidistant", "thin_prism_fisheye"}) {
    const std::vector<double> d(model[0] == 'e' ? 4 : 8, 0.25);
    const auto left = FromRosInfo(*WithLens(*ToRosLeftInfo(Place(), pair), model, d));
    ASSERT_TRUE(left) << ErrorOf(left);
    const auto right = FromRosInfo(*WithLens(*ToRosRightInfo(Place(), pair), model, d));
    const Result<RectifiedPair> back = PairOf(*left, *right);
    ASSERT_TRUE(back) << ErrorOf(back);
    EXPECT_EQ(RigId({.pair = *back, .tof = {}}), RigId({.pair = pair, .tof = {}}));
    if (model[0] != 't') continue;
    EXPECT_THAT(ErrorOf(left->lens),
                HasSubstr("distortion_model = thin_prism_fisheye: allowed is plumb_bob"));
  }
}

// 0.03 % is a tenth of a pixel at the edges of 480 rows, 1 % is 2.4 px.
TEST(FromRos, PixelsAreSquareUpToHalfARow) {
  const RectifiedPair pair = examples::Rig().pair;
  auto left = ToRosLeftInfo(Place(), pair);
  auto right = ToRosRightInfo(Place(), pair);
  left->p[5] *= 1.0003;
  EXPECT_THAT(ErrorOf(PairOf(*FromRosInfo(*left), *FromRosInfo(*right))),
              HasSubstr("right p[5] = 500: allowed is that of the left camera"));
  right->p[5] *= 1.0003;
  EXPECT_TRUE(PairOf(*FromRosInfo(*left), *FromRosInfo(*right)));
  left->p[5] *= 1.01;
  EXPECT_THAT(ErrorOf(PairOf(*FromRosInfo(*left), *FromRosInfo(*right))),
              HasSubstr("left p[5] = 505.15"));
}

TEST(FromRos, RefusesCamerasThatAreNotCalibrated) {
  auto info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->p[0] = 0;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("p[0] = 0: allowed is a focal length > 0"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->k[0] = 0;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)->lens), HasSubstr("k[0] = 0: allowed is a focal length"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->r[0] = -1;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("r = no rotation"));
  info = ToRosLeftInfo(Place(), examples::Rig().pair);
  info->p[3] = NAN;
  EXPECT_THAT(ErrorOf(FromRosInfo(*info)), HasSubstr("p = not finite"));
}

// OpenCV's rational model with the coefficients of Brown's alone is Brown's.
TEST(FromRos, ALensOfARationalModelMayBeBrowns) {
  const auto camera = FromRosInfo(*WithLens(*ToRosLeftInfo(Place(), examples::Rig().pair),
                                            "rational_polynomial", {1, 2, 3, 4, 5, 0, 0, 0}));
  ASSERT_TRUE(camera && camera->lens) << ErrorOf(camera->lens);
  EXPECT_EQ(camera->lens->distortion, (std::array<double, 5>{1, 2, 3, 4, 5}));
}

// Azure Kinect's and fisheye drivers' raw range images.
TEST(FromRos, ALensOfAnotherModelBecomesTheNearestOfBrowns) {
  const auto camera = [&](const std::string& model, double focal_px, const std::vector<double>& d) {
    auto info = WithLens(*ToRosTofInfo(Place(), examples::Rig().tof), model, d);
    info->width = 320;
    info->height = 240;
    info->k[0] = info->k[4] = focal_px;
    info->k[2] = 161;
    info->k[5] = 118;
    return FromRosInfo(*info)->lens;
  };
  const std::vector<cv::Point3d> points = {
      {0, 0, 1}, {0.4, 0.3, 1}, {-0.4, 0.2, 1}, {0.1, -0.3, 1}};
  const std::vector<double> rational = {0.3, -0.1, 1e-4, 2e-4, 0.01, 0.5, -0.1, 0.02};
  const std::vector<double> fisheye = {-0.02, 0.01, 0, 0};
  const cv::Matx33d square(300, 0, 161, 0, 300, 118, 0, 0, 1);
  for (const bool is_fisheye : {false, true}) {
    const Result<Lens> lens = is_fisheye ? camera("equidistant", 300, fisheye)
                                         : camera("rational_polynomial", 300, rational);
    ASSERT_TRUE(lens) << ErrorOf(lens);
    std::vector<cv::Point2d> places;
    const cv::Vec3d none(0, 0, 0);
    if (is_fisheye) {
      cv::fisheye::projectPoints(points, places, none, none, square, fisheye);
    } else {
      cv::projectPoints(points, none, none, square, rational, places);
    }
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d ours = PixelOfDirection(*lens, {points[i].x, points[i].y});
      EXPECT_NEAR(ours.x(), places[i].x, 0.5) << i << is_fisheye;
      EXPECT_NEAR(ours.y(), places[i].y, 0.5) << i << is_fisheye;
    }
  }
  EXPECT_THAT(ErrorOf(camera("equidistant", 105, fisheye)),
              HasSubstr("px from any, 0.5 are allowed"));
  EXPECT_THAT(ErrorOf(camera("equidistant", 300, rational)),
              HasSubstr("d = 8: allowed is 4 coefficients of equidistant"));
}

TEST(FromRos, TheTofCameraComesBack) {
  const TofCamera tof = examples::Rig().tof;
  const auto info = FromRosInfo(*ToRosTofInfo(Place(), tof));
  ASSERT_TRUE(info) << ErrorOf(info);
  ASSERT_TRUE(info->lens) << ErrorOf(info->lens);
  EXPECT_EQ(info->lens->distortion, tof.distortion);
  const auto poses = FromRosTransforms(*ToRosTransforms(1, examples::Rig(), {}));
  ASSERT_TRUE(poses) << ErrorOf(poses);
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[0].parent_from_child.translation_m, Eigen::Vector3d(0.125, 0, 0));
  EXPECT_EQ((*poses)[1].child, "sprout_tof_optical_frame");
  EXPECT_EQ((*poses)[1].parent_from_child.translation_m, tof.left_from_tof_translation_m);
  EXPECT_EQ((*poses)[1].parent_from_child.rotation.coeffs(), tof.left_from_tof_rotation.coeffs());
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

TEST(ToRos, PointsHavePlaceColourAndConfidence) {
  const PointCloud cloud{{{.position_m = {1, 2, 3}, .bgr = {10, 20, 30}, .confidence = 200}}};
  const auto ros = ToRosCloud(Place(), cloud);
  EXPECT_EQ(ros->point_step, 20U);
  const uint8_t* const at = ros->data._buffer;
  EXPECT_EQ(at[12], 10);
  EXPECT_EQ(at[13], 20);
  EXPECT_EQ(at[14], 30);
  EXPECT_EQ(at[16], 200);
  const auto points = FromRosCloud(*ros);
  ASSERT_TRUE(points) << ErrorOf(points);
  EXPECT_THAT(*points, testing::ElementsAre(Eigen::Vector3d(1, 2, 3)));
}

// z = f·t / d, as image_geometry computes it, is the depth that the pair says.
TEST(ToRos, DisparitiesAreAdjustedByThePrincipalPoints) {
  const RectifiedPair pair = examples::Rig().pair;
  const DisparityImage disparity = examples::SmallDisparity();
  const auto ros = ToRosDisparity(Place(), disparity, pair);
  const cv::Mat1f px(3, 5, reinterpret_cast<float*>(ros->image.data._buffer));
  EXPECT_EQ(px(1, 2), disparity.Px(2, 1) + 310.75F - 320.5F);
  EXPECT_NEAR(ros->f * ros->t / px(1, 3), pair.DepthFromDisparity(disparity.Px(3, 1)), 1e-4);
  EXPECT_EQ(ros->min_disparity, px(1, 0));
  EXPECT_EQ(ros->max_disparity, px(1, 3));
  EXPECT_EQ(px(0, 0), ros->min_disparity - 1);
}

TEST(ToRos, DepthIsMillimetresOrMetres) {
  DepthImage depth{.counts = (cv::Mat1w(1, 3) << 0, 1500, 3), .metres_per_count = 0.001};
  const auto borrowed = ToRosDepth(Place(), depth, RosDepth::kMillimetres);
  EXPECT_EQ(RosText(borrowed->encoding), "16UC1");
  EXPECT_EQ(static_cast<const void*>(borrowed->data._buffer), depth.counts.data);
  const auto metres = ToRosDepth(Place(), depth, RosDepth::kMetres);
  const cv::Mat1f m(1, 3, reinterpret_cast<float*>(metres->data._buffer));
  EXPECT_TRUE(std::isnan(m(0, 0)));
  EXPECT_FLOAT_EQ(m(0, 1), 1.5F);
  depth.metres_per_count = 0.0005;
  const auto scaled = ToRosDepth(Place(), depth, RosDepth::kMillimetres);
  EXPECT_EQ(reinterpret_cast<const uint16_t*>(scaled->data._buffer)[1], 750);
}

TEST(ToRos, StandardDeviationsOfDepthsAreMetres) {
  const DepthImage sigma{.counts = (cv::Mat1w(1, 4) << 0, 1, 800, 65535),
                         .metres_per_count = 0.001 / 16};
  const auto ros = ToRos(RosTopic::kDepthSigma, examples::Id(), sigma, nullptr,
                         {.frames = {}, .depth = RosDepth::kMillimetres});
  ASSERT_NE(ros, nullptr);
  const auto image = ToRosDepthSigma(Place(), sigma);
  EXPECT_EQ(RosText(image->encoding), "32FC1");
  const cv::Mat1f m(1, 4, reinterpret_cast<float*>(image->data._buffer));
  EXPECT_TRUE(std::isnan(m(0, 0)));
  EXPECT_FLOAT_EQ(m(0, 1), 0.0000625F);
  EXPECT_FLOAT_EQ(m(0, 2), 0.05F);
  EXPECT_TRUE(std::isinf(m(0, 3)));
}

TEST(ToRos, StampsAreTheCaptures) {
  EXPECT_EQ(*FromRosStamp(ToRosImage(Place(), examples::GreyImage())->header), Place().utime);
  const RosTime before = RosStamp(-1);
  EXPECT_EQ(before.sec, -1);
  EXPECT_EQ(before.nanosec, 999'999'000U);
  RosHeader header{};
  header.stamp.nanosec = 1'000'000'000;
  EXPECT_THAT(ErrorOf(FromRosStamp(header)), HasSubstr("nanosec = 1000000000"));
}

TEST(RosTopics, SayNothingOfAFrameWithoutCalibrationWhereTheyNeedIt) {
  const PartValue left = examples::GreyImage();
  EXPECT_NE(ToRos(RosTopic::kLeft, examples::Id(), left, nullptr, {}), nullptr);
  EXPECT_EQ(ToRos(RosTopic::kLeftInfo, examples::Id(), left, nullptr, {}), nullptr);
  EXPECT_EQ(RosTopicName(RowOf(RosTopic::kDepth), "/robot"), "/robot/depth/image_rect");
  EXPECT_EQ(RosTopicName(RowOf(RosTopic::kTransforms), "/robot"), "/tf_static");
}

TEST(RosTopics, HaveTheFusedMapBesideTheSingleOne) {
  const Rig rig = examples::Rig();
  const PartValue map = examples::SmallDisparity();
  const auto single = ToRos(RosTopic::kDisparity, examples::Id(), map, &rig, {});
  const auto fused = ToRos(RosTopic::kFused, examples::Id(), map, &rig, {});
  std::vector<uint8_t> fused_bytes, single_bytes;
  WriteCdr(*fused, fused_bytes);
  WriteCdr(*single, single_bytes);
  EXPECT_EQ(fused_bytes, single_bytes);
  EXPECT_EQ(RowOf(RosTopic::kFused).part, Part::kFused);
  EXPECT_EQ(RosTopicName(RowOf(RosTopic::kFused), "/sprout"), "/sprout/fused/disparity");
  const PartValue grey = examples::GreyImage();
  EXPECT_NE(ToRos(RosTopic::kFusedConfidence, examples::Id(), grey, nullptr, {}), nullptr);
  EXPECT_EQ(RowOf(RosTopic::kFusedConfidence).part, Part::kFusedConfidence);
}

TEST(RosSchemas, HaveEveryTypeThatIsUsedOnce) {
  const std::string schema = RosSchema(RosTypeOf<RosDisparity>());
  for (const char* name : {"MSG: std_msgs/Header\n", "MSG: builtin_interfaces/Time\n",
                           "MSG: sensor_msgs/Image\n", "MSG: sensor_msgs/RegionOfInterest\n"}) {
    const size_t at = schema.find(name);
    EXPECT_NE(at, std::string::npos) << name;
    EXPECT_EQ(schema.find(name, at + 1), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace sprout
