#include "services/capture/genicam/frame_builder.h"

#include <gmock/gmock.h>

#include "services/capture/genicam/genicam_source.h"

namespace sprout::capture {
namespace {

using testing::HasSubstr;

constexpr int64_t kStartUtime = 1'700'000'000'000'000;
constexpr int64_t kPeriodUs = 100'000;

RigDescription SomeRig() {
  RigDescription rig;
  rig.mutable_left()->set_serial("1");
  rig.mutable_right()->set_serial("2");
  rig.mutable_tof()->set_serial("3");
  return rig;
}

// Image `index` of a camera whose clock is `place` hours ahead, 8 ms of exposure and 1 ms on the
// way.
CameraEvent Image(RigPlace place, int64_t index) {
  const int64_t begin_us = kStartUtime + index * kPeriodUs;
  const int64_t ahead_ns = static_cast<int64_t>(place) * 3'600'000'000'000;
  CameraEvent event;
  event.image.device_ns = (begin_us - kStartUtime) * 1000 + ahead_ns;
  event.image.exposure_ns = 8'000'000;
  event.image.arrived_utime = begin_us + 9000;
  if (place == RigPlace::kTof) {
    event.image.tof.depth_m = cv::Mat1f(2, 3, 1.0F);
  } else {
    event.image.image = cv::Mat1b(4, 5, static_cast<uint8_t>(index));
  }
  return event;
}

CameraEvent Broken() {
  CameraEvent event;
  event.image.lost = 1;
  event.image.trouble = "image 7 has missing packets";
  return event;
}

// A reading of the camera's clock at a time after the start.
CameraEvent Reading(RigPlace place, int64_t after_us, int64_t wrong_by_ns = 0) {
  const int64_t ahead_ns = static_cast<int64_t>(place) * 3'600'000'000'000;
  return {.kind = CameraEvent::Kind::kClock,
          .text = "",
          .clock = {.device_ns = after_us * 1000 + ahead_ns + wrong_by_ns,
                    .utime = kStartUtime + after_us}};
}

CameraEvent Opened() { return {.kind = CameraEvent::Kind::kOpened, .text = "it"}; }

class Former : public testing::Test {
 protected:
  void SetUp() override {
    for (const RigPlace place : kRigPlaces) builder_.Add(place, Opened());
  }

