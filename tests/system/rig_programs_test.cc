// sprout-capture and sprout-calibrate with hostile files and senders.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "common/app/stage_monitor.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/bus/publisher.h"
#include "common/messages/codec.h"
#include "services/tools/check/contract.h"
#include "services/tools/check/test_frames.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/tools/calibrate/board_scene.h"
#include "tests/system/hostile_messages.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using std::chrono::seconds;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class RigProgramsSystem : public testing::Test {
 protected:
  std::string File(const std::string& name) const { return folder_ / name.c_str(); }

  void WriteBytes(const std::string& name, const std::string& bytes) const {
    std::ofstream(File(name), std::ios::binary) << bytes;
  }

  // An AVI file whose frames are such JPEG streams, or whatever else.
  void WriteAvi(const std::string& name, const std::vector<std::string>& frames,
                uint32_t claimed_frames) const {
    const auto number = [](uint32_t n) {
      std::string bytes;
      for (int i = 0; i < 4; ++i) bytes += static_cast<char>(n >> (8 * i));
      return bytes;
    };
    const auto chunk = [&](const std::string& type, std::string data) {
      const auto size = static_cast<uint32_t>(data.size());
      if (size % 2 != 0) data += '\0';
      return type + number(size) + data;
    };
    const auto numbers = [&](const std::vector<uint32_t>& list) {
      std::string bytes;
      for (const uint32_t n : list) bytes += number(n);
      return bytes;
    };
    const std::string avih =
        numbers({100'000, 0, 0, 0x10, claimed_frames, 0, 1, 1 << 20, 64, 48, 0, 0, 0, 0});
    const std::string strh =
        "vidsMJPG" + numbers({0, 0, 0, 1, 10, 0, claimed_frames, 1 << 20, 0xffffffff, 0, 0, 0});
    const std::string strf =
        numbers({40, 64, 48, 0x00180001}) + "MJPG" + numbers({9216, 0, 0, 0, 0});
    std::string movi = "movi";
    for (const std::string& frame : frames) movi += chunk("00dc", frame);
    const std::string strl = "strl" + chunk("strh", strh) + chunk("strf", strf);
    const std::string hdrl = "hdrl" + chunk("avih", avih) + chunk("LIST", strl);
    WriteBytes(name, chunk("RIFF", "AVI " + chunk("LIST", hdrl) + chunk("LIST", movi)));
  }

  static std::string Jpeg() {
    std::vector<uint8_t> bytes;
    cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 99, 199)), bytes);
    return {bytes.begin(), bytes.end()};
  }

  // Exit code and output of sprout-capture with a source without a clock.
  static Outcome Capture(const std::string& source) {
    return RunProgramOf({"sprout-capture", "--source", source, "--rate", "0", "--raw"},
                        seconds(120));
  }

  const TemporaryDirectory folder_;
};

TEST_F(RigProgramsSystem, ASourceThatGaveNoFrameIsNoSuccess) {
  WriteAvi("none.avi", {}, 0);
  WriteAvi("garbage.avi", {"no JPEG", "neither"}, 2);
  for (const char* name : {"none.avi", "garbage.avi"}) {
    const auto [code, output] = Capture("opencv:" + File(name));
    EXPECT_EQ(code, 1) << output;
    EXPECT_THAT(output, HasSubstr("capture.source = opencv:" + File(name) + ": it gave no frame"));
  }
  WriteAvi("good.avi", {Jpeg(), Jpeg(), Jpeg()}, 3);
  const auto [code, output] = Capture("opencv:" + File("good.avi"));
  EXPECT_EQ(code, 0) << output;
  EXPECT_THAT(output, testing::AllOf(HasSubstr("sent 3 frames"), Not(HasSubstr(" by its header"))));
}

TEST_F(RigProgramsSystem, AVideoThatEndsEarlySaysSo) {
  for (const auto& [claimed, text] : {std::pair{100U, "100"}, {0x7fffffffU, "2147483647"}}) {
    WriteAvi("short.avi", {Jpeg(), Jpeg(), Jpeg()}, claimed);
    const auto [code, output] = Capture("opencv:" + File("short.avi"));
    EXPECT_EQ(code, 0) << output;
    EXPECT_THAT(output,
                HasSubstr(fmt::format(
                    "short.avi: 3 frames could be read; {} are in it by its header", text)));
  }
}

