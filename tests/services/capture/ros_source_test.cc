#include "services/capture/ros2/ros_source.h"

#include <gmock/gmock.h>

#include <limits>

#include "common/scenes/velodyne_scan.h"
#include "tests/common/scenes/kitti_folder.h"
#include "tests/services/capture/ros_recording.h"

namespace sprout::capture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(RosSource, GivesTheFramesAndTheRigThatWereShown) {
  RosRecording file;
  const Rig rig = examples::Rig();
  cv::Mat1f depth_m(rig.tof.height, rig.tof.width, 2.F);
  depth_m(1, 1) = std::numeric_limits<float>::quiet_NaN();
  // The calibration stands behind the first frame.
  for (int i = 0; i < 3; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    file.AddImage("/left/image", utime, cv::Mat(kSize, CV_8UC3, cv::Scalar(i, 2, 3)));
    file.AddImage("/right/image", utime, Grey(i));
    file.AddImage("/tof/image", utime, depth_m);
    if (i > 0) continue;
    file.AddCalibration(rig);
    file.Add("/tof/camera_info", ToRosTofInfo({utime, RosFrames().tof}, rig.tof));
  }
  Told told;
  const auto source = OpenRosSource(file.Source("&depth=/tof/image"), told.Options());
  EXPECT_EQ(RigId(source->rig()), RigId(rig));
  EXPECT_TRUE(source->is_recorded());
  const auto frames = All(*source);
  ASSERT_EQ(frames.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto& frame = frames[static_cast<size_t>(i)];
    EXPECT_EQ(frame.utime, kStart + 100'000 * i);
    EXPECT_EQ(frame.left.at<cv::Vec3b>(1, 1), cv::Vec3b(static_cast<uint8_t>(i), 2, 3));
    EXPECT_EQ(frame.right.at<uint8_t>(1, 1), i);
    ASSERT_EQ(frame.tof.depth_m.size(), depth_m.size());
    EXPECT_EQ(std::memcmp(frame.tof.depth_m.data, depth_m.data, 4 * depth_m.total()), 0);
    EXPECT_EQ(frame.lost, 0);
  }
  EXPECT_THAT(told.lines, ElementsAre());
}

// The same scan as KITTI's file and as a cloud placed by /tf_static.
TEST(RosSource, MakesTheRangeImageOfAScanThatKittiMakes) {
  const scenes::KittiFolder kitti("000007");
  const auto dataset = kitti.Open("/000007");
  const scenes::DatasetFrame expected = dataset->Get(0);
  RosRecording file;
  const RectifiedPair& pair = dataset->rig().pair;
  file.Add("/left/camera_info", ToRosLeftInfo({kStart, "left"}, pair));
  file.Add("/right/camera_info", ToRosRightInfo({kStart, "right"}, pair));
  // Of the scanner (x forward, y left, z up) in the camera (x right, y down, z forward), by two
  // steps, as robots have it.
  RosMessage<RosTransforms> poses;
  const std::span all = ResizeRos(poses->transforms, 2);
  SetRosText(all[0].header.frame_id, "base");
  SetRosText(all[0].child_frame_id, "left");
  all[0].transform.rotation = {-0.5, 0.5, -0.5, 0.5};
  SetRosText(all[1].header.frame_id, "base");
  SetRosText(all[1].child_frame_id, "scanner");
  all[1].transform.rotation = {0, 0, 0, 1};
  file.Add("/tf_static", poses);
  PointCloud cloud;
  for (const Eigen::Vector3d& point :
       scenes::ReadVelodyneScan(kitti.files().File("velodyne/000007.bin"))) {
    const Eigen::Vector3f place = point.cast<float>();
    cloud.points.push_back({.position_m = {place.x(), place.y(), place.z()}, .bgr = {}});
  }
  file.Add("/points", ToRosCloud({kStart, "scanner"}, cloud));
  file.AddImage("/left/image", kStart, expected.left);
  file.AddImage("/right/image", kStart, expected.right);
  Told told;
  const auto source = OpenRosSource(file.Source("&points=/points"), told.Options());
  EXPECT_EQ(RigId(source->rig()), RigId(dataset->rig()));
  const auto frames = All(*source);
  ASSERT_EQ(frames.size(), 1U);
  const cv::Mat1f& depth_m = frames[0].tof.depth_m;
  ASSERT_EQ(depth_m.size(), expected.tof.depth_m.size());
  EXPECT_EQ(cv::countNonZero(depth_m > 0), 2);
  for (int v = 0; v < depth_m.rows; ++v) {
    for (int u = 0; u < depth_m.cols; ++u) {
      const float want = expected.tof.depth_m(v, u);
      EXPECT_TRUE(depth_m(v, u) == want || (std::isnan(want) && std::isnan(depth_m(v, u))))
          << u << ", " << v;
    }
  }
}

TEST(RosSource, GivesFramesOfARecordingThatHasThemTwiceOnce) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 5; ++i) {
    for (const char* topic : {"/left/image", "/right/image"}) {
      for (int times = 0; times < 2; ++times) file.AddImage(topic, kStart + 100'000 * i, Grey(i));
    }
  }
  Told told;
  EXPECT_EQ(All(*OpenRosSource(file.Source(), told.Options())).size(), 5U);
  EXPECT_EQ(told.refused.size(), 10U);
}