  std::optional<scenes::CapturedFrame> Take(int64_t index,
                                            const std::vector<RigPlace>& places = {
                                                kRigPlaces.begin(), kRigPlaces.end()}) {
    for (const RigPlace place : places) builder_.Add(place, Image(place, index));
    return builder_.Next(kStartUtime + index * kPeriodUs + 10'000);
  }

  FrameBuilder builder_{SomeRig()};
};

TEST_F(Former, GivesTheMiddleOfTheExposureInTheHostsTime) {
  const scenes::CapturedFrame frame = Take(0).value();
  EXPECT_EQ(frame.utime, kStartUtime + 4000 + 1000);  // includes the way, which cannot be measured
  EXPECT_EQ(frame.spread_ms, 0);
  EXPECT_EQ(frame.tof.depth_m.size(), cv::Size(3, 2));
  EXPECT_EQ(frame.left.size(), cv::Size(5, 4));
  EXPECT_EQ(frame.lost, 0);
  EXPECT_EQ(frame.trouble, "");
}

TEST_F(Former, CountsACaptureOnceWhicheverOfItsImagesIsLost) {
  Take(0);
  // Left is lost in 1, right in 2, both in 3.
  builder_.Add(RigPlace::kLeft, Broken());
  EXPECT_FALSE(Take(1, {RigPlace::kRight, RigPlace::kTof}));
  builder_.Add(RigPlace::kRight, Broken());
  EXPECT_FALSE(Take(2, {RigPlace::kLeft, RigPlace::kTof}));
  builder_.Add(RigPlace::kLeft, Broken());
  builder_.Add(RigPlace::kRight, Broken());
  const scenes::CapturedFrame frame = Take(4).value();
  EXPECT_EQ(frame.lost, 3);
  EXPECT_EQ(frame.trouble,
            "left camera (serial 1): image 7 has missing packets; right camera (serial 2): image 7 "
            "has missing packets");
  EXPECT_EQ(Take(5)->lost, 0);
}

TEST_F(Former, DoesNotCountWhatComesBeforeAllCamerasAreThere) {
  for (int64_t i = 0; i < 5; ++i) EXPECT_FALSE(Take(i, {RigPlace::kLeft, RigPlace::kTof}));
  EXPECT_EQ(Take(5)->lost, 0);
  EXPECT_FALSE(Take(6, {RigPlace::kLeft}));
  EXPECT_EQ(Take(7)->lost, 1);
}

TEST_F(Former, GoesOnWithoutATofCameraThatIsGone) {
  Take(0);
  builder_.Add(RigPlace::kTof, {.kind = CameraEvent::Kind::kGone, .text = "gone"});
  const scenes::CapturedFrame frame = Take(1, {RigPlace::kLeft, RigPlace::kRight}).value();
  EXPECT_TRUE(frame.tof.depth_m.empty());
  EXPECT_EQ(frame.lost, 0);
  EXPECT_EQ(frame.trouble, "ToF camera (serial 3): gone");
}

TEST_F(Former, SaysWhyThereIsNoFrame) {
  EXPECT_EQ(builder_.NewTrouble(), "");
  builder_.Add(RigPlace::kLeft, {.kind = CameraEvent::Kind::kGone, .text = "gone"});
  EXPECT_EQ(builder_.NewTrouble(), "left camera (serial 1): gone");
  EXPECT_EQ(builder_.NewTrouble(), "");
  builder_.Add(RigPlace::kLeft, Opened());
  // The cameras expose half a period apart.
  Take(0, {RigPlace::kLeft});
  CameraEvent late = Image(RigPlace::kRight, 0);
  late.image.arrived_utime += 50'000;
  builder_.Add(RigPlace::kRight, std::move(late));
  EXPECT_FALSE(builder_.Next(kStartUtime + 60'000));
  EXPECT_THAT(builder_.NewTrouble(), HasSubstr("left camera's 1 images and the right one's 1 are "
                                               "within max_spread_ms = 5; trigger = SOFTWARE"));
}

TEST(GenicamSource, TellsForWhatItWaits) {
  std::stop_source stop;
  std::string said;
  const auto source = OpenGenicam(SomeRig(), "rig", [&](const std::string& reason) {
    said += reason;
    if (!reason.empty()) stop.request_stop();
  });
  EXPECT_FALSE(source->Next(stop.get_token()));
  EXPECT_THAT(said, testing::StartsWith("waiting for the cameras: "));
}

TEST_F(Former, TellsWhenAClockJumps) {
  for (int64_t i = 0; i < 30; ++i) Take(i);
  std::string trouble;
  for (int64_t i = 30; i < 50; ++i) {
    CameraEvent jumped = Image(RigPlace::kRight, i);
    jumped.image.device_ns += 250'000'000;
    builder_.Add(RigPlace::kRight, std::move(jumped));
    if (const auto frame = Take(i, {RigPlace::kLeft, RigPlace::kTof})) trouble += frame->trouble;
  }
  EXPECT_THAT(trouble, HasSubstr("right camera (serial 2): its clock jumped by +250.0 ms"));
  EXPECT_EQ(Take(51, {RigPlace::kLeft, RigPlace::kTof}), std::nullopt);
}

TEST_F(Former, TakesTheTimeFromTheDevicesClockWhereItCanBeRead) {
  for (const RigPlace place : kRigPlaces) builder_.Add(place, Reading(place, 0));
  for (int64_t i = 0; i < 20; ++i) {
    for (const RigPlace place : kRigPlaces) {
      CameraEvent event = Image(place, i);
      // A ToF camera computes before it sends.
      if (place == RigPlace::kTof) event.image.arrived_utime += 150'000;
      builder_.Add(place, std::move(event));
    }
    const auto frame = builder_.Next(kStartUtime + i * kPeriodUs + 200'000).value();
    EXPECT_EQ(frame.utime, kStartUtime + i * kPeriodUs + 4000);
    EXPECT_EQ(frame.spread_ms, 0);
    EXPECT_FALSE(frame.tof.depth_m.empty());
  }
}

TEST_F(Former, ReadsAClockAnewThatJumped) {
  for (int64_t i = 0; i < 20; ++i) {
    for (const RigPlace place : kRigPlaces) builder_.Add(place, Reading(place, i * kPeriodUs));
    EXPECT_TRUE(Take(i));
  }
  constexpr int64_t kJumpNs = 5'000'000'000;
  std::string trouble;
  for (int64_t i = 20; i < 40; ++i) {
    builder_.Add(RigPlace::kRight, Reading(RigPlace::kRight, i * kPeriodUs, kJumpNs));
    CameraEvent event = Image(RigPlace::kRight, i);
    event.image.device_ns += kJumpNs;
    builder_.Add(RigPlace::kRight, std::move(event));
    const auto frame = Take(i, {RigPlace::kLeft, RigPlace::kTof});
    if (frame) trouble += frame->trouble;
    EXPECT_EQ(frame.has_value(), i > 24) << i;
  }
  EXPECT_EQ(trouble, "right camera (serial 2): its clock contradicts its images; reading it again");
}

TEST_F(Former, DoesNotBelieveAClockThatIsNotThatOfTheImages) {
  builder_.Add(RigPlace::kRight, Reading(RigPlace::kRight, 0, 7'000'000'000));
  int64_t frames = 0;
  std::string trouble;
  for (int64_t i = 0; i < 30; ++i) {
    builder_.Add(RigPlace::kRight, Reading(RigPlace::kRight, i * kPeriodUs, 7'000'000'000));
    const auto frame = Take(i);
    if (!frame) continue;
    ++frames;
    trouble += frame->trouble;
  }
  EXPECT_GE(frames, 15);
  EXPECT_THAT(trouble, HasSubstr("from now on times follow from their arrival"));
}

TEST(FormerWithPtp, HasOneClockForAllCameras) {
  RigDescription rig = SomeRig();
  rig.set_trigger(RigDescription::PTP);
  FrameBuilder former(rig);
  for (const RigPlace place : kRigPlaces) former.Add(place, Opened());
  for (const RigPlace place : kRigPlaces) {
    CameraEvent event = Image(place, 0);
    event.image.device_ns = 5'000'000'000;
    // A ToF camera computes before it sends.
    if (place == RigPlace::kTof) event.image.arrived_utime += 40'000;
    former.Add(place, std::move(event));
  }
  const scenes::CapturedFrame frame = former.Next(kStartUtime + 60'000).value();
  EXPECT_EQ(frame.spread_ms, 0);
  EXPECT_FALSE(frame.tof.depth_m.empty());
}

}  // namespace
}  // namespace sprout::capture
