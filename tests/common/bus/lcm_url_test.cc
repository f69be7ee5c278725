#include "common/bus/lcm_url.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/bus/publisher.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& url) {
  try {
    OpenLcm(url);
  } catch (const BusError& e) {
    return e.what();
  }
  return "";
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
  EXPECT_FALSE(ReceiveBufferWarning("memq://"));
  EXPECT_FALSE(ReceiveBufferWarning(""));
}

TEST(OpenLcm, RefusesAUrlOfNoKnownKind) {
  EXPECT_THAT(ErrorOf("nonsense"), HasSubstr("cannot open LCM URL nonsense; allowed: udpm://"));
  EXPECT_THAT(ErrorOf("http://localhost:80"), HasSubstr("http://localhost:80; allowed: udpm://"));
}

TEST(OpenLcm, RefusesAMulticastGroupThatIsNoAddress) {
  EXPECT_THAT(ErrorOf("udpm://localhost:7667"), HasSubstr("'localhost' is no IPv4 address"));
  EXPECT_THAT(ErrorOf("udpm://239.255.76:7667?ttl=0"), HasSubstr("'239.255.76' is no IPv4"));
}

TEST(OpenLcm, SaysWhenNoServerAnswers) {
  // Port 1 of this host: nothing listens there.
  EXPECT_THAT(ErrorOf("tcpq://127.0.0.1:1"), HasSubstr("with its server running"));
}

TEST(OpenLcm, OpensAQueueInMemory) { EXPECT_NE(OpenLcm("memq://"), nullptr); }

TEST(Publisher, NeedsAConnection) {
  const uint8_t byte = 1;
  EXPECT_TRUE(Publisher("memq://", "A_").Publish("SPROUT_LEFT", {&byte, 1}));
  EXPECT_THROW(Publisher("nonsense", ""), BusError);
}

}  // namespace
}  // namespace sprout
