#include "common/config/left_out.h"

#include <gmock/gmock.h>

namespace sprout {
namespace {

TEST(LeftOut, SaysWhatIsMissingAndHowToGetIt) {
  EXPECT_STREQ(LeftOut("--mcap", "ROS2").what(),
               "--mcap: built without ROS 2 and MCAP; -DSPROUT_ROS2=ON needs cyclonedds-dev "
               "cyclonedds-tools liblz4-dev libyaml-cpp-dev");
  EXPECT_THAT(LeftOut("sprout: view", "VIEW").what(),
              testing::StartsWith("sprout: view: built without the page in a browser; "));
}

}  // namespace
}  // namespace sprout