TEST(RosSource, CountsImagesWithoutPartner) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 10; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    file.AddImage("/left/image", utime, Grey(i));
    // 19 ms late; the fifth is lost, the eighth too late.
    if (i != 4) file.AddImage("/right/image", utime + (i == 7 ? 21'000 : 19'000), Grey(i));
  }
  Told told;
  const auto source = OpenRosSource(file.Source(), told.Options());
  const auto frames = All(*source);
  ASSERT_EQ(frames.size(), 8U);
  int64_t lost = source->lost_at_end().count;
  for (const scenes::LostFrames& one : told.lost) lost += one.count;
  for (const auto& frame : frames) {
    EXPECT_DOUBLE_EQ(frame.spread_ms, 19);
    EXPECT_EQ(frame.left.at<uint8_t>(0, 0), frame.right.at<uint8_t>(0, 0));
    lost += frame.lost;
  }
  EXPECT_EQ(lost, 3);
}

// Pairs of 10 Hz with these stamps; the frames that became of them, by the grey value of the left
// image.
std::vector<int> FramesOfStamps(const std::vector<std::pair<int64_t, int64_t>>& stamps,
                                Told& told) {
  RosRecording file(examples::Rig());
  for (size_t i = 0; i < stamps.size(); ++i) {
    file.AddImage("/left/image", stamps[i].first, Grey(static_cast<int>(i)));
    file.AddImage("/right/image", stamps[i].second, Grey(static_cast<int>(i)));
  }
  std::vector<int> values;
  for (const auto& frame : All(*OpenRosSource(file.Source(), told.Options()))) {
    EXPECT_EQ(frame.left.at<uint8_t>(0, 0), frame.right.at<uint8_t>(0, 0));
    values.push_back(frame.left.at<uint8_t>(0, 0));
  }
  return values;
}

constexpr int64_t kHour = 3'600'000'000;

