#include <gmock/gmock.h>

#include <chrono>
#include <thread>
#include <vector>

#include "common/ros/ros_node.h"
#include "services/capture/ros2/ros_source.h"
#include "tests/services/capture/ros_recording.h"

namespace sprout::capture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Frames of a rig, then those of another one, whose CameraInfo comes before its images.
struct TwoRigs {
  explicit TwoRigs(const Rig& second_rig) : second(second_rig) {}
  Rig first = examples::Rig();
  Rig second;

  std::vector<scenes::CapturedFrame> Frames(Told& told) const {
    RosRecording file;
    for (int i = 0; i < 4; ++i) {
      const Rig& rig = i < 2 ? first : second;
      const int64_t utime = kStart + 100'000 * i;
      file.AddPairInfo(rig, utime);
      const cv::Mat1b image(rig.pair.size(), static_cast<uint8_t>(i));
      file.AddPair(utime, image);
    }
    const auto source = OpenRosSource(file.Source(), told.Options());
    EXPECT_EQ(source->rig().pair.focal_px, first.pair.focal_px);
    return All(*source);
  }
};

TEST(RosSource, ANewCameraInfoIsANewRigFromItsFrameOn) {
  TwoRigs rigs(examples::Rig());
  rigs.second.pair.focal_px *= 2;
  Told told;
  const auto frames = rigs.Frames(told);
  ASSERT_EQ(frames.size(), 4U);
  for (const size_t i : {0, 1, 3}) EXPECT_FALSE(frames[i].new_rig) << i;
  ASSERT_TRUE(frames[2].new_rig);
  EXPECT_EQ(frames[2].new_rig->rig.pair.focal_px, rigs.second.pair.focal_px);
  EXPECT_EQ(frames[2].new_rig->rig_id, RigId(frames[2].new_rig->rig));
  ASSERT_EQ(told.lines.size(), 1U);
  EXPECT_THAT(told.lines[0], HasSubstr("the calibration changed"));
}

TEST(RosSource, ANewRigMayHaveAnotherSize) {
  TwoRigs rigs(examples::Rig());
  rigs.second.pair.width /= 2;
  rigs.second.pair.height /= 2;
  rigs.second.pair.cx /= 2;
  rigs.second.pair.cx_right /= 2;
  rigs.second.pair.cy /= 2;
  Told told;
  const auto frames = rigs.Frames(told);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[1].left.size(), rigs.first.pair.size());
  EXPECT_EQ(frames[2].left.size(), rigs.second.pair.size());
  EXPECT_TRUE(frames[2].new_rig);
}

TEST(RosSource, FramesWithoutACalibrationAreLost) {
  const Rig rig = examples::Rig();
  RosRecording file(rig);
  for (int i = 0; i < 4; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    RosMessage<RosCameraInfo> info = ToRosLeftInfo({utime, RosFrames().left}, rig.pair);
    if (i == 1) info->p[0] = info->k[0] = 0;  // not calibrated
    file.Add("/left/camera_info", info);
    file.AddPair(utime, Grey(i));
  }
  Told told;
  EXPECT_EQ(All(*OpenRosSource(file.Source(), told.Options())).size(), 3U);
  ASSERT_EQ(told.lost.size(), 1U);
  EXPECT_EQ(told.lost[0].count, 1);
  EXPECT_THAT(told.refused, ElementsAre(HasSubstr("/left/camera_info")));
}

TEST(RosSource, SaysAtTheEndThatTheCalibrationOfOneSideChanged) {
  const Rig rig = examples::Rig();
  for (const int changed : {2, 3}) {  // of four: of the last frame alone the other may still come
    RosRecording file(rig);
    for (int i = 0; i < 4; ++i) {
      const int64_t utime = kStart + 100'000 * i;
      RosMessage<RosCameraInfo> info = ToRosRightInfo({utime, RosFrames().right}, rig.pair);
      if (i >= changed) info->p[0] = info->p[5] = 1.01 * info->p[0];
      file.Add("/right/camera_info", info);
      file.AddPair(utime, Grey(i));
    }
    const auto source = OpenRosSource(file.Source(), Told().Options());
    EXPECT_EQ(All(*source).size(), static_cast<size_t>(changed));
    EXPECT_EQ(source->lost_at_end().lacks_most, changed == 2);
    if (changed == 2) {
      EXPECT_THAT(source->lost_at_end().trouble,
                  HasSubstr("the last 2 pairs fit no calibration: right p[0] = "));
    }
  }
}

TEST(RosSource, RefusesAnImageOfAnotherSizeAndGoesOn) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 3; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    file.AddImage("/left/image", utime, i == 1 ? cv::Mat1b(2, 2, uint8_t{1}) : Grey(i));
    file.AddImage("/right/image", utime, Grey(i));
  }
  Told told;
  const auto frames = All(*OpenRosSource(file.Source(), told.Options()));
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_THAT(told.refused,
              ElementsAre("/left/image: image of 2x2: allowed is the calibrated size 640x480"));
  ASSERT_EQ(told.lost.size(), 1U);
  EXPECT_EQ(told.lost[0].count, 1);  // the right one
  EXPECT_EQ(told.lost[0].trouble, "image of 2x2: allowed is the calibrated size 640x480");
}

TEST(RosSource, RefusesARangeImageOfAnotherSizeAndGoesOnWithoutIt) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 2; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    file.AddPair(utime, Grey(i));
    file.AddImage("/depth/image", utime, i == 0 ? cv::Mat1f(4, 3, 2.F) : cv::Mat1f(kSize, 2.F));
  }
  Told told;
  const auto frames = All(*OpenRosSource(
      file.Source("&depth=/depth/image&depth_info=/left/camera_info"), told.Options()));
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_TRUE(frames[0].tof.depth_m.empty());
  EXPECT_EQ(frames[1].tof.depth_m.size(), kSize);
  EXPECT_THAT(told.refused, ElementsAre("/depth/image: range image of 3x4: allowed is the "
                                        "calibrated size 640x480"));
}

