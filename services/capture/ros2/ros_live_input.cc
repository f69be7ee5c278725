#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <vector>

#include "common/config/config_error.h"
#include "common/ros2/ros_node.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kSilence{5};
constexpr std::chrono::seconds kReminder{60};
constexpr std::chrono::milliseconds kStopPoll{100};

const RosType& TypeOf(RosRole role, bool is_compressed) {
  return *TypesOf(role)[is_compressed ? 1 : 0];
}

bool NamesCompressed(RosRole role, const std::string& topic) {
  return TypesOf(role).size() > 1 &&
         (topic.ends_with("/compressed") || topic.ends_with("/compressedDepth"));
}

// A camera that is slower than the loop fills no more than this.
constexpr int kDepth = 8;

RosQos QosOf(RosRole role, const std::string& topic) {
  // /tf has no memory, whoever asks for it gets nothing.
  if (role == RosRole::kTf) {
    return {.reliable = true, .latched = topic.ends_with("/tf_static"), .depth = 100};
  }
  return {.reliable = false, .latched = false, .depth = kDepth};
}

struct LiveTopic {
  RosRole role;
  std::string name;
  bool is_compressed;
  RosNode::Handle reader;
  Clock::time_point heard;
  Clock::time_point next_reminder;
  int told_publishers = 1;
};

class LiveInput : public RosInput {
 public:
  LiveInput(const RosSettings& settings, TellPeople tell, datasets::Waiting waiting)
      : tell_(std::move(tell)), waiting_(std::move(waiting)), node_(settings.domain) {
    const auto now = Clock::now();
    for (const RosRole role : kAllRosRoles) {
      for (const std::string& topic : settings.TopicsOf(role)) {
        const bool is_compressed = NamesCompressed(role, topic);
        const RosNode::Handle reader =
            node_.AddReader(topic, TypeOf(role, is_compressed), QosOf(role, topic));
        topics_.push_back({role, topic, is_compressed, reader, now, now + kSilence});
      }
    }
    next_look_ = now + std::chrono::seconds(1);
  }

  bool is_live() const override { return true; }

  bool Next(RosBytes& message, const std::stop_token& stop) override {
    while (!stop.stop_requested()) {
      if (waiting_) waiting_();
      LookAround();
      // In turn, so that no topic waits for another one.
      for (size_t i = 0; i < topics_.size(); ++i) {
        next_ = (next_ + 1) % topics_.size();
        LiveTopic& topic = topics_[next_];
        if (!node_.Take(topic.reader, cdr_)) continue;
        topic.heard = Clock::now();
        topic.next_reminder = topic.heard + kSilence;
        message = {.role = topic.role, .is_compressed = topic.is_compressed, .cdr = cdr_};
        return true;
      }
      node_.Wait(kStopPoll);
    }
    return false;
  }

  std::string Instead(RosRole role) override {
    const auto topic = std::ranges::find(topics_, role, &LiveTopic::role);
    return topic == topics_.end() ? "" : PublishersText(*topic);
  }

 private:
  std::string PublishersText(const LiveTopic& topic) const {
    const RosType& type = TypeOf(topic.role, topic.is_compressed);
    const RosNode::Publishers there = node_.PublishersOf(topic.name, type);
    if (there.of_others > 0) {
      return fmt::format("{} publishers, {} of other types such as {}; allowed is {}",
                         there.of_type + there.of_others, there.of_others, there.other_type,
                         type.name);
    }
    return there.of_type == 0 ? "no publisher" : fmt::format("{} publishers", there.of_type);
  }

  // Once a second.
  void LookAround() {
    const auto now = Clock::now();
    if (now < next_look_) return;
    next_look_ = now + std::chrono::seconds(1);
    for (LiveTopic& topic : topics_) {
      if (topic.role == RosRole::kTf) continue;  // once is enough
      if (now >= topic.next_reminder) {
        const auto silence = std::chrono::duration_cast<std::chrono::seconds>(now - topic.heard);
        tell_(fmt::format("no message on {} for {} s; {}", topic.name, silence.count(),
                          PublishersText(topic)));
        topic.next_reminder = now + kReminder;
      }
      const int count =
          node_.PublishersOf(topic.name, TypeOf(topic.role, topic.is_compressed)).of_type;
      if (count > 1 && count != topic.told_publishers) {
        tell_(fmt::format("{} publishers on {}; allowed is one", count, topic.name));
      }
      topic.told_publishers = std::max(count, 1);
    }
  }

  TellPeople tell_;
  datasets::Waiting waiting_;
  RosNode node_;
  std::vector<LiveTopic> topics_;
  std::vector<uint8_t> cdr_;
  size_t next_ = 0;
  Clock::time_point next_look_;
};

}  // namespace

std::unique_ptr<RosInput> ListenToRos(const RosSettings& settings, TellPeople tell,
                                      datasets::Waiting waiting) {
  try {
    return std::make_unique<LiveInput>(settings, std::move(tell), std::move(waiting));
  } catch (const RosError& e) {
    throw ConfigError(std::string("capture.source = ros2: ") + e.what());
  }
}

}  // namespace sprout::capture
