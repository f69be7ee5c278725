#include <gmock/gmock.h>

#include <deque>
#include <memory>

#include "common/config/required.h"
#include "common/rig/rig_file.h"
#include "services/capture/raw_source.h"
#include "tests/common/rig/tilted_rig.h"
#include "tests/services/capture/raw_frame.h"

namespace sprout::capture {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<CurrentRig> TestRig() {
  RigDescription file;
  *file.mutable_calibration() = ToCalibration(TiltedRig());
  return std::make_shared<CurrentRig>(file, "rig.textproto");
}

// Cameras that give the frames of the test.
class TestCameras : public RawSource {
 public:
  explicit TestCameras(std::deque<scenes::CapturedFrame> frames) : frames_(std::move(frames)) {}
  bool is_live() const override { return true; }
  std::optional<scenes::CapturedFrame> Next(const std::stop_token& /*stop*/) override {
    if (frames_.empty()) return std::nullopt;
    scenes::CapturedFrame frame = frames_.front();
    frames_.pop_front();
    return frame;
  }

 private:
  std::deque<scenes::CapturedFrame> frames_;
};

TEST(RawSource, RectifiesImagesAndRanges) {
  const Rectifier rectifier(TiltedRig());
  scenes::CapturedFrame frame = RawFrame(77);
  Required(rectifier.Rectify(frame.left, frame.right, frame.tof));
  EXPECT_EQ(frame.left.size(), rectifier.rig().pair.size());
  EXPECT_EQ(frame.right.at<cv::Vec3b>(240, 320)[1], 77);
  EXPECT_NEAR(frame.tof.depth_m(71, 88), 1.01 * 2 - 0.02, 1e-3);
}

TEST(RawSource, TakesAFrameWhoseToFCameraGaveNothing) {
  scenes::CapturedFrame frame = RawFrame(77);
  frame.tof = {};
  Required(Rectifier(TiltedRig()).Rectify(frame.left, frame.right, frame.tof));
  EXPECT_TRUE(frame.tof.depth_m.empty());
}

TEST(RawSource, NamesTheImageThatIsNotOfTheCalibratedSize) {
  const Rectifier rectifier(TiltedRig());
  scenes::CapturedFrame raw = RawFrame(1);
  raw.right = Picture({64, 48}, 1);
  EXPECT_EQ(rectifier.Rectify(raw.left, raw.right, raw.tof).error().text,
            "right image of 64x48: allowed is the calibrated size 640x480");
  EXPECT_EQ(cv::norm(raw.left, RawFrame(1).left), 0);
  raw = RawFrame(1);
  raw.tof.depth_m = cv::Mat1f(3, 4, 1.f);
  EXPECT_THAT(rectifier.Rectify(raw.left, raw.right, raw.tof).error().text,
              HasSubstr("ToF image of 4x3"));
}

TEST(RawSource, CountsFramesThatCannotBeRectifiedAsLost) {
  scenes::CapturedFrame small = RawFrame(2);
  small.left = Picture({64, 48}, 2);
  scenes::CapturedFrame late = RawFrame(3);
  late.lost = 2;
  const auto source = Rectified(
      std::make_unique<TestCameras>(std::deque{RawFrame(1), small, small, late}), TestRig());
  EXPECT_TRUE(source->is_live());
  EXPECT_EQ(source->Next({})->lost, 0);
  const auto second = source->Next({}).value();
  EXPECT_EQ(second.lost, 4);
  EXPECT_THAT(second.trouble, HasSubstr("left image of 64x48"));
  EXPECT_FALSE(source->Next({}));
}

// A picture in which every place looks different.
scenes::CapturedFrame Noise(int seed) {
  scenes::CapturedFrame frame = RawFrame(0);
  cv::RNG random(static_cast<uint64_t>(seed));
  random.fill(frame.left, cv::RNG::UNIFORM, 0, 256);
  random.fill(frame.right, cv::RNG::UNIFORM, 0, 256);
  return frame;
}

void ExpectRectifiedBy(const Rectifier& rectifier, const scenes::CapturedFrame& raw,
                       const scenes::CapturedFrame& frame) {
  EXPECT_EQ(cv::norm(frame.left, rectifier.RectifyLeft(raw.left), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(frame.right, rectifier.RectifyRight(raw.right), cv::NORM_INF), 0);
}

TEST(RawSource, TakesANewRigFromOneFrameToTheNext) {
  const std::shared_ptr<CurrentRig> rig = TestRig();
  const RigInUsePtr first = rig->Get();
  scenes::CapturedFrame small = Noise(3);
  small.left = Picture({64, 48}, 2);
  const auto source = Rectified(
      std::make_unique<TestCameras>(std::deque{Noise(1), small, Noise(2), Noise(4)}), rig);
  auto frame = source->Next({});
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->new_rig);
  ExpectRectifiedBy(first->rectifier, Noise(1), *frame);

  rig->Replace(TurnedRig());
  frame = source->Next({});  // behind one that cannot be rectified
  ASSERT_TRUE(frame && frame->new_rig);
  EXPECT_EQ(frame->new_rig->rig_id, "turned");
  EXPECT_EQ(RigId(frame->new_rig->rig), RigId(rig->Get()->rectifier.rig()));
  EXPECT_EQ(frame->lost, 1);
  ExpectRectifiedBy(rig->Get()->rectifier, Noise(2), *frame);
  EXPECT_EQ(RigId(source->rig()), first->rig_id);

  frame = source->Next({});
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->new_rig);
  ExpectRectifiedBy(rig->Get()->rectifier, Noise(4), *frame);
}

}  // namespace
}  // namespace sprout::capture
