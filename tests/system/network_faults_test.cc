// A bad network between capture and the stages: what is lost there is counted, and no map is wrong.
#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <memory>
#include <thread>

#include "tests/system/graph.h"
#include "tests/system/graph_record.h"
#include "tests/system/relay.h"

namespace sprout {
namespace {

std::string Url(uint16_t port) {
  return "udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0&recv_buf_size=67108864";
}

class NetworkFaultsSystem : public ::testing::Test {
 protected:
  NetworkFaultsSystem() {
    for (const char* stage : kChain) {
      Process& process = Start(stage, Url(Relay::kTo), {});
      EXPECT_TRUE(stages_.WaitUntil([pid = process.pid()](GraphRecord& r) {
        return r.statuses.contains(pid);
      })) << process.Output();
    }
  }

  Process& Start(const std::string& stage, const std::string& url,
                 const std::vector<std::string>& flags) {
    std::vector<std::string> command = {ProgramPath("sprout-" + stage), "--lcm-url", url,
                                        "--config", "default"};
    command.insert(command.end(), flags.begin(), flags.end());
    return *(processes_[stage] = std::make_unique<Process>(command));
  }

  // Whether a frame that is sent from now on comes through all stages.
  bool Delivers() {
    const size_t sent = Sent();
    return stages_.WaitUntil([&](GraphRecord& r) {
      const auto newest = r.frames.rbegin();
      return newest != r.frames.rend() && newest->second.at.contains(Part::kDisparity) &&
             newest->first.second >= static_cast<int64_t>(sent);
    });
  }

  size_t Sent() {
    size_t sent = 0;
    capture_.WaitUntil([&](GraphRecord& r) {
      sent = r.sent.size();
      return true;
    });
    return sent;
  }

  // Three seconds of it, between times when all is well.
  void Run(const NetworkFaults& faults) {
    Process& capture =
        Start("capture", Url(Relay::kFrom), {"--source", "synthetic:320x240", "--rate", "10"});
    ASSERT_TRUE(Delivers()) << capture.Output();
    relay_.Set(faults);
    std::this_thread::sleep_for(std::chrono::seconds(3));
    relay_.Set({});
    ASSERT_TRUE(Delivers());
    capture.Signal(SIGTERM);
    ASSERT_EQ(capture.Wait(), 0) << capture.Output();
    ASSERT_TRUE(capture_.WaitUntil([&](GraphRecord& r) {
      const StageStatus& status = r.statuses[capture.pid()];
      return status.state == StageStatus::State::kStopped &&
             status.frames_out == static_cast<int64_t>(r.sent.size());
    }));
  }

  // Every frame that was sent is answered or counted, by every stage.
  void ExpectBalance() {
    const auto sent = static_cast<int64_t>(Sent());
    for (const char* stage : kChain) {
      StageStatus status;
      EXPECT_TRUE(stages_.WaitUntil(
          [&](GraphRecord& r) {
            status = r.statuses[processes_.at(stage)->pid()];
            return status.newest_frame.seq == sent - 1 && AccountedFor(status) == sent;
          },
          std::chrono::seconds(10)))
          << stage << ": of " << sent << " frames " << status.frames_out << " answered, "
          << status.frames_skipped << " skipped, " << status.frames_incomplete << " incomplete, "
          << status.sequence_gaps << " left out, " << status.frames_failed << " failed";
      EXPECT_EQ(status.bad_messages, 0) << stage << ": " << status.last_error;
      counted_[stage] = status;
    }
  }

  // What the stages made, beside what capture sent.
  Comparison Compare() {
    std::map<GraphRecord::Key, GraphRecord::Heard> frames;
    capture_.WaitUntil([&](GraphRecord& r) {
      frames = r.frames;
      return true;
    });
    stages_.WaitUntil([&](GraphRecord& r) {
      for (auto& [key, heard] : frames) {
        const GraphRecord::Heard& answered = r.frames[key];
        if (!answered.at.contains(Part::kDisparity)) continue;
        heard.at.emplace(Part::kDisparity, answered.at.at(Part::kDisparity));
        heard.frame.disparity = answered.frame.disparity;
        heard.frame.confidence = answered.frame.confidence;
      }
      return true;
    });
    const Comparison comparison = CompareWithPipeline(frames, LoadConfig({"default"}));
    std::cout << Sent() << " frames sent, " << relay_.lost() << " of " << relay_.datagrams()
              << " datagrams lost, " << comparison.maps << " maps, " << comparison.wrong
              << " wrong; grow: " << counted_["grow"].frames_incomplete << " incomplete, "
              << counted_["grow"].sequence_gaps << " left out, " << counted_["grow"].frames_skipped
              << " skipped\n";
    return comparison;
  }

  void ExpectNoneWrong() {
    const Comparison comparison = Compare();
    EXPECT_GT(comparison.maps, 10);
    EXPECT_EQ(comparison.wrong, 0) << comparison.first_wrong;
    EXPECT_EQ(comparison.unknown, 0);
  }

  Relay relay_{1};
  GraphRecord capture_{Url(Relay::kFrom)};
  GraphRecord stages_{Url(Relay::kTo)};
  std::map<std::string, std::unique_ptr<Process>> processes_;
  std::map<std::string, StageStatus> counted_;
};

TEST_F(NetworkFaultsSystem, CountsWhatOnePercentLossTakes) {
  Run({.lost = 0.01});
  ExpectBalance();
  ExpectNoneWrong();
}

TEST_F(NetworkFaultsSystem, CountsWhatTenPercentLossTakes) {
  Run({.lost = 0.1});
  ExpectBalance();
  ExpectNoneWrong();
  EXPECT_GT(counted_["grow"].frames_incomplete, 0);
}

TEST_F(NetworkFaultsSystem, TakesDatagramsInAnotherOrder) {
  Run({.reordered = 0.1});
  ExpectBalance();
  ExpectNoneWrong();
}

TEST_F(NetworkFaultsSystem, TakesDatagramsTwice) {
  Run({.doubled = 0.1});
  ExpectBalance();
  ExpectNoneWrong();
}

TEST_F(NetworkFaultsSystem, TakesAllOfThatAtOnce) {
  Run({.lost = 0.01, .doubled = 0.05, .reordered = 0.05});
  ExpectBalance();
  ExpectNoneWrong();
}

}  // namespace
}  // namespace sprout
