#include "common/core/reassembly_failures.h"

#include <gtest/gtest.h>

namespace sprout {
namespace {

TEST(ReassemblyFailures, AreReadByTheNameOfTheirColumn) {
  EXPECT_EQ(
      ReassemblyFailuresIn("Tcp: MaxConn\nTcp: -1\nIp: InReceives ReasmReqds ReasmFails FragOKs\n"
                           "Ip: 50 9 7 8\nIcmp: InMsgs\nIcmp: 3\n"),
      7);
  EXPECT_EQ(ReassemblyFailuresIn(""), 0);
  EXPECT_EQ(ReassemblyFailuresIn("Ip: InReceives\nIp: 5\n"), 0);
  EXPECT_EQ(ReassemblyFailuresIn("Ip: InReceives ReasmFails\nIp: 5\n"), 0);
}

}  // namespace
}  // namespace sprout
