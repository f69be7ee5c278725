// From a camera's node of ROS 2 through every stage to a viewer's node, both on Fast DDS.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <map>
#include <sstream>

#include "tests/system/ros2_fast_peers.h"
#include "tests/system/ros2_feed.h"

namespace sprout {
namespace {

// By hand: SPROUT_ROS2_LIVE="1920x1080 10 fast", and SPROUT_ROS2_SECONDS.
struct Stream {
  std::string size = "640x480";
  std::string hz = "5";
  std::string preset = "fast";
};

Stream StreamOfEnvironment() {
  Stream stream;
  const char* const text = std::getenv("SPROUT_ROS2_LIVE");
  if (text != nullptr) std::istringstream(text) >> stream.size >> stream.hz >> stream.preset;
  return stream;
}

TEST(Ros2Live, DepthOfACameraReachesTheViewerAndWhatDoesNotIsCounted) {
  const Stream stream = StreamOfEnvironment();
  FedGraph graph;
  for (const char* stage : {"refine", "prior", "grow", "depth"}) {
    graph.Start(stage, {"--config", stream.preset});
  }
  graph.Start("ros2");
  Process& capture = graph.StartOnly("capture", Source("&points=/cam/points&pose=0,0,0,0,0,0,1"));
  const std::string left = "/sprout/left/image_rect";
  const std::string depth = "/sprout/depth/image_rect";
  const auto viewer = Peer({"hear", "0", "1000", left + "=image", depth + "=image"});
  const auto camera =
      Peer(Camera(stream.size, std::to_string(Seconds()), {"points", "texture"}, stream.hz));
  ASSERT_EQ(End(*camera), 0) << camera->Output();
  const StageStatus of_capture = StatusOf(graph);
  const Heard heard = EndOf(*viewer, depth);
  const Heard heard_left = HeardOf(viewer->Output(), left);
  // The frames that each stage counts as not passed on.
  long counted = 0;
  std::map<std::string, StageStatus> statuses;
  graph.Look([&](Graph& g) { statuses = g.statuses; });
  std::cout << camera->Output() << "captured " << of_capture.frames_out << "\n";
  for (const auto& [stage, status] : statuses) {
    std::cout << stage << ": " << status.frames_out << " out, " << status.frames_skipped
              << " skipped, " << status.frames_incomplete << " incomplete, " << status.sequence_gaps
              << " gaps, " << status.frames_failed << " failed\n";
    EXPECT_EQ(status.frames_failed, 0) << stage << ": " << status.last_error;
    if (stage != "capture") {
      counted += status.frames_skipped + status.frames_incomplete + status.sequence_gaps;
    }
  }
  std::cout << heard_left.line << "\n" << heard.line << "\n";
  EXPECT_GT(heard.messages, 0) << capture.Output();
  // The viewer may know the topic a little later than frames begin.
  EXPECT_GE(heard.messages + counted, of_capture.frames_out - 3);
}

}  // namespace
}  // namespace sprout
