#include "common/picture/chart.h"

#include <gmock/gmock.h>

#include <cmath>

namespace sprout {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Chart, EscapeTextAndLeaveOutWhatIsNotThere) {
  EXPECT_THAT(HistogramSvg("<a&b>", {1, 2}, {}), HasSubstr("&lt;a&amp;b&gt;"));
  EXPECT_EQ(HistogramSvg("x", {NAN}, {}), "");
  EXPECT_THAT(HistogramSvg("x", {1, 2, 2}, {2, 3, 3}), HasSubstr("polyline"));
  EXPECT_THAT(HistogramSvg("x", {1, 1}, {}), Not(HasSubstr("nan")));
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
