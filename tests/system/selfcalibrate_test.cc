// sprout-selfcalibrate and sprout-capture as processes: a knocked rig is seen, and put right
// between two frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <numbers>
#include <set>

#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/tools/calibrate/knocked_scene.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using calibrate::RigImages;
using calibrate::RigNumbers;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;
// A rig, what its calibration says after a knock, and what its cameras see.
struct KnockedRig {
  RawRig real = calibrate::TrueRig({480, 360});
  RawRig calibrated;
  std::vector<RigImages> views;

  KnockedRig() {
    RigNumbers errors{};
    errors[calibrate::kPitch] = 0.25 * kDegree;
    errors[calibrate::kYaw] = -0.2 * kDegree;
    errors[calibrate::kRoll] = -0.3 * kDegree;
    calibrated = calibrate::Changed(real, errors);
    for (const int frame : {0, 20}) views.push_back(calibrate::RenderScene(real, 3, frame, true));
  }

  const RigImages& ViewOf(int64_t seq) const {
    return views[static_cast<size_t>(seq) % views.size()];
  }
};

const KnockedRig& Knocked() {
  static const KnockedRig rig;
  return rig;
}

// As the cameras see it, ten frames a second.
void WriteRawLog(const fs::path& path, int frames) {
  LogWriter writer(path);
  for (int64_t seq = 0; seq < frames; ++seq) {
    const RigImages& view = Knocked().ViewOf(seq);
    const FrameId id{.utime = 1'700'000'000'000'000 + 100'000 * seq, .seq = seq, .rig_id = ""};
    const std::pair<Part, PartValue> parts[] = {
        {Part::kLeft, view.left}, {Part::kRight, view.right}, {Part::kTof, view.tof}};
    for (const auto& [part, value] : parts) {
      writer.Write(id.utime, std::string(kRawPrefix) + std::string(ChannelOf(part)),
                   EncodePart(id, part, value));
    }
  }
  writer.Close();
}

double WorstTurn(const RawRig& rig) {
  const RigNumbers left = calibrate::ErrorsLeft(Knocked().real, rig);
  return std::max({std::abs(left[calibrate::kPitch]), std::abs(left[calibrate::kYaw]),
                   std::abs(left[calibrate::kRoll])});
}

// What a recording of the graph says about calibrations.
class Recording {
 public:
  Recording(const fs::path& log, const fs::path& rigs) : rigs_(rigs) {
    LogReader reader(log);
    for (LogEvent event; reader.Next(event);) Take(event);
  }

  std::vector<std::string> used;  // rig_ids of the frames, in the order of their first frame
  std::set<int64_t> lefts;
  std::vector<RigChange> changes;

  RawRig FileOf(const std::string& rig_id) const {
    const fs::path path = rigs_ / ("rig_" + rig_id + ".textproto");
    return RequireCalibration(LoadRigFile(path), path);
  }

 private:
  void Take(const LogEvent& event) {
    if (event.channel == kRigChangeChannel) changes.push_back(*DecodeRigChange(event.data));
    const std::optional<Part> part = PartOf(event.channel);
    if (part == Part::kRig) announced_.insert(DecodeFrameId(event.data)->rig_id);
    if (part != Part::kLeft && part != Part::kRight) return;
    const DecodedPart decoded = *DecodePart(*part, event.data);
    const FrameId& id = decoded.id;
    EXPECT_TRUE(announced_.contains(id.rig_id)) << "frame " << id.seq << " before its RIG";
    if (used.empty() || used.back() != id.rig_id) {
      EXPECT_EQ(std::ranges::count(used, id.rig_id), 0) << "frame " << id.seq << ": back again";
      used.push_back(id.rig_id);
      rectifiers_.insert_or_assign(id.rig_id, Rectifier(FileOf(id.rig_id)));
    }
    // No pixel of another calibration than the one that the frame names.
    const RigImages& view = Knocked().ViewOf(id.seq);
    const Rectifier& rectifier = rectifiers_.at(id.rig_id);
    const cv::Mat expected =
        part == Part::kLeft ? rectifier.RectifyLeft(view.left) : rectifier.RectifyRight(view.right);
    EXPECT_EQ(cv::norm(std::get<cv::Mat>(decoded.value), expected, cv::NORM_INF), 0) << id.seq;
    if (part == Part::kLeft) lefts.insert(id.seq);
  }

  fs::path rigs_;
  std::set<std::string> announced_;
  std::map<std::string, Rectifier> rectifiers_;
};

