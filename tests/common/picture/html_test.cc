#include "common/picture/html.h"

#include <gtest/gtest.h>

#include <vector>

namespace sprout {
namespace {

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

}  // namespace
}  // namespace sprout
