// Recordings as drivers and recorders of other projects make them.
#include <gmock/gmock.h>
#include <zstd.h>

#include <filesystem>

#include "tests/services/capture/ros_recording.h"

namespace sprout::capture {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr uint64_t kFrameNs = 100'000'000;

// What is read of a recording with one pair and a calibration that `add` may change or add to.
struct Opened {
  std::unique_ptr<scenes::FrameSource> source;
  std::vector<scenes::CapturedFrame> frames;
  std::vector<std::string> told;
};

Opened OpenAll(const std::string& source) {
  Told told;
  Opened opened{.source = OpenRosSource(source, told.Options()), .frames = {}, .told = {}};
  opened.frames = All(*opened.source);
  opened.told = std::move(told.lines);
  return opened;
}

void AddPairs(RosRecording& file, int count) {
  for (int i = 0; i < count; ++i) {
    const auto time = static_cast<uint64_t>(i) * kFrameNs;
    file.AddPair(kStart + 100'000 * i, Grey(i), time);
  }
}

// A tool that splits or merges bags may write all of one topic before the next.
TEST(RosForeign, FramesAreWholeThoughTopicsStandBehindEachOther) {
  RosRecording file(/*chunk_bytes=*/1);
  constexpr int kCount = 20;
  for (const char* topic : {"/right/image", "/left/image"}) {
    for (int i = 0; i < kCount; ++i) {
      file.AddImage(topic, kStart + 100'000 * i, Grey(i), static_cast<uint64_t>(i) * kFrameNs);
    }
  }
  file.AddCalibration(examples::Rig());
  const Opened opened = OpenAll(file.Source());
  ASSERT_EQ(opened.frames.size(), static_cast<size_t>(kCount));
  for (const auto& frame : opened.frames) {
    EXPECT_EQ(frame.lost, 0);
    EXPECT_EQ(frame.left.at<uint8_t>(0, 0), frame.right.at<uint8_t>(0, 0));
  }
}

TEST(RosForeign, PartsOfABagAreOneRecording) {
  const TemporaryDirectory folder;
  std::filesystem::create_directory(folder / "bag");
  const std::string first = folder / "bag/bag_0.mcap";
  const std::string second = folder / "bag/bag_1.mcap";
  {
    RosRecording file(first);
    AddPairs(file, 3);
    file.Finish();
    // Only the second one has the calibration.
    RosRecording next(second);
    for (int i = 3; i < 5; ++i) {
      const auto time = static_cast<uint64_t>(i) * kFrameNs;
      next.AddImage("/right/image", kStart + 100'000 * i, Grey(i), time);
      next.AddImage("/left/image", kStart + 100'000 * i, Grey(i), time);
    }
    next.AddCalibration(examples::Rig());
    next.Finish();
  }
  const std::string options = "?left=/left/image&right=/right/image";
  for (const std::string& bag : {std::string(folder / "bag"), second + "," + first}) {
    const Opened opened = OpenAll("mcap:" + bag + options);
    ASSERT_EQ(opened.frames.size(), 5U) << bag;
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(opened.frames[static_cast<size_t>(i)].utime, kStart + 100'000 * i);
    }
    EXPECT_THAT(opened.told, IsEmpty());
  }
}

TEST(RosForeign, MessagesMayBePackedOneByOne) {
  RosRecording file;
  file.Change([](std::vector<uint8_t>& cdr) {
    std::vector<uint8_t> packed(ZSTD_compressBound(cdr.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), cdr.data(), cdr.size(), 1));
    cdr = std::move(packed);
  });
  file.AddCalibration(examples::Rig());
  AddPairs(file, 3);
  file.Change([](std::vector<uint8_t>& cdr) { cdr = {0x28, 0xb5, 0x2f, 0xfd, 1, 2, 3}; });
  file.AddImage("/left/image", kStart + 300'000, Grey(3), 3 * kFrameNs);
  const Opened opened = OpenAll(file.Source());
  EXPECT_EQ(opened.frames.size(), 3U);
  EXPECT_THAT(opened.told, testing::ElementsAre(HasSubstr("/left/image: message: ")));
}

// A bag of ROS 1 that a tool has wrapped in MCAP has every topic, but no message can be read.
TEST(RosForeign, RosOnesEncodingIsCalledByItsName) {
  const TemporaryDirectory folder;
  McapWriter writer(folder / "file", {.profile = "ros1"});
  const uint16_t schema = writer.AddSchema("sensor_msgs/Image", "ros1msg", "uint32 seq");
  for (const char* topic :
       {"/left/image", "/right/image", "/left/camera_info", "/right/camera_info"}) {
    writer.Write(writer.AddChannel(schema, topic, "ros1"), 0, 0, std::vector<uint8_t>(8));
  }
  ASSERT_TRUE(writer.Commit());
  EXPECT_THAT(Complaint(Source(folder)),
              HasSubstr("/left/image is in " + PathOf(folder) +
                        ", but in ROS 1's encoding: make a bag of ROS 2 of the ROS 1 bag"));
}

// A missing topic may be in the part that was cut off.
TEST(RosForeign, ATopicMayBeMissingBecauseTheFileIsDamaged) {
  RosRecording file(/*chunk_bytes=*/1);
  file.AddCalibration(examples::Rig());
  file.AddImage("/left/image", kStart, Grey(1));
  file.AddImage("/right/image", kStart, Grey(1));
  file.Finish();
  std::filesystem::resize_file(file.path(), std::filesystem::file_size(file.path()) / 8);
  const std::string complaint =
      Complaint("mcap:" + file.path() + "?left=/l/image_raw&right=/r/image_raw&depth=/l/image");
  EXPECT_THAT(complaint, HasSubstr("/r/camera_info, /l/image; topics in"));
  EXPECT_THAT(complaint, HasSubstr("; the file is damaged: byte "));
}

TEST(RosForeign, NamesNeedNoSlashInFront) {
  RosRecording file;
  file.AddImage("left/image", kStart, Grey(1));
  file.AddImage("right/image", kStart, Grey(1));
  file.AddCalibration(examples::Rig());
  file.Finish();
  const std::string bag = "mcap:" + file.path();
  EXPECT_EQ(OpenAll(bag + "?left=left/image&right=right/image").frames.size(), 1U);
  EXPECT_EQ(OpenAll(bag + "?left=/left/image&right=/right/image").frames.size(), 1U);
}

TEST(RosForeign, TransformsMayBeOnOtherTopics) {
  const Rig rig = examples::Rig();
  for (const char* robot : {"", "/robot1", "/left"}) {
    for (const char* topic : {"/tf_static", "/tf"}) {
      RosRecording file;
      AddPairs(file, 1);
      file.AddTof();
      file.AddPairInfo(rig);
      const std::string name = std::string(robot) + topic;
      file.Add(name, ToRosTransforms(kStart, rig, {}));
      const Opened opened = OpenAll(file.Source("&depth=/tof/image"));
      EXPECT_EQ(RigId(opened.source->rig()), RigId(rig)) << name;
      // Transforms of another namespace are used, with a note.
      EXPECT_EQ(opened.told.size(), std::string(robot) == "/robot1" ? 1U : 0U) << name;
      const Opened asked = OpenAll(file.Source("&depth=/tof/image&tf=" + name));
      EXPECT_EQ(RigId(asked.source->rig()), RigId(rig)) << name;
      EXPECT_THAT(asked.told, IsEmpty());
    }
  }
}

TEST(RosForeign, FramesMayHaveASlashInFront) {
  const Rig rig = examples::Rig();
  const RosFrames plain;
  const RosFrames slashed{
      .left = "/" + plain.left, .right = "/" + plain.right, .tof = "/" + plain.tof};
  for (const bool is_slashed : {false, true}) {  // the transforms; the messages are the other way
    const RosFrames& of_messages = is_slashed ? plain : slashed;
    RosRecording file;
    AddPairs(file, 1);
    file.AddTof(of_messages.tof);
    file.AddPairInfo(rig, kStart, of_messages);
    file.Add("/tf_static", ToRosTransforms(kStart, rig, is_slashed ? slashed : plain));
    const Opened opened = OpenAll(file.Source("&depth=/tof/image"));
    EXPECT_EQ(RigId(opened.source->rig()), RigId(rig));
    EXPECT_THAT(opened.told, IsEmpty());
  }
}

TEST(RosForeign, AFrameOfSeveralParentsIsNamed) {
  const Rig rig = examples::Rig();
  RosRecording file;
  AddPairs(file, 1);
  file.AddTof();
  file.AddPairInfo(rig);
  RosMessage<RosTransforms> both;
  const std::span two = ResizeRos(both->transforms, 2);
  for (size_t i = 0; i < 2; ++i) {
    SetRosText(two[i].header.frame_id, i == 0 ? RosFrames().left : "map");
    SetRosText(two[i].child_frame_id, RosFrames().tof);
    two[i].transform.rotation.w = 1;
  }
  file.Add("/tf_static", both);
  EXPECT_THAT(Complaint(file.Source("&depth=/tof/image")),
              HasSubstr("transforms there: map > sprout_tof_optical_frame; of several parents the "
                        "newest counts: sprout_tof_optical_frame; allowed: tf=TOPIC"));
}

// Two robots have transforms, and it is not known of which the cameras are.
TEST(RosForeign, TransformsOfSeveralRobotsAreNotGuessed) {
  const Rig rig = examples::Rig();
  RosRecording file;
  AddPairs(file, 1);
  file.AddTof();
  file.AddCalibration(rig, "/robot1");
  file.Add("/robot2/tf_static", ToRosTransforms(kStart, rig, {}));
  EXPECT_THAT(Complaint(file.Source("&depth=/tof/image")), HasSubstr("no transform"));
  const Opened opened = OpenAll(file.Source("&depth=/tof/image&tf=/robot2/tf_static"));
  EXPECT_EQ(RigId(opened.source->rig()), RigId(rig));
}

TEST(RosForeign, ThePoseMayBeGiven) {
  const Rig rig = examples::Rig();
  RosRecording file;
  AddPairs(file, 1);
  file.AddTof("nowhere");
  file.AddCalibration(rig);
  const Opened opened = OpenAll(file.Source("&depth=/tof/image&pose=0.1,-0.2,0.3,0,0,1,0"));
  const TofCamera& tof = opened.source->rig().tof;
  EXPECT_EQ(tof.left_from_tof_translation_m, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_EQ(tof.left_from_tof_rotation.z(), 1);
  const Opened shifted = OpenAll(file.Source("&depth=/tof/image&pose=0.1,0,0"));
  EXPECT_EQ(shifted.source->rig().tof.left_from_tof_rotation.w(), 1);
}

// The line at the end of a recording of three pairs and clouds of these points.
std::string CloudTrouble(const std::vector<Eigen::Vector3f>& places) {
  RosRecording file(examples::Rig());
  PointCloud cloud;
  for (const Eigen::Vector3f& place : places) {
    cloud.points.push_back({.position_m = {place.x(), place.y(), place.z()}, .bgr = {}});
  }
  for (int i = 0; i < 3; ++i) {
    file.AddPair(kStart + 100'000 * i, Grey(i));
    file.Add("/points", ToRosCloud({kStart + 100'000 * i, RosFrames().left}, cloud));
  }
  Told told;
  const auto source = OpenRosSource(file.Source("&points=/points"), told.Options());
  EXPECT_EQ(All(*source).size(), 3U);
  const scenes::LostFrames lost = source->lost_at_end();
  EXPECT_EQ(lost.lacks_most, !lost.trouble.empty());
  return lost.trouble;
}

TEST(RosForeign, SaysThatNoPointOfACloudIsInTheImage) {
  EXPECT_EQ(CloudTrouble({{0, 0, 2}, {0, 0, -2}}), "");
  EXPECT_THAT(CloudTrouble({{2, 0, 0}, {3, 0, 0}}),  // x ahead, as in a body's frame
              StartsWith("none of 2 points of /points is in the left image; allowed are m along "
                         "the axes of their frame 'sprout_left_optical_frame'"));
  EXPECT_THAT(CloudTrouble({{0, 0, 2000}, {0, 0, -2}}),
              HasSubstr("image, 1 are not finite or beyond 1000 m (in mm?); allowed are m"));
  EXPECT_EQ(CloudTrouble({}), "the 3 clouds of /points have no points");
}

// Raw images, given in the place of rectified ones, by drivers that name them so.
TEST(RosForeign, ImagesThatTheirCameraInfoWouldRectifyAreNamed) {
  for (const bool says_rect : {false, true}) {
    const std::string name = says_rect ? "image_rect_color" : "image_raw";
    RosRecording file;
    const RectifiedPair pair = examples::Rig().pair;
    auto left = ToRosLeftInfo({kStart, "left"}, pair);
    ResizeRos(left->d, 5)[0] = -0.3;  // k1
    file.Add("/left/camera_info", left);
    file.Add("/right/camera_info", ToRosRightInfo({kStart, "right"}, pair));
    file.AddImage("/left/" + name, kStart, Grey(1));
    file.AddImage("/right/" + name, kStart, Grey(1));
    file.Finish();
    const auto opened =
        OpenAll("mcap:" + file.path() + "?left=/left/" + name + "&right=/right/" + name);
    EXPECT_EQ(opened.frames.size(), 1U);
    EXPECT_EQ(opened.source->lost_at_end().lacks_most, !says_rect);
    if (says_rect) {
      EXPECT_THAT(opened.told, testing::IsEmpty());
    } else {
      EXPECT_THAT(opened.told,
                  testing::ElementsAre(HasSubstr("images of /left/image_raw and /right/image_raw "
                                                 "are taken for rectified, but D and R of")));
    }
  }
}

// A range image that was registered to a camera of the pair has its camera_info, and stands there.
TEST(RosForeign, ARangeImageMayHaveTheCameraInfoOfAnImage) {
  const RectifiedPair pair = examples::Rig().pair;
  RosRecording file;
  AddPairs(file, 1);
  cv::Mat1w millimetres(kSize, uint16_t{1500});
  file.AddImage("/left/depth", kStart, millimetres);
  file.AddImage("/depth/image", kStart, millimetres);
  // K and D are those of the raw image.
  RosMessage<RosCameraInfo> left = ToRosLeftInfo({kStart, "left"}, pair);
  left->k[0] = 321;
  left->d._buffer[0] = 0.1;
  file.Add("/left/camera_info", left);
  file.Add("/right/camera_info", ToRosRightInfo({kStart, "right"}, pair));
  for (const char* options :
       {"&depth=/left/depth", "&depth=/depth/image&depth_info=/left/camera_info",
        "&depth=/depth/image&depth_info=/right/camera_info"}) {
    const Opened opened = OpenAll(file.Source(options));
    const TofCamera& tof = opened.source->rig().tof;
    const bool is_right = std::string(options).ends_with("/right/camera_info");
    EXPECT_EQ(tof.fx, pair.focal_px) << options;
    EXPECT_EQ(tof.cx, is_right ? pair.cx_right : pair.cx) << options;
    EXPECT_EQ(tof.distortion, TofCamera().distortion) << options;
    EXPECT_EQ(tof.left_from_tof_translation_m,
              Eigen::Vector3d(is_right ? pair.baseline_m : 0, 0, 0))
        << options;
    ASSERT_EQ(opened.frames.size(), 1U);
    EXPECT_FLOAT_EQ(opened.frames[0].tof.depth_m(7, 7), 1.5F);
  }
}

// The name of a range image's topic says whether P, or K and D describe it.
TEST(RosForeign, ARectifiedRangeImageIsThatOfP) {
  const Rig rig = examples::Rig();
  RosRecording file;
  AddPairs(file, 1);
  file.AddImage("/tof/image_rect_raw", kStart, examples::Tof(false).depth_m);
  file.AddImage("/tof/image_raw", kStart, examples::Tof(false).depth_m);
  RosMessage<RosCameraInfo> info = ToRosTofInfo({kStart, RosFrames().tof}, rig.tof);
  info->p[0] = 150;
  SetRosText(info->distortion_model, "equidistant");
  file.Add("/tof/camera_info", info);
  file.AddCalibration(rig);
  const Opened opened = OpenAll(file.Source("&depth=/tof/image_rect_raw"));
  EXPECT_EQ(opened.source->rig().tof.fx, 150);
  EXPECT_EQ(opened.source->rig().tof.distortion, TofCamera().distortion);
  EXPECT_THAT(Complaint(file.Source("&depth=/tof/image_raw")),
              HasSubstr("/tof/camera_info: d = 5: allowed is 4 coefficients of equidistant"));
}

// Drivers of one camera leave P empty.
TEST(RosForeign, ARawRangeImageNeedsNoP) {
  const Rig rig = examples::Rig();
  RosRecording file;
  AddPairs(file, 1);
  for (const char* topic : {"/tof/image_raw", "/tof/image_rect_raw"}) {
    file.AddImage(topic, kStart, cv::Mat1f(rig.tof.height, rig.tof.width, 2.F));
  }
  RosMessage<RosCameraInfo> info = ToRosTofInfo({kStart, RosFrames().tof}, rig.tof);
  std::fill(std::begin(info->p), std::end(info->p), 0.0);
  file.Add("/tof/camera_info", info);
  file.AddCalibration(rig);
  const Opened opened = OpenAll(file.Source("&depth=/tof/image_raw"));
  EXPECT_EQ(opened.source->rig().tof.fx, rig.tof.fx);
  ASSERT_EQ(opened.frames.size(), 1U);
  EXPECT_FALSE(opened.frames[0].tof.depth_m.empty());
  EXPECT_THAT(Complaint(file.Source("&depth=/tof/image_rect_raw")), HasSubstr("p[0] = 0"));
}

TEST(RosForeign, ImagesAndRangesMayBeCompressed) {
  const Rig rig = examples::Rig();
  RosRecording file(rig);
  file.AddPng("/left/image/compressed", "PNG", Grey(5));
  file.AddPng("/right/image/compressed", "", Grey(5));
  const cv::Mat1w range(rig.tof.height, rig.tof.width, uint16_t{2500});
  file.AddPng("/tof/image/compressedDepth", "16UC1; compressedDepth", range, 12);
  file.Add("/tof/camera_info", ToRosTofInfo({kStart, RosFrames().tof}, rig.tof));
  file.Finish();
  const Opened opened = OpenAll("mcap:" + file.path() +
                                "?left=/left/image/compressed&right=/right/image/compressed"
                                "&depth=/tof/image/compressedDepth");
  ASSERT_EQ(opened.frames.size(), 1U);
  EXPECT_EQ(opened.frames[0].left.at<uint8_t>(9, 9), 5);
  EXPECT_FLOAT_EQ(opened.frames[0].tof.depth_m(1, 1), 2.5F);
}

// Images for a calibration have none yet.
TEST(RosForeign, RawImagesNeedNoCalibration) {
  RosRecording file;
  for (const char* topic : {"/left/image/compressed", "/right/image/compressed"}) {
    file.AddPng(topic, "", Grey(5));
  }
  file.Finish();
  Told told;
  const auto raw = OpenRawRosSource(
      "mcap:" + file.path() + "?left=/left/image/compressed&right=/right/image/compressed",
      told.Options());
  const std::stop_source never;
  const auto frame = raw->Next(never.get_token());
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->left.size(), kSize);
}

}  // namespace
}  // namespace sprout::capture