TEST(SelfCalibrateSystem, PutsAKnockedRigRightBetweenTwoFramesAndReplaysToTheSameBytes) {
  constexpr int kFrames = 100;
  const TemporaryDirectory folder;
  WriteRawLog(folder / "raw.lcm", kFrames);
  RigDescription file;
  *file.mutable_calibration() = ToCalibration(Knocked().calibrated);
  ASSERT_TRUE(SaveRigFile(folder / "rig.textproto", file));
  const fs::path rigs = folder / "rigs";
  const std::string config =
      "self_calibrate { mode: APPLY period_s: 0.2 frames: 2 pause_s: 1 folder: \"" + rigs.string() +
      "\" }";

  Graph graph("", kDefaultLcmUrl, {kStatusChannel});
  graph.StartChain();
  graph.Start("temporal");
  graph.Start("depth");
  graph.Start("selfcalibrate", {"--config", config});
  Process& record = graph.Start("record", {"--dir", folder / "record"});
  Process& capture = graph.StartOnly(
      "capture",
      {"--config", config, "--rate", "5", "--lockstep", "1", "--source",
       "log:" + (folder / "raw.lcm").string() + "?rig=" + (folder / "rig.textproto").string()});
  ASSERT_EQ(capture.Wait(std::chrono::seconds(200)), 0) << capture.Output();
  EXPECT_THAT(capture.Output(), HasSubstr("the calibration was put right by "));
  // Capture waits for grow's answers; the two behind it may leave out a frame on a busy machine.
  for (const char* stage : {"refine", "prior", "grow", "temporal", "depth"}) {
    EXPECT_TRUE(graph.WaitUntil([&](Graph& g) {
      const StageStatus& status = g.statuses[stage];
      return status.frames_in == kFrames && status.frames_incomplete == 0 &&
             status.frames_out + status.frames_skipped == kFrames && status.bad_messages == 0;
    })) << stage
        << ":\n"
        << graph.process(stage).Output();
  }
  record.Signal(SIGINT);
  ASSERT_EQ(record.Wait(), 0) << record.Output();

  const fs::path log = fs::directory_iterator(folder / "record")->path();
  const Recording recording(log, rigs);
  EXPECT_EQ(std::ssize(recording.lefts), kFrames);
  ASSERT_GE(std::ssize(recording.used), 2);
  EXPECT_LT(WorstTurn(recording.FileOf(recording.used.back())), 0.02 * kDegree);
  EXPECT_GT(WorstTurn(recording.FileOf(recording.used.front())), 0.2 * kDegree);
  ASSERT_FALSE(recording.changes.empty());
  EXPECT_EQ(recording.changes.front().verdict, RigChange::Verdict::kWrong)
      << recording.changes.front().reason;
  EXPECT_EQ(recording.changes.front().newest_frame.rig_id, recording.used.front());

  OutputOf({"sprout-pipeline", "--replay", log, "--record", folder / "replayed.lcm"}, 0,
           std::chrono::seconds(200));
  const ChannelBytes live = ReadChannels(log);
  ChannelBytes replayed = ReadChannels(folder / "replayed.lcm");
  replayed.erase(std::string(kProcessChannel));
  ASSERT_EQ(std::ssize(replayed.at("SPROUT_DISPARITY")), kFrames);
  for (const auto& [channel, messages] : replayed) {
    EXPECT_TRUE(live.at(channel) == messages) << channel << " of sprout-pipeline";
  }
}

TEST(SelfCalibrateSystem, WarnsOfAKnockedRigWithTheCommandThatPutsItRight) {
  const Rectifier rectifier(Knocked().calibrated);
  Graph graph;
  Process& watcher =
      graph.Start("selfcalibrate", {"--config", "self_calibrate { period_s: 0.1 frames: 2 }"});
  std::string error;
  for (int64_t seq = 0; seq < 600 && error.empty(); ++seq) {
    const RigImages images = *RectifyImages(rectifier, Knocked().ViewOf(seq));
    graph.PublishFrame(1'000'000 + 100'000 * seq, seq, rectifier.rig(), images.left, images.right,
                       images.tof);
    graph.WaitUntil(
        [&](Graph& g) {
          error = g.statuses["selfcalibrate"].last_error;
          return !error.empty();
        },
        std::chrono::seconds(1));
  }
  EXPECT_THAT(error, HasSubstr("the calibration is wrong (2 frames"));
  EXPECT_THAT(error, HasSubstr("sprout-calibrate refine recording/*.lcm --out new.textproto"));
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    const StageStatus& status = g.statuses["selfcalibrate"];
    return status.frames_failed == 0 && status.bad_messages == 0 && status.tof_offset.sigma_px > 0;
  }));
  watcher.Signal(SIGINT);
  EXPECT_EQ(watcher.Wait(), 0) << watcher.Output();
}

TEST(SelfCalibrateSystem, SaysThatNoFrameComes) {
  Graph graph;
  graph.Start("selfcalibrate");
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["selfcalibrate"].last_error.starts_with("nothing heard on SPROUT_LEFT, ");
  }));
}

TEST(SelfCalibrateSystem, SaysWhatItCannotDo) {
  const TemporaryDirectory folder;
  const std::string apply =
      "self_calibrate { mode: APPLY folder: \"" + (folder / "rigs").string() + "\" }";
  EXPECT_THAT(
      OutputOf(
          {"sprout-capture", "--config", apply, "--source", "synthetic:64x48", "--frames", "1"}, 2),
      HasSubstr("synthetic:64x48 is not rectified here; allowed: "));
  OutputOf({"sprout-selfcalibrate", "--config", "self_calibrate { mode: OFF }"});
  EXPECT_THAT(OutputOf({"sprout-selfcalibrate", "--config", "self_calibrate { frames: 25 }"}, 2),
              HasSubstr("self_calibrate.frames = 25"));
}

}  // namespace
}  // namespace sprout