// Another lidar takes the place of the first one, then one that no transform places.
TEST(RosSource, TellsOnceThatARangeImageIsOfAnotherFrameThanItsCameraInfo) {
  const Rig rig = examples::Rig();
  RosRecording file(rig);
  file.Add("/tof/camera_info", ToRosTofInfo({kStart, RosFrames().tof}, rig.tof));
  const cv::Mat1f depth_m(rig.tof.height, rig.tof.width, 2.F);
  for (int i = 0; i < 3; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    file.AddPair(utime, Grey(i));
    file.Add("/tof/image", ToRosImage({utime, "tof_link"}, depth_m));
  }
  Told told;
  const auto source = OpenRosSource(file.Source("&depth=/tof/image"), told.Options());
  EXPECT_EQ(All(*source).size(), 3U);
  EXPECT_THAT(told.lines, ElementsAre("range images of /tof/image are of frame 'tof_link', and "
                                      "their CameraInfo /tof/camera_info of "
                                      "'sprout_tof_optical_frame', whose place is taken"));
}

// A source that waits for the calibration reports at once why it has none.
TEST(RosSource, TellsALiveCameraInfoThatCannotBeUsedBeforeTheWaitIsOver) {
  RosNode camera({.domain = 77, .name = "camera"});
  const RosNode::Handle writer = camera.AddWriter("/left/camera_info", RosTypeOf<RosCameraInfo>(),
                                                  {.reliable = true, .latched = true, .depth = 1});
  camera.Announce();
  RosMessage<RosCameraInfo> info = ToRosLeftInfo({kStart, "left"}, examples::Rig().pair);
  info->width = 0;
  ASSERT_TRUE(camera.Write(writer, info));
  Told told;
  std::stop_source stop;
  RosSourceOptions options = told.Options();
  options.stop = stop.get_token();
  options.reports.refused = [&](const std::string& topic, const std::string& why) {
    told.refused.push_back(topic + ": " + why);
    stop.request_stop();
  };
  EXPECT_EQ(OpenRosSource("ros2:left=/left/image&right=/right/image&domain=77", options), nullptr);
  EXPECT_THAT(told.refused, testing::ElementsAre(testing::HasSubstr("/left/camera_info: ")));
}

// In DDS newer messages replace those that were not taken, without a count.
TEST(RosSource, CountsLiveMessagesThatAreNotTakenInTime) {
  RosNode camera({.domain = 78, .name = "camera"});
  const RosNode::Handle left = camera.AddWriter("/left/image", RosTypeOf<RosImage>(), {});
  const RosNode::Handle right = camera.AddWriter("/right/image", RosTypeOf<RosImage>(), {});
  camera.Announce();
  Told told;
  const auto source =
      OpenRawRosSource("ros2:left=/left/image&right=/right/image&domain=78", told.Options());
  const auto is_heard = [&] { return camera.HasReaders(left) && camera.HasReaders(right); };
  while (!is_heard()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const std::stop_source never;
  int64_t utime = kStart;
  const auto send = [&](int pairs) {
    for (int i = 0; i < pairs; ++i) {
      utime += 100'000;
      ASSERT_TRUE(camera.Write(left, ToRosImage({utime, "left"}, Grey(1))));
      ASSERT_TRUE(camera.Write(right, ToRosImage({utime, "right"}, Grey(1))));
    }
  };
  send(1);
  ASSERT_TRUE(source->Next(never.get_token()));
  EXPECT_THAT(told.refused, ElementsAre());
  send(20);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(source->Next(never.get_token()));
  EXPECT_THAT(told.refused, testing::SizeIs(2 * 12));
  EXPECT_THAT(told.refused, testing::Each(HasSubstr("/image: came faster than")));
}

TEST(RosSource, PointsStandWhereTheirOwnFrameDoes) {
  const Rig rig = examples::Rig();
  RosRecording file(rig);
  RosMessage<RosTransforms> poses;
  const std::span all = ResizeRos(poses->transforms, 2);
  for (const size_t i : {0, 1}) {
    SetRosText(all[i].header.frame_id, RosFrames().left);
    SetRosText(all[i].child_frame_id, i == 0 ? "one" : "other");
    all[i].transform.translation.x = 0.5 * static_cast<double>(i);
    all[i].transform.rotation.w = 1;
  }
  file.Add("/tf_static", poses);
  const PointCloud cloud{.points = {{.position_m = {0, 0, 2}, .bgr = {}}}};
  const char* const kFrames[] = {"one", "one", "other", "nowhere"};
  for (int i = 0; i < 4; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    file.Add("/points", ToRosCloud({utime, kFrames[i]}, cloud));
    file.AddPair(utime, Grey(i));
  }
  Told told;
  const auto frames = All(*OpenRosSource(file.Source("&points=/points"), told.Options()));
  ASSERT_EQ(frames.size(), 3U);
  const auto column = [&](size_t i) {
    double largest = 0;
    cv::Point at;
    cv::minMaxLoc(cv::Mat1b(frames[i].tof.depth_m > 0), nullptr, &largest, nullptr, &at);
    return largest > 0 ? at.x : -1;
  };
  EXPECT_EQ(column(1), column(0));
  EXPECT_EQ(column(2), column(0) + static_cast<int>(rig.pair.focal_px * 0.5 / 2));
  ASSERT_EQ(told.lost.size(), 1U);
  EXPECT_THAT(told.lost[0].trouble,
              HasSubstr("no transform from the range sensor's frame 'nowhere' to the left"));
}

}  // namespace
}  // namespace sprout::capture
