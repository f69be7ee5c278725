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

}  // namespace
}  // namespace sprout
