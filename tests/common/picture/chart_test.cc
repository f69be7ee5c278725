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

}  // namespace
}  // namespace sprout
