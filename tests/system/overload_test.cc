// Frames that come faster than the slowest stage can take them.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "common/app/stage_monitor.h"
#include "common/bus/mailbox.h"
#include "common/messages/codec.h"
#include "common/scenes/dataset.h"
#include "tests/system/graph.h"

namespace sprout {
namespace {

using std::chrono::milliseconds;

// Takes the place of a stage after refine: of the frames that have `input` it takes the newest, and
// answers it after `time`, however busy the machine is.
class SleepingStage {
 public:
  SleepingStage(Part input, Part output, PartValue answer, milliseconds time)
      : publisher_(kDefaultLcmUrl, ""),
        receiver_(kDefaultLcmUrl, "", {ChannelOf(input)},
                  [this](std::string_view, std::span<const uint8_t> bytes) {
                    const Result<FrameId> id = DecodeFrameId(bytes);
                    if (id && newest_.Put(*id)) ++skipped_;
                  }),
        thread_([=, this](const std::stop_token& stop) {
          while (const auto id = newest_.Take(stop)) {
            std::this_thread::sleep_for(time);
            const auto bytes = EncodePart(*id, output, answer);
            if (publisher_.Publish(ChannelOf(output), bytes)) ++answered_;
          }
        }) {}

  int answered() const { return answered_; }
  int skipped() const { return skipped_; }

 private:
  std::atomic<int> answered_ = 0;
  std::atomic<int> skipped_ = 0;
  Mailbox<FrameId> newest_;
  Publisher publisher_;
  Receiver receiver_;
  std::jthread thread_;
};

// The synthetic scene's frames, stamped when they are sent.
class Frames {
 public:
  explicit Frames(Graph& graph) : graph_(graph) {
    const auto source = scenes::OpenDataset("synthetic:64x48");
    rig_ = source->rig();
    frame_ = source->Get(0);
  }

  void Send() {
    graph_.PublishFrame(NowUtime(), sent_++, rig_, frame_.left, frame_.right, frame_.tof);
  }

  int sent() const { return static_cast<int>(sent_); }

 private:
  Graph& graph_;
  Rig rig_;
  scenes::DatasetFrame frame_;
  int64_t sent_ = 0;
};

// Of refine, once everything that was sent is counted, as answered or as skipped.
StageStatus StatusAfter(Graph& graph, int sent) {
  StageStatus status;
  EXPECT_TRUE(graph.WaitUntil([&](Graph& g) {
    status = g.statuses["refine"];
    return status.frames_out + status.frames_skipped == sent;
  })) << status.frames_out
      << " answered, " << status.frames_skipped << " skipped of " << sent;
  return status;
}

// Prior takes 150 ms, growth 200, and 20 frames a second come: what cannot be answered is dropped
// by refine, before it works on it.
TEST(OverloadSystem, FramesAreDroppedAtTheFirstStage) {
  constexpr milliseconds kInterval{50};
  Graph graph("", kDefaultLcmUrl, {kStatusChannel});
  graph.Start("refine", {"--config", "paper"});  // the fastest
  Frames frames(graph);
  const DisparityImage map(cv::Size(64, 48));
  SleepingStage prior(Part::kSeeds, Part::kPrior, PriorMap(cv::Size(64, 48)), milliseconds(150));
  SleepingStage grow(Part::kPrior, Part::kDisparity, map, milliseconds(200));
  const auto send_for = [&](std::chrono::seconds time) {
    const auto end = std::chrono::steady_clock::now() + time;
    for (auto due = std::chrono::steady_clock::now(); due < end; due += kInterval) {
      std::this_thread::sleep_until(due);
      frames.Send();
    }
  };
  send_for(std::chrono::seconds(2));  // until answers have come any number may be under way
  const StageStatus before = StatusAfter(graph, frames.sent());
  const int skipped_before = prior.skipped() + grow.skipped();
  const int answered_before = grow.answered();
  send_for(std::chrono::seconds(5));
  const StageStatus after = StatusAfter(graph, frames.sent());
  const int answered = grow.answered() - answered_before;
  const int skipped_behind = prior.skipped() + grow.skipped() - skipped_before;
  EXPECT_GT(answered, 10);
  // None on an idle machine, some 70 without the rule.
  EXPECT_LT(skipped_behind, answered / 4);
  EXPECT_GT(after.frames_skipped - before.frames_skipped, answered);
}

// Refine alone, with growth that ends while it is waited for.
TEST(OverloadSystem, AFirstStageWithoutALastOneIsNotStarved) {
  Graph graph("", kDefaultLcmUrl, {kStatusChannel});
  graph.Start("refine", {"--config", "paper"});  // the fastest
  Frames frames(graph);
  const auto send = [&](int count) {
    for (int i = 0; i < count; ++i) {
      frames.Send();
      std::this_thread::sleep_for(milliseconds(50));
    }
  };
  const DisparityImage map(cv::Size(64, 48));
  {
    const SleepingStage chain(Part::kSeeds, Part::kDisparity, map, milliseconds(200));
    send(40);
    EXPECT_GT(chain.answered(), 3);
  }
  const StageStatus before = StatusAfter(graph, frames.sent());
  EXPECT_GT(before.frames_skipped, 0);
  send(100);
  const StageStatus after = StatusAfter(graph, frames.sent());
  // On an idle machine it gives up after less than 2 of the 5 s.
  EXPECT_GT(after.frames_out - before.frames_out, 20);
}

}  // namespace
}  // namespace sprout
