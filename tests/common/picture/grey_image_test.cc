// Whatever shows a camera image shows a grey one as it shows the same picture in colours.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/picture/frame_pictures.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "tests/common/core/centred.h"
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

RectifiedPair PairOf(cv::Size size) { return CentredPair(size.width, size.height, 50); }

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

TEST(GreyImage, ColoursACloudAndAMeshAsItsColoursDo) {
  const TemporaryDirectory directory;
  for (const cv::Size size : kSizes) {
    SCOPED_TRACE(SizeText(size));
    const cv::Mat1b grey = Grey(size);
    for (const auto write : {WriteCloudPly, WriteMeshPly}) {
      ASSERT_TRUE(write(directory / "grey.ply", PairOf(size), Slope(size), grey, cv::Mat()));
      ASSERT_TRUE(
          write(directory / "colour.ply", PairOf(size), Slope(size), ToBgr(grey), cv::Mat()));
      EXPECT_EQ(FileText(directory / "grey.ply"), FileText(directory / "colour.ply"));
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

TEST(Html, ShowsTextAsItIs) {
  EXPECT_EQ(EscapedHtml("a < b && c > \"d\""), "a &lt; b &amp;&amp; c &gt; &quot;d&quot;");
  EXPECT_EQ(EscapedHtml(""), "");
}

// RFC 4648, section 10.
TEST(Html, HasBytesOfAnyNumberInAUrl) {
  const auto url = [](const std::string& text) {
    const std::vector<uint8_t> bytes(text.begin(), text.end());
    return DataUrl("image/png", bytes);
  };
  EXPECT_EQ(url(""), "data:image/png;base64,");
  EXPECT_EQ(url("f"), "data:image/png;base64,Zg==");
  EXPECT_EQ(url("fo"), "data:image/png;base64,Zm8=");
  EXPECT_EQ(url("foo"), "data:image/png;base64,Zm9v");
  EXPECT_EQ(url("foobar"), "data:image/png;base64,Zm9vYmFy");
}

TEST(Html, TablesEscapeTheirTexts) {
  EXPECT_EQ(TableHtml({{"a", "b"}, {"<1>", "2"}}),
            "<table>\n<tr><th>a</th><th>b</th></tr>\n<tr><td>&lt;1&gt;</td><td>2</td></tr>\n"
            "</table>\n");
}

TEST(Html, FiguresHaveTheirPictureInside) {
  const std::string html = FigureHtml(cv::Mat3b(2, 3, cv::Vec3b()), "<b>black</b>");
  EXPECT_EQ(html.find("<figure><img alt=\"\" src=\"data:image/png;base64,iVBORw0KGgo"), 0);
  EXPECT_NE(html.find("<figcaption><b>black</b></figcaption>"), std::string::npos);
}

using ::testing::HasSubstr;

TEST(Chart, EscapeTextAndLeaveOutWhatIsNotThere) {
  EXPECT_THAT(HistogramSvg("<a&b>", {1, 2}, {}), HasSubstr("&lt;a&amp;b&gt;"));
  EXPECT_EQ(HistogramSvg("x", {NAN}, {}), "");
  EXPECT_THAT(HistogramSvg("x", {1, 2, 2}, {2, 3, 3}), HasSubstr("polyline"));
  EXPECT_THAT(HistogramSvg("x", {1, 1}, {}), ::testing::Not(HasSubstr("nan")));
}

TEST(Chart, DrawsLinesBetweenTheAxesAndLeavesOutWhatIsNotThere) {
  const LinePlot plot = {.title = "a<b",
                         .along = "x",
                         .up = "y",
                         .right = 10,
                         .top = 4,
                         .lines = {{.points = {{0, 0}, {5, NAN}, {10, 8}}, .name = "one"}},
                         .size = {100, 50}};
  const std::string svg = PlotsSvg({{plot, plot}, {plot}});
  EXPECT_THAT(svg, HasSubstr("points=\"56.0,106.0 156.0,56.0\""));   // the first
  EXPECT_THAT(svg, HasSubstr("points=\"268.0,106.0 368.0,56.0\""));  // beside it
  EXPECT_THAT(svg, HasSubstr("points=\"56.0,268.0 156.0,218.0\""));  // below it
  EXPECT_THAT(svg, HasSubstr("width=\"424\" height=\"324\""));
  EXPECT_THAT(svg, HasSubstr("a&lt;b"));
  EXPECT_THAT(svg, HasSubstr(">one</text>"));
}

}  // namespace

}  // namespace sprout