TEST(RosSource, StampsThatGoBackAnHourStopNothing) {
  std::vector<std::pair<int64_t, int64_t>> stamps;
  for (int i = 0; i < 8; ++i) {
    const int64_t utime = kStart + 100'000 * i - (i >= 4 ? kHour : 0);
    stamps.emplace_back(utime, utime);
  }
  Told told;
  EXPECT_THAT(FramesOfStamps(stamps, told), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
}

TEST(RosSource, OneStampAnHourAheadCostsTwoFramesAtMost) {
  for (const bool is_left : {true, false}) {
    std::vector<std::pair<int64_t, int64_t>> stamps;
    for (int i = 0; i < 8; ++i) stamps.emplace_back(kStart + 100'000 * i, kStart + 100'000 * i);
    (is_left ? stamps[3].first : stamps[3].second) += kHour;
    Told told;
    const std::vector<int> frames = FramesOfStamps(stamps, told);
    EXPECT_GE(frames.size(), 6U) << is_left;
    EXPECT_EQ(frames.back(), 7) << is_left;
  }
}

// A driver that sets no stamps: its images cannot be joined.
TEST(RosSource, RefusesImagesWithTheStampOfTheOneBefore) {
  RosRecording file(examples::Rig());
  for (const int64_t utime : {int64_t{0}, int64_t{0}, kStart, kStart + 100'000}) {
    file.AddPair(utime, Grey(1));
  }
  Told told;
  EXPECT_EQ(All(*OpenRosSource(file.Source(), told.Options())).size(), 3U);
  ASSERT_EQ(told.refused.size(), 2U);
  EXPECT_THAT(told.refused[0], HasSubstr("/left/image: header.stamp = 0.000000: that of the image "
                                         "before it, none was set; allowed is"));
}

// The clocks of both hosts differ, so there is no pair, and no frame that could report it.
TEST(RosSource, ReportsLossesWhenTheyHappen) {
  std::vector<std::pair<int64_t, int64_t>> stamps;
  for (int i = 0; i < 5; ++i) {
    stamps.emplace_back(kStart + 100'000 * i, kStart + 100'000 * i + kHour);
  }
  Told told;
  EXPECT_THAT(FramesOfStamps(stamps, told), ElementsAre());
  int64_t lost = 0;
  for (const scenes::LostFrames& one : told.lost) lost += one.count;
  EXPECT_GE(lost, 4);
  EXPECT_THAT(told.lost.back().trouble,
              HasSubstr("ms apart or more: allowed is max_spread_ms = 20"));
}

// The line at the end of a recording of three pairs and their range images, with these stamps.
std::string RangeTrouble(int64_t pairs_utime, int64_t range_utime,
                         const std::string& topic = "/depth/image",
                         const cv::Mat& range = cv::Mat1f(kSize, 2)) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 3; ++i) {
    file.AddPair(pairs_utime + 100'000 * i, Grey(i));
    file.AddImage(topic, range_utime + 100'000 * i, range);
  }
  Told told;
  const auto source = OpenRosSource(
      file.Source("&depth=" + topic + "&depth_info=/left/camera_info"), told.Options());
  const auto frames = All(*source);
  EXPECT_EQ(frames.size(), 3U);
  for (const auto& frame : frames) EXPECT_EQ(frame.trouble, "");
  const scenes::LostFrames lost = source->lost_at_end();
  EXPECT_EQ(lost.lacks_most, !lost.trouble.empty());
  return lost.trouble;
}

TEST(RosSource, SaysWhyARangeSensorNeverJoins) {
  EXPECT_EQ(RangeTrouble(kStart, kStart + 20'000), "");
  EXPECT_THAT(RangeTrouble(kStart, kStart + 30'000),
              HasSubstr("0 of 3 range images of /depth/image joined 3 pairs, none the last 3: the "
                        "nearest is +30.0 ms off, max_spread_ms is 20"));
  for (const int64_t off : {kHour, -kHour}) {
    EXPECT_THAT(RangeTrouble(kStart, kStart + off),
                HasSubstr("is that another clock, or are there no stamps?"));
  }
  EXPECT_THAT(RangeTrouble(0, kStart), HasSubstr("or are there no stamps?"));
  EXPECT_THAT(RangeTrouble(kStart, kStart, "/depth/image", cv::Mat1b(kSize, 90)),
              HasSubstr("no range image of /depth/image can be used: encoding = "));
}

TEST(RosSource, PicturesOf16BitsBecomeThoseOf8AsTheyUseThem) {
  RosRecording file(examples::Rig());
  cv::Mat1w deep(kSize);
  for (int u = 0; u < deep.cols; ++u) deep.col(u).setTo(1023 * u / (deep.cols - 1));
  for (int i = 0; i < 2; ++i) {
    for (const char* topic : {"/left/image", "/right/image"}) {
      RosMessage<RosImage> image = ToRosImage({kStart + 100'000 * i, "frame"}, deep);
      SetRosText(image->encoding, "mono16");
      file.Add(topic, image);
    }
    deep /= 2;  // one range for the recording
  }
  Told told;
  const auto frames = All(*OpenRosSource(file.Source(), told.Options()));
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].left.at<uint8_t>(0, deep.cols - 1), 255);
  EXPECT_NEAR(frames[1].right.at<uint8_t>(0, deep.cols - 1), 128, 1);
  EXPECT_THAT(frames[0].trouble, HasSubstr("pixels of 16 bits use 0 to 1023"));
  EXPECT_EQ(frames[1].trouble, "");
  const auto asked = All(*OpenRosSource(file.Source("&bits=12"), told.Options()));
  ASSERT_EQ(asked.size(), 2U);
  EXPECT_NEAR(asked[0].left.at<uint8_t>(0, deep.cols - 1), 64, 1);
}

TEST(RosSource, WhatCameBeforeTheFirstPairIsNotLost) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 4; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    file.AddImage("/left/image", utime, Grey(i));
    if (i >= 2) file.AddImage("/right/image", utime, Grey(i));
  }
  Told told;
  const auto frames = All(*OpenRosSource(file.Source(), told.Options()));
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].lost + frames[1].lost, 0);
  EXPECT_THAT(told.lost, testing::IsEmpty());
}

TEST(RosSource, RefusesWhatItCannotUseAtOnce) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 3; ++i) {
    for (const char* topic : {"/left/image", "/right/image"}) {
      RosMessage<RosImage> image = ToRosImage({kStart + 100'000 * i, "frame"}, Grey(i));
      SetRosText(image->encoding, "nonsense");
      file.Add(topic, image);
    }
  }
  Told told;
  EXPECT_THAT(All(*OpenRosSource(file.Source(), told.Options())), testing::IsEmpty());
  ASSERT_EQ(told.refused.size(), 6U);
  EXPECT_THAT(told.refused[0], testing::StartsWith("/left/image: "));
  EXPECT_THAT(told.refused[0], HasSubstr("nonsense"));
}

TEST(RosSource, SaysWhatIsMissing) {
  const TemporaryDirectory folder;
  {
    RosRecording file(folder / "file");
    file.AddImage("/left/image", kStart, Grey(1));
    file.Finish();
  }
  EXPECT_THAT(Complaint(Source(folder)),
              HasSubstr("no topic /right/image, /left/camera_info, /right/camera_info; topics in " +
                        PathOf(folder) + ": /left/image (sensor_msgs/msg/Image)"));
  {
    RosRecording file(folder / "file");
    file.AddCalibration(examples::Rig());
    file.AddPair(kStart, Grey(1));
    file.Add("/points", ToRosCloud({kStart, "nowhere"}, {}));
    file.Finish();
  }
  EXPECT_THAT(Complaint(Source(folder, "&points=/points")),
              HasSubstr("no transform from the range sensor's frame 'nowhere' to the left camera's "
                        "'sprout_left_optical_frame' on /tf_static /tf /left/tf_static /left/tf; "
                        "transforms there: sprout_left_optical_frame > sprout_right_optical_frame "
                        "sprout_left_optical_frame > sprout_tof_optical_frame; allowed: tf=TOPIC, "
                        "or pose=x,y,z,qx,qy,qz,qw of the range sensor"));
  {
    Rig rig = examples::Rig();
    rig.tof.left_from_tof_translation_m.x() = std::nan("");
    RosRecording file(folder / "file");
    file.AddCalibration(rig);
    file.AddPair(kStart, Grey(1));
    file.Add("/points", ToRosCloud({kStart, "sprout_tof_optical_frame"}, {}));
    file.Finish();
  }
  EXPECT_THAT(Complaint(Source(folder, "&points=/points")),
              HasSubstr("not usable (no rotation, or not finite): sprout_tof_optical_frame; "
                        "allowed: tf=TOPIC"));
  EXPECT_THAT(Complaint(Source(folder, "&points=/lidar&tf=/robot/tf")),
              HasSubstr("no topic /lidar, /robot/tf; topics in"));
  EXPECT_THAT(Complaint("mcap:/nowhere?left=a/i&right=b/i"), HasSubstr("cannot be opened"));
  EXPECT_THAT(Complaint("ros2:left=a"), HasSubstr("no topic of the left or right images"));
  EXPECT_THAT(Complaint("ros2:left=a&right=b&domain=999"),
              HasSubstr("cannot be used: 'domain=999'"));
  EXPECT_THAT(Complaint("ros2:left=a&right=b&points=c&depth=d"), HasSubstr("one range sensor"));
  EXPECT_THAT(Complaint("ros2:left=a&right=b&points=c&pose=1,2"),
              HasSubstr("cannot be used: 'pose=1,2'"));
  EXPECT_THAT(Complaint("ros2:left=a&right=b&points=c&pose=1,2,3,1,1,0,0"),
              HasSubstr("cannot be used: 'pose="));
  EXPECT_THAT(Complaint("ros2:left=a&right=b&left=c"), HasSubstr("left=a and left=c: allowed is"));
  EXPECT_THAT(Complaint("ros2:left=a&right=b&pose=1,2,3"), HasSubstr("neither points nor depth"));
}

TEST(RosSource, RefusesATopicOfAnotherType) {
  RosRecording file(examples::Rig());
  file.AddImage("/left/image", kStart, Grey(1));
  file.Add("/right/image", ToRosCloud({kStart, "x"}, {}));
  EXPECT_THAT(Complaint(file.Source()),
              HasSubstr("/right/image in " + file.path() +
                        " has type sensor_msgs/msg/PointCloud2 in encoding cdr; allowed is "
                        "sensor_msgs/msg/Image and sensor_msgs/msg/CompressedImage in cdr"));
}

TEST(RosSource, BeginsAFileAgain) {
  RosRecording file(examples::Rig());
  file.AddPair(kStart, Grey(1));
  Told told;
  const auto source = OpenRosSource(file.Source(), told.Options(/*loop=*/true));
  const std::stop_source never;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(source->Next(never.get_token()).has_value()) << i;
}

TEST(RosSettings, OneTopicIsOfOneCamera) {
  const auto error = [](const std::string& topics) {
    try {
      ParseRosSource("ros2:" + topics);
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(error("left=/a&right=a"), HasSubstr(": left and right are both /a; allowed: "));
  EXPECT_THAT(error("left=/l/i&right=/r/i&depth=/r/i"), HasSubstr(": right and depth are both /r"));
  EXPECT_THAT(error("left=/s/l&right=/s/r"),
              HasSubstr(": left_info and right_info are both /s/camera_info; "));
  EXPECT_EQ(error("left=/s/l&right=/s/r&right_info=/s/r_info"), "");
  EXPECT_EQ(error("left=/s/l&right=/s/r&rig=rig.textproto"), "");
}

TEST(RosSettings, ACameraInfoStandsBesideItsImages) {
  const RosSettings settings =
      ParseRosSource("ros2:left=stereo/left/image_raw/compressed&right=/stereo/right/image_rect");
  EXPECT_EQ(settings.left, "/stereo/left/image_raw/compressed");
  EXPECT_EQ(settings.left_info, "/stereo/left/camera_info");
  EXPECT_EQ(settings.right_info, "/stereo/right/camera_info");
}

}  // namespace
}  // namespace sprout::capture
