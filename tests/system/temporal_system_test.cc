// sprout-temporal as a process, live and replayed.
#include <gmock/gmock.h>

#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/scenes/dataset.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using testing::HasSubstr;

constexpr Part kAnswers[] = {Part::kFused, Part::kFusedConfidence, Part::kMotion};

// What temporal joins, of a simulated scene: its truth in place of grow's answers.
std::vector<std::pair<FrameId, std::map<Part, PartValue>>> Frames(int count) {
  const auto source = scenes::OpenDataset("synthetic:320x240");
  std::vector<std::pair<FrameId, std::map<Part, PartValue>>> frames;
  for (int64_t seq = 0; seq < count; ++seq) {
    const scenes::DatasetFrame captured = source->Get(seq);
    const FrameId id{
        .utime = 1'000'000 + 100'000 * seq, .seq = seq, .rig_id = RigId(source->rig())};
    frames.push_back({id,
                      {{Part::kRig, source->rig()},
                       {Part::kLeft, captured.left},
                       {Part::kDisparity, FromPx(captured.truth.left)},
                       {Part::kConfidence, cv::Mat(captured.left.size(), CV_8UC1,
                                                   cv::Scalar(static_cast<double>(200 + seq)))}}});
  }
  return frames;
}

TEST(TemporalSystem, ReplayGivesTheBytesOfTheLiveRun) {
  constexpr int kFrames = 8;
  auto frames = Frames(kFrames);
  std::get<cv::Mat>(frames[5].second.at(Part::kLeft)).setTo(5);  // somebody covers the lens
  Graph graph;
  graph.Start("temporal");
  graph.Start("depth", {"--config", "depth { input: FUSED }"});
  std::map<std::pair<Part, int64_t>, std::vector<uint8_t>> live;
  const auto send = [&](const auto& frame, int times) {
    const auto& [id, parts] = frame;
    for (const auto& [part, value] : parts) graph.PublishPart(id, part, value);
    return graph.WaitUntil([&, seq = id.seq](Graph& g) {
      for (const Part part : kAnswers) {
        if (g.part_counts[{part, seq}] < times) return false;
        live[{part, seq}] = EncodePart(frame.first, part, g.parts.at({part, seq}));
      }
      return g.part_counts[{Part::kDepth, seq}] > 0;
    });
  };
  for (const auto& frame : frames) ASSERT_TRUE(send(frame, 1)) << frame.first.seq;
  const auto once = live;
  ASSERT_TRUE(send(frames.back(), 2));
  EXPECT_EQ(live, once) << "the newest frame again has another answer";
  // The dark frame, and the one after it.
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    const StageStatus& status = g.statuses["temporal"];
    return status.frames_degenerate == 2 &&
           status.last_error.find("earlier frames forgotten") != std::string::npos;
  }));

  const TemporaryDirectory folder;
  LogWriter writer(folder / "in.lcm");
  for (const auto& [id, parts] : frames) {
    for (const auto& [part, value] : parts) {
      writer.Write(id.utime, ChannelOf(part), EncodePart(id, part, value));
    }
  }
  writer.Close();
  const auto in = folder / "in.lcm";
  OutputOf({"sprout-temporal", "--replay", in, "--record", folder / "out.lcm"}, 0,
           std::chrono::seconds(60));
  const ChannelBytes recorded = ReadChannels(folder / "out.lcm");
  for (const Part part : kAnswers) {
    const auto& messages = recorded.at(std::string(ChannelOf(part)));
    ASSERT_EQ(std::ssize(messages), kFrames) << ChannelOf(part);
    for (int64_t seq = 0; seq < kFrames; ++seq) {
      EXPECT_EQ(messages[static_cast<size_t>(seq)], (once.at({part, seq})))
          << ChannelOf(part) << " of frame " << seq;
    }
  }
  // Of two frames before the dark one: behind those before them the same, alone others.
  const auto two_frames = [&](const std::string& config) {
    const auto some = folder / "some.lcm";
    const std::string report = OutputOf({"sprout-temporal", "--config", config, "--replay", in,
                                         "--record", some, "--frames", "3:4"},
                                        0, std::chrono::seconds(60));
    return std::pair(ReadChannels(some).at("SPROUT_FUSED"), report);
  };
  const auto& whole = recorded.at("SPROUT_FUSED");
  const auto [warm, warm_report] = two_frames("temporal { warm_up_frames: 3 }");
  EXPECT_EQ(warm, (std::vector{whole[3], whole[4]}));
  EXPECT_THAT(warm_report, HasSubstr("frames: 2 in, 2 out (0 degenerate)"));
  EXPECT_THAT(warm_report, HasSubstr("; 3 frames to warm up;"));
  const auto [cold, cold_report] = two_frames("temporal { warm_up_frames: 0 }");
  ASSERT_EQ(cold.size(), 2U);
  EXPECT_NE(cold[0], whole[3]);
  EXPECT_THAT(cold_report, testing::Not(HasSubstr("to warm up")));

  // The motion that was measured, given back; of one frame it is missing.
  constexpr int64_t kMissing = 2;
  LogWriter odometry(folder / "odometry.lcm");
  for (const auto& bytes : recorded.at("SPROUT_MOTION")) {
    const FrameId id = *DecodeFrameId(bytes);
    if (id.seq != kMissing) odometry.Write(id.utime, "SPROUT_ODOMETRY", bytes);
  }
  odometry.Close();
  EXPECT_THAT(Replay("sprout-temporal", "temporal { motion: CHANNEL }",
                     {in, folder / "odometry.lcm"}, folder / "given.lcm"),
              HasSubstr("7 in, 7 out (2 degenerate), 0 failed, 1 incomplete"));
  const ChannelBytes told = ReadChannels(folder / "given.lcm");
  for (const auto& bytes : told.at("SPROUT_MOTION")) {
    const auto decoded = DecodePart(Part::kMotion, bytes);
    const int64_t seq = decoded->id.seq;
    const auto& motion = std::get<CameraMotion>(decoded->value);
    const auto measured = std::get<CameraMotion>(
        DecodePart(Part::kMotion, recorded.at("SPROUT_MOTION")[static_cast<size_t>(seq)])->value);
    EXPECT_EQ(motion.start_seq, measured.start_seq) << seq;
    EXPECT_EQ(motion.resets, measured.resets) << seq;
    EXPECT_EQ(motion.last_seq, seq == kMissing + 1 ? kMissing - 1 : measured.last_seq) << seq;
    EXPECT_LT(
        (motion.start_from_left.translation_m - measured.start_from_left.translation_m).norm(),
        1e-9)
        << seq;
  }
}

}  // namespace
}  // namespace sprout
