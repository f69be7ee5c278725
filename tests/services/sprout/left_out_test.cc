// A build without one part or several (SPROUT_ROS2=OFF, ...).
#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/app/process.h"

namespace sprout {
namespace {

void ExpectRefused(std::vector<std::string> command, const std::string& why) {
  command[0] = (std::filesystem::path(SPROUT_BINARY_DIR) / command[0]).string();
  Process process(command);
  EXPECT_EQ(process.Wait(), 2) << command[0];
  EXPECT_THAT(process.Output(), ::testing::HasSubstr(why));
}

#ifdef SPROUT_WITHOUT_GENICAM
TEST(LeftOutParts, GenicamIsNamedWhenAskedFor) {
  ExpectRefused({"sprout-capture", "--list"}, "--list: built without cameras of GigE Vision");
}
#endif

#ifdef SPROUT_WITHOUT_ROS2
TEST(LeftOutParts, Ros2IsNamedWhenAskedFor) {
  const std::string ros = "built without ROS 2 and MCAP; -DSPROUT_ROS2=ON needs cyclonedds-dev";
  ExpectRefused({"sprout", "ros2"}, "sprout: ros2: " + ros);
  ExpectRefused({"sprout-log", "export", "a.lcm", "--mcap", "a.mcap"}, "--mcap: " + ros);
  ExpectRefused({"sprout-log", "info", "a.mcap"}, "a.mcap: " + ros);
  ExpectRefused({"sprout-capture", "--source", "ros2:left=a&right=b"}, ros);
  ExpectRefused({"sprout-capture", "--source", "mcap:a.mcap?left=a&right=b"}, ros);
}
#endif

#ifdef SPROUT_WITHOUT_CALIBRATE
TEST(LeftOutParts, CalibrationIsNamedWhenAskedFor) {
  const std::string calibration = "built without calibration; -DSPROUT_CALIBRATE=ON needs libceres";
  ExpectRefused({"sprout", "calibrate", "board"}, "sprout: calibrate: " + calibration);
  ExpectRefused({"sprout", "selfcalibrate"}, "sprout: selfcalibrate: " + calibration);
}
#endif

#ifdef SPROUT_WITHOUT_VIEW
TEST(LeftOutParts, ThePageIsNamedWhenAskedFor) {
  ExpectRefused({"sprout", "view"},
                "sprout: view: built without the page in a browser; -DSPROUT_VIEW=ON");
}
#endif

#ifdef SPROUT_WITHOUT_EVALUATE
TEST(LeftOutParts, EvaluationIsNamedWhenAskedFor) {
  ExpectRefused({"sprout", "evaluate", "scenes"},
                "sprout: evaluate: built without evaluation on scenes with ground truth; "
                "-DSPROUT_EVALUATE=ON");
}
#endif

}  // namespace
}  // namespace sprout
