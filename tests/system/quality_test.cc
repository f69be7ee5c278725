// sprout-quality beside a sender of maps.
#include <gmock/gmock.h>

#include <csignal>
#include <thread>

#include "common/core/disparity_image.h"
#include "tests/common/measure/flat_target.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/eventually.h"
#include "tests/system/graph.h"

namespace sprout {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class QualitySystem : public ::testing::Test {
 protected:
  std::string QualityFile(const char* name) const { return folder_ / name; }

  Process StartQuality(std::vector<std::string> flags) const {
    std::vector<std::string> command = {ProgramPath("sprout-quality")};
    command.insert(command.end(), flags.begin(), flags.end());
    return Process(command);
  }

  // Maps of a wall, one after the other, until the program has ended or `done` says so.
  // @param sigma  that they claim, counts; 0: nothing.
  void SendMapsUntil(Process& quality, const std::function<bool()>& done, int sigma = 0) {
    sprout::testing::TargetNoise noise;
    const Rig rig{.pair = sprout::testing::TargetPair(), .tof = {}};
    const cv::Mat1f wall = sprout::testing::FlatTarget().Disparity(rig.pair);
    for (int64_t seq = 0; seq < 500 && !done(); ++seq) {
      const FrameId id{.utime = 1'700'000'000'000'000 + seq, .seq = seq, .rig_id = RigId(rig)};
      graph_.PublishPart(id, Part::kRig, rig);
      graph_.PublishPart(id, Part::kDisparity, FromPx(noise.On(wall, 0.1)));
      if (sigma > 0) {
        graph_.PublishPart(id, Part::kSigma, cv::Mat(wall.size(), CV_8UC1, cv::Scalar(sigma)));
      }
      // A message that is no map does not stop it.
      const std::array<uint8_t, 5> garbage = {1, 2, 3, 4, 5};
      graph_.Publish(ChannelOf(Part::kDisparity), garbage);
      if (quality.Wait(std::chrono::seconds(0))) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(40));
    }
  }

  const TemporaryDirectory folder_;
  Graph graph_;
};

// The map claims 2/16 px, its noise is 0.1 px.
TEST_F(QualitySystem, MeasuresARunningGraphOnceAndEnds) {
  Process quality = StartQuality({"--once", "--count", "6", "--json", QualityFile("q.json")});
  SendMapsUntil(
      quality, [] { return false; }, /*sigma=*/2);
  EXPECT_EQ(quality.Wait(), 0) << quality.Output();
  EXPECT_THAT(quality.Output(), AllOf(HasSubstr("of 320x240 px, 6 frames\n"),
                                      ContainsRegex("sub-pixel RMS +0\\.(09[5-9]|10[0-5])"),
                                      ContainsRegex("sigma claimed +0\\.1250 px"),
                                      ContainsRegex("sigma claimed / seen +1\\.2[2-7]")));
  EXPECT_THAT(quality.Output(), HasSubstr("sprout-quality: SPROUT_DISPARITY: "));
  EXPECT_TRUE(std::filesystem::exists(QualityFile("q.json")));
}

TEST_F(QualitySystem, GoesOnUntilItIsInterrupted) {
  Process quality = StartQuality({"--report", QualityFile("q.html")});
  int sent = 0;
  SendMapsUntil(quality, [&] { return ++sent > 50; });
  EXPECT_FALSE(quality.Wait(std::chrono::seconds(0)));
  EXPECT_FALSE(std::filesystem::exists(QualityFile("q.html")));
  quality.Signal(SIGINT);
  EXPECT_EQ(quality.Wait(), 0) << quality.Output();
  EXPECT_TRUE(std::filesystem::exists(QualityFile("q.html")));
}

TEST_F(QualitySystem, KilledItLeavesNoFile) {
  Process quality =
      StartQuality({"--report", QualityFile("q.html"), "--json", QualityFile("q.json")});
  int sent = 0;
  SendMapsUntil(quality, [&] { return ++sent > 20; });
  quality.Signal(SIGKILL);
  EXPECT_EQ(quality.Wait(), 128 + SIGKILL);
  EXPECT_EQ(folder_.CountEntries(), 0);
}

TEST_F(QualitySystem, SaysThatNothingCameWhenItIsInterruptedBeforeTheFirstMap) {
  Process quality = StartQuality({"--json", QualityFile("q.json")});
  ASSERT_TRUE(Eventually([&] { return Catches(quality.pid(), SIGTERM); }));
  quality.Signal(SIGTERM);
  EXPECT_EQ(quality.Wait(), 1);
  EXPECT_THAT(quality.Output(),
              HasSubstr("sprout-quality: no disparity map with a calibration came"));
  EXPECT_FALSE(std::filesystem::exists(QualityFile("q.json")));
}

}  // namespace
}  // namespace sprout
