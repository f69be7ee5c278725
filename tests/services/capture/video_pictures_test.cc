#include "services/capture/video_pictures.h"

#include <gtest/gtest.h>

#include <deque>
#include <thread>

namespace sprout::capture {
namespace {

using std::chrono::milliseconds;

// A camera of 30 Hz with pictures in its queue; after them the next picture has to be waited for.
class Device : public Pictures {
 public:
  explicit Device(std::deque<milliseconds> waiting) : waiting_(std::move(waiting)) {}

  bool Grab() override {
    ++grabbed_;
    age_ = milliseconds(1);
    if (waiting_.empty()) {
      std::this_thread::sleep_for(milliseconds(20));
    } else {
      age_ = waiting_.front();
      waiting_.pop_front();
    }
    return true;
  }
  CameraImage Retrieve() override { return {}; }
  std::optional<std::chrono::microseconds> Age() const override { return age_; }
  double Rate() const override { return 30; }

  int grabbed() const { return grabbed_; }

 private:
  std::deque<milliseconds> waiting_;
  milliseconds age_{0};
  int grabbed_ = 0;
};

TEST(GrabNewest, DropsThePicturesThatWaitedInTheQueueOfADevice) {
  Device device({milliseconds(800), milliseconds(600), milliseconds(400), milliseconds(200)});
  EXPECT_TRUE(GrabNewest(device));
  EXPECT_EQ(device.grabbed(), 5);
  EXPECT_EQ(*device.Age(), milliseconds(1));
}

TEST(GrabNewest, TakesAPictureThatIsOnItsWayForTwoIntervals) {
  Device device({milliseconds(66), milliseconds(33)});
  EXPECT_TRUE(GrabNewest(device));
  EXPECT_EQ(device.grabbed(), 1);
}

}  // namespace
}  // namespace sprout::capture
