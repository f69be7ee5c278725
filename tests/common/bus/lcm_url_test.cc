#include "common/bus/lcm_url.h"

#include <gmock/gmock.h>

#include <set>

#include "common/bus/channels.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& url) {
  return Thrown<BusError>([&] { OpenLcm(url); });
}

TEST(ReceiveBufferWarning, NamesWhatIsGrantedAndWhatToDo) {
  // More than the kernel can grant on any machine: its limit is an int.
  const auto warning = ReceiveBufferWarning("udpm://239.255.76.67:7667?recv_buf_size=99999999999");
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning, HasSubstr("of 99999999999 bytes"));
  EXPECT_THAT(*warning, HasSubstr("sysctl -w net.core.rmem_max=99999999999"));
  EXPECT_EQ(warning->find('\n'), std::string::npos);
}

TEST(ReceiveBufferWarning, IsSilentWhenThereIsNothingToWarnOf) {
  EXPECT_FALSE(ReceiveBufferWarning("udpm://239.255.76.67:7667?recv_buf_size=1"));
  EXPECT_FALSE(ReceiveBufferWarning("udpm://239.255.76.67:7667?ttl=0"));
  EXPECT_FALSE(ReceiveBufferWarning("tcpq://localhost:7700?recv_buf_size=99999999999"));
  EXPECT_FALSE(ReceiveBufferWarning(""));
}

TEST(LcmUrl, IsRefusedInOneLineThatSaysWhatIsAllowed) {
  const struct {
    const char* url;
    const char* error;
  } table[] = {
      {"", "no such kind; allowed: udpm://"},
      {"nonsense", "LCM URL nonsense: no such kind; allowed: udpm://"},
      {"http://localhost:80", "no such kind"},
      {"memq://", "no such kind"},  // reaches nobody
      {"file:///tmp/log.lcm", "no such kind"},
      {"udpm://localhost:7667", "'localhost' is no multicast group; allowed: 224.0.0.0 to"},
      {"udpm://239.255.76:7667?ttl=0", "'239.255.76' is no multicast group"},
      {"udpm://127.0.0.1:7667", "'127.0.0.1' is no multicast group"},
      {"udpm://240.0.0.1:7667", "'240.0.0.1' is no multicast group"},
      {"udpm://239.255.76.67:0", "port '0'; allowed: 1 to 65535"},
      {"udpm://239.255.76.67:65536", "port '65536'"},
      {"udpm://239.255.76.67:x", "port 'x'"},
      {"udpm://239.255.76.67:7667?ttl=-5", "'ttl=-5'; allowed: ttl=0 to ttl=255"},
      {"udpm://239.255.76.67:7667?ttl=999", "'ttl=999'"},
      {"udpm://239.255.76.67:7667?ttl=", "'ttl='"},
      {"udpm://239.255.76.67:7667?ttl", "'ttl'"},
      {"udpm://239.255.76.67:7667?ttl=0&tll=1", "'tll=1'; allowed: "},
      {"udpm://239.255.76.67:7667?ttl=0&ttl=1", "'ttl=1'; allowed: "},
      {"udpm://239.255.76.67:7667?recv_buf_size=0", "'recv_buf_size=0'"},
      {"tcpq://localhost:99999", "port '99999'"},
      {"tcpq://localhost:7700?ttl=0", "'ttl=0'; allowed: tcpq://HOST:PORT, without options"},
  };
  for (const auto& [url, error] : table) {
    ASSERT_TRUE(LcmUrlError(url)) << url;
    EXPECT_THAT(*LcmUrlError(url), HasSubstr(error));
    EXPECT_EQ(LcmUrlError(url)->find('\n'), std::string::npos);
    EXPECT_EQ(ErrorOf(url), *LcmUrlError(url));
  }
}

TEST(LcmUrl, MayLeaveOutWhatLcmKnowsByItself) {
  for (const char* url : {kDefaultLcmUrl, "udpm://", "udpm://?ttl=1", "udpm://:7668",
                          "udpm://239.255.76.67", "udpm://224.0.0.1:1?ttl=255,recv_buf_size=1",
                          "tcpq://", "tcpq://localhost", "tcpq://h:1"}) {
    EXPECT_EQ(LcmUrlError(url), std::nullopt) << url;
  }
}

TEST(OpenLcm, SendsWhereTheUrlLeavesOutPortOrGroup) {
  for (const std::string url : {"udpm://239.255.76.67?ttl=0", "udpm://:7668", "udpm://?ttl=0"}) {
    LcmPtr lcm;
    const std::string error = Thrown<BusError>([&] { lcm = OpenLcm(url); });
    if (error.starts_with("no multicast route")) GTEST_SKIP() << error;
    ASSERT_TRUE(lcm) << error;
    EXPECT_EQ(lcm_publish(lcm.get(), "A", "", 0), 0) << url;
  }
}

TEST(OpenLcm, SaysWhenNoServerAnswers) {
  // Port 1 of this host: nothing listens there.
  EXPECT_THAT(ErrorOf("tcpq://127.0.0.1:1"),
              HasSubstr("cannot open LCM URL tcpq://127.0.0.1:1; is its server"));
}

TEST(Channels, HaveANameOfTheirOwnForEachPart) {
  std::set<std::string_view> names = {kStatusChannel, kProcessChannel, kRigChangeChannel};
  for (const Part part : kAllParts) {
    EXPECT_TRUE(ChannelOf(part).starts_with("SPROUT_"));
    EXPECT_TRUE(names.insert(ChannelOf(part)).second) << ChannelOf(part);
  }
}

TEST(Channels, FitIntoLcmsLimitWithTheLongestPrefix) {
  for (const Part part : kAllParts) {
    EXPECT_LE(kMaxChannelPrefix + ChannelOf(part).size(), 63U);
  }
  EXPECT_LE(kMaxChannelPrefix + kStatusChannel.size(), 63U);
  EXPECT_LE(kMaxChannelPrefix + kProcessChannel.size(), 63U);
  EXPECT_LE(kMaxChannelPrefix + kRigChangeChannel.size(), 63U);
}

}  // namespace

}  // namespace sprout
