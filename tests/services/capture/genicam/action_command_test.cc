#include <gmock/gmock.h>

#include "services/capture/genicam/discovery.h"

namespace sprout::capture {
namespace {

// Byte by byte as the standard's table of ACTION_CMD has it; no camera was asked.
TEST(ActionCommand, IsTheStandardsPacket) {
  EXPECT_THAT(ScheduledAction(0x1234, 0x0102030405060708),
              testing::ElementsAre(0x42, 0x80, 0x01, 0x00, 0, 20, 0x12, 0x34,       //
                                   0x53, 0x50, 0x52, 0x4F, 0, 0, 0, 1, 0, 0, 0, 1,  //
                                   1, 2, 3, 4, 5, 6, 7, 8));
}

}  // namespace
}  // namespace sprout::capture
