#include <gmock/gmock.h>

#include "tests/services/capture/ros_recording.h"

namespace sprout::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// The line at the end of a recording of as many left and right images, one behind the other.
std::string LossOf(int count, int64_t stamp_step, uint64_t right_later_ns) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < count; ++i) {
    const uint64_t time_ns = 100'000'000ULL * static_cast<uint64_t>(i);
    file.AddImage("/left/image", kStart + stamp_step * i, Grey(i), time_ns);
    file.AddImage("/right/image", kStart + stamp_step * i, Grey(i), time_ns + right_later_ns);
  }
  Told told;
  const auto source = OpenRosSource(file.Source(), told.Options());
  All(*source);
  const scenes::LostFrames lost = source->lost_at_end();
  return lost.lacks_most ? lost.trouble : "";
}

TEST(RosLosses, SaysWhyMostOfARecordingBecameNoFrame) {
  EXPECT_EQ(LossOf(20, 100'000, 0), "");
  EXPECT_THAT(LossOf(20, 100'000, 1'500'000'000),
              HasSubstr("pairs became frames: left and right ones of one time stand too far apart "
                        "by the log times of the recording"));
  EXPECT_THAT(LossOf(3, 0, 0), StartsWith("of 3 left and 3 right images 1 pairs became frames: "
                                          "header.stamp = "));

  RosRecording half(examples::Rig());
  half.AddImage("/left/image", kStart, Grey(0));
  half.AddTopic("/right/image", RosTypeOf<RosImage>());
  Told told;
  const auto source = OpenRosSource(half.Source(), told.Options());
  EXPECT_EQ(All(*source).size(), 0U);
  EXPECT_EQ(source->lost_at_end().trouble, "no message came on /right/image");
}

TEST(RosLosses, SaysThatImagesHaveNoStampsBesideAClockOfPoints) {
  RosRecording file(examples::Rig());
  for (int i = 0; i < 3; ++i) {
    file.AddPair(0, Grey(i));
    file.Add("/points", ToRosCloud({kStart + 100'000 * i, RosFrames().left}, {}));
  }
  Told told;
  const auto source = OpenRosSource(file.Source("&points=/points"), told.Options());
  EXPECT_EQ(All(*source).size(), 1U);
  EXPECT_THAT(source->lost_at_end().trouble,
              AllOf(HasSubstr("header.stamp = 0.000000: that of the image before it, none was set"),
                    HasSubstr("of 3 range images of /points joined 1 pairs")));
}

// Of 20 pairs and range images so many are of one time, the others 40 ms apart.
scenes::LostFrames LossOfRanges(int of_one_time) {
  RosRecording file(examples::Rig());
  PointCloud cloud;
  cloud.points.push_back({.position_m = {0, 0, 2}, .bgr = {}});
  for (int i = 0; i < 20; ++i) {
    const int64_t utime = kStart + 100'000 * i;
    const int64_t later = i < of_one_time ? 0 : 40'000;
    file.AddPair(utime, Grey(i));
    file.Add("/points", ToRosCloud({utime + later, RosFrames().left}, cloud));
  }
  Told told;
  const auto source = OpenRosSource(file.Source("&points=/points"), told.Options());
  EXPECT_EQ(All(*source).size(), 20U);
  return source->lost_at_end();
}

TEST(RosLosses, SaysHowManyRangeImagesJoinedNoPair) {
  EXPECT_EQ(LossOfRanges(15).trouble, "");
  EXPECT_THAT(LossOfRanges(10).trouble, HasSubstr("10 of 20 range images of /points joined 20"));
  EXPECT_FALSE(LossOfRanges(10).lacks_most);
  EXPECT_TRUE(LossOfRanges(1).lacks_most);
}

}  // namespace
}  // namespace sprout::capture