TEST_F(RigProgramsSystem, AnImageThatClaimsALotTakesNeitherMemoryNorTime) {
  for (const char* side : {"left", "right"}) {
    WriteBytes(fmt::format("{}00.pgm", side), "P5\n20000 20000\n255\n");
  }
  EXPECT_THAT(OutputOf({"sprout-capture", "--raw", "--source",
                        "opencv:" + File("left%02d.pgm") + "," + File("right%02d.pgm")},
                       2),
              HasSubstr("left00.pgm: 20000x20000 px; allowed: 1 to 16384"));
}

// A rig that is watched, and somebody else on its channels.
TEST_F(RigProgramsSystem, WatchSurvivesAHostileSenderAndStillKeepsViews) {
  const std::string views = File("views");
  Process watch({ProgramPath("sprout-calibrate"), "watch", "--out", views});
  HostileMessages hostile(check::ReadTestFrames(kSampleLog, check::ContractOf("grow")).at(0), 7);
  Publisher publisher(kDefaultLcmUrl, "RAW_");
  const auto until = std::chrono::steady_clock::now() + seconds(10);
  int sent = 0;
  while (std::chrono::steady_clock::now() < until) {
    for (const HostileMessage& message : hostile.Next()) {
      if (publisher.Publish(message.channel, message.bytes)) ++sent;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GT(sent, 300);
  ASSERT_EQ(watch.Wait(seconds(0)), std::nullopt) << watch.Output();

  const calibrate::Board board{calibrate::BoardSize{}};
  const calibrate::BoardScene scene(board, calibrate::SceneRig({640, 480}));
  const calibrate::RigImages images = scene.Render(calibrate::BoardPoses(board, 1)[0], 0);
  const auto has_view = [&] { return std::filesystem::exists(views + "/left_0001.png"); };
  for (int64_t seq = 0; seq < 30 && !has_view(); ++seq) {
    const FrameId id{.utime = NowUtime(), .seq = 1'000'000 + seq, .rig_id = ""};
    const auto send = [&](Part part, const PartValue& value) {
      EXPECT_TRUE(publisher.Publish(ChannelOf(part), EncodePart(id, part, value)));
    };
    send(Part::kLeft, images.left);
    send(Part::kRight, images.right);
    send(Part::kTof, images.tof);
    std::this_thread::sleep_for(seconds(1));
  }
  EXPECT_TRUE(has_view()) << watch.Output();
  EXPECT_LT(PeakMegabytes(watch.pid()), 2048);
  watch.Signal(SIGINT);
  EXPECT_EQ(watch.Wait(seconds(30)), 1) << watch.Output();
  EXPECT_THAT(watch.Output(), HasSubstr("views used"));
}

TEST_F(RigProgramsSystem, TwoWatchesDoNotReplaceEachOthersViews) {
  Process first({ProgramPath("sprout-calibrate"), "watch", "--out", File("views")});
  ASSERT_TRUE(Says(first, "view 0"));
  EXPECT_THAT(OutputOf({"sprout-calibrate", "watch", "--out", File("views")}, 2, seconds(60)),
              HasSubstr("another sprout-calibrate watch writes there"));
}

TEST_F(RigProgramsSystem, WatchSaysAtOnceThatItsFolderCannotBeWritten) {
  namespace fs = std::filesystem;
  const fs::path views = File("views");
  fs::create_directory(views);
  fs::permissions(views.parent_path(), fs::perms(0755));
  fs::permissions(views, fs::perms(0555));
  std::vector<std::string> command;
  if (geteuid() == 0) command = {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"};
  command.insert(command.end(), {ProgramPath("sprout-calibrate"), "watch", "--out", views});
  EXPECT_THAT(OutputOf(command, 2, seconds(60)),
              ContainsRegex("--out " + views.string() + "/.*: cannot be written"));
}

}  // namespace
}  // namespace sprout
