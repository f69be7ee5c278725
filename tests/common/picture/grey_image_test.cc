// Whatever shows a camera image shows a grey one as it shows the same picture in colours.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "common/core/image.h"
#include "common/picture/cloud_view.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

/// One, two and no times a third of a pixel's bytes left over: OpenCV takes a grey image of 3 n
/// bytes for one of n colours.
const cv::Size kSizes[] = {{40, 25}, {64, 40}, {41, 25}, {128, 102}, {1, 1}};

cv::Mat1b Grey(cv::Size size) {
  cv::Mat1b grey(size);
  cv::randu(grey, 0, 256);
  return grey;
}

DisparityImage Slope(cv::Size size) {
  DisparityImage disparity(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) disparity.counts()(v, u) = ToCounts(4 + v / 8.0);
  }
  return disparity;
}

RectifiedPair PairOf(cv::Size size) {
  return {.width = size.width,
          .height = size.height,
          .focal_px = 50,
          .cx = size.width / 2.0,
          .cy = size.height / 2.0,
          .cx_right = size.width / 2.0,
          .baseline_m = 0.1};
}

void ExpectSamePicture(const std::function<cv::Mat3b(const cv::Mat&)>& picture_of) {
  for (const cv::Size size : kSizes) {
    SCOPED_TRACE(SizeText(size));
    const cv::Mat1b grey = Grey(size);
    const cv::Mat3b of_grey = picture_of(grey);
    const cv::Mat3b of_colour = picture_of(ToBgr(grey));
    ASSERT_EQ(of_grey.size(), of_colour.size());
    EXPECT_EQ(cv::norm(of_grey, of_colour, cv::NORM_INF), 0);
  }
}

TEST(GreyImage, LooksTheSameInACameraPicture) {
  ExpectSamePicture([](const cv::Mat& image) { return CameraPicture(image, "Left"); });
}

TEST(GreyImage, LooksTheSameUnderSeeds) {
  const std::vector<Seed> seeds{{.u = 12, .v = 7, .u_right = 4}};
  ExpectSamePicture([&](const cv::Mat& image) {
    return SeedPicture(image, seeds, {0, 16}, "Seeds");
  });
}

TEST(GreyImage, LooksTheSameAsACloud) {
  ExpectSamePicture([](const cv::Mat& image) {
    return CloudView(PairOf(image.size()), Slope(image.size()), image);
  });
}

TEST(CloudView, ShowsTheColoursOfTheLeftImage) {
  const cv::Size size(64, 40);
  const cv::Mat3b left(size, cv::Vec3b(10, 90, 170));
  const cv::Mat3b view = CloudView(PairOf(size), Slope(size), left);
  ASSERT_EQ(view.size(), size);
  EXPECT_GT(std::count(view.begin(), view.end(), cv::Vec3b(10, 90, 170)), 100);
}

std::string BytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(GreyImage, ColoursACloudAndAMeshAsItsColoursDo) {
  const TemporaryDirectory directory;
  for (const cv::Size size : kSizes) {
    SCOPED_TRACE(SizeText(size));
    const cv::Mat1b grey = Grey(size);
    for (const auto write : {WriteCloudPly, WriteMeshPly}) {
      ASSERT_TRUE(write(directory / "grey.ply", PairOf(size), Slope(size), grey, cv::Mat()));
      ASSERT_TRUE(
          write(directory / "colour.ply", PairOf(size), Slope(size), ToBgr(grey), cv::Mat()));
      EXPECT_EQ(BytesOf(directory / "grey.ply"), BytesOf(directory / "colour.ply"));
    }
  }
}

TEST(GreyImage, ReadsBackUnchangedFromPng) {
  const TemporaryDirectory directory;
  for (const cv::Size size : kSizes) {
    const cv::Mat1b grey = Grey(size);
    ASSERT_TRUE(WritePng(directory / "grey.png", grey));
    const cv::Mat read = cv::imread((directory / "grey.png").string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read.type(), CV_8UC1);
    EXPECT_EQ(cv::norm(read, grey, cv::NORM_INF), 0) << SizeText(size);
  }
}

}  // namespace
}  // namespace sprout
