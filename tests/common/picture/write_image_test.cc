#include "common/picture/write_image.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <opencv2/imgcodecs.hpp>

#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

/// Each pixel different, one of them without a disparity.
DisparityImage Ramp() {
  DisparityImage disparity(cv::Size(37, 23));
  for (int v = 0; v < disparity.height(); ++v) {
    for (int u = 0; u < disparity.width(); ++u) disparity.counts()(v, u) = ToCounts(v + u / 32.0);
  }
  disparity.counts()(4, 30) = DisparityImage::kInvalid;
  return disparity;
}

TEST(WritePfm, ReadsBackWithTheSameRowsInTheSameOrder) {
  const TemporaryDirectory directory;
  const DisparityImage disparity = Ramp();
  const auto written = WritePfm(directory / "map.pfm", disparity);
  ASSERT_TRUE(written) << written.error().text;
  const cv::Mat1f read = cv::imread((directory / "map.pfm").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.size(), disparity.size());
  for (int v = 0; v < read.rows; ++v) {
    for (int u = 0; u < read.cols; ++u) {
      if (disparity.IsValid(u, v)) {
        ASSERT_EQ(read(v, u), disparity.Px(u, v)) << u << ", " << v;
      }
    }
  }
  EXPECT_EQ(read(4, 30), std::numeric_limits<float>::infinity());
}

TEST(WritePfm, PutsTheBottomRowFirst) {
  const TemporaryDirectory directory;
  DisparityImage disparity(cv::Size(1, 2));
  disparity.counts()(0, 0) = ToCounts(1);
  disparity.counts()(1, 0) = ToCounts(2);
  ASSERT_TRUE(WritePfm(directory / "map.pfm", disparity));
  const std::string bytes = FileText(directory / "map.pfm");
  using std::string_literals::operator""s;
  EXPECT_EQ(bytes, "Pf\n1 2\n-1.0\n\0\0\0\x40\0\0\x80\x3f"s);  // 2.0 and 1.0
}

TEST(WritePng, ReadsBackUnchanged) {
  const TemporaryDirectory directory;
  cv::Mat3b picture(20, 30);
  cv::randu(picture, 0, 256);
  ASSERT_TRUE(WritePng(directory / "picture.png", picture));
  EXPECT_EQ(cv::norm(cv::imread((directory / "picture.png").string()), picture), 0);
  EXPECT_EQ(directory.CountEntries(), 1);
}

TEST(WritePng, RefusesAnEmptyPicture) {
  const TemporaryDirectory directory;
  EXPECT_THAT(WhyNot(WritePng(directory / "picture.png", cv::Mat())), HasSubstr("empty"));
  EXPECT_EQ(directory.CountEntries(), 0);
}

TEST(OutputFiles, AreRefusedInAMissingDirectory) {
  const TemporaryDirectory directory;
  EXPECT_THAT(WhyNot(WritePfm(directory / "missing/map.pfm", Ramp())),
              HasSubstr("missing/map.pfm: No such file or directory"));
  EXPECT_EQ(directory.CountEntries(), 0);
}

TEST(OutputFiles, LeaveNothingBehindWhenTheyCannotGetTheirName) {
  const TemporaryDirectory directory;
  std::filesystem::create_directory(directory / "map.pfm");
  EXPECT_THAT(WhyNot(WritePfm(directory / "map.pfm", Ramp())), HasSubstr("map.pfm: a folder"));
  EXPECT_EQ(directory.CountEntries(), 1);
}

TEST(OutputFiles, KeepTheOlderFileWhenTheDiskIsFull) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(WritePfm(directory / "map.pfm", Ramp()));
  const auto old_size = std::filesystem::file_size(directory / "map.pfm");

  // A limit on the size of files stands in for a full disk.
  rlimit unlimited{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &unlimited), 0);
  const rlimit limited{4096, unlimited.rlim_max};
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limited), 0);
  const auto written = WritePfm(directory / "map.pfm", DisparityImage(cv::Size(1300, 1110)));
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, old_handler);

  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().text, HasSubstr("map.pfm: File too large"));
  EXPECT_EQ(directory.CountEntries(), 1);
  EXPECT_EQ(std::filesystem::file_size(directory / "map.pfm"), old_size);
}

}  // namespace
}  // namespace sprout
