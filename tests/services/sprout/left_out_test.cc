// A build without ROS 2 and GenICam (SPROUT_ROS2=OFF, SPROUT_GENICAM=OFF).
#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/app/process.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

void ExpectRefused(std::vector<std::string> command, const std::string& why) {
  command[0] = (std::filesystem::path(SPROUT_BINARY_DIR) / command[0]).string();
  Process process(command);
  EXPECT_EQ(process.Wait(), 2) << command[0];
  EXPECT_THAT(process.Output(), HasSubstr(why));
}

TEST(LeftOutParts, AreNamedWhenAskedFor) {
  const std::string ros = "built without ROS 2 and MCAP; -DSPROUT_ROS2=ON needs cyclonedds-dev";
  ExpectRefused({"sprout", "ros2"}, "sprout: ros2: " + ros);
  ExpectRefused({"sprout-log", "export", "a.lcm", "--mcap", "a.mcap"}, "--mcap: " + ros);
  ExpectRefused({"sprout-log", "info", "a.mcap"}, "a.mcap: " + ros);
  ExpectRefused({"sprout-capture", "--source", "ros2:left=a&right=b"}, ros);
  ExpectRefused({"sprout-capture", "--source", "mcap:a.mcap?left=a&right=b"}, ros);
  ExpectRefused({"sprout-capture", "--list"}, "--list: built without cameras of GigE Vision");
}

}  // namespace
}  // namespace sprout
