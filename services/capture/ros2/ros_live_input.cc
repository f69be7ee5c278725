#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/config/config_error.h"
#include "common/core/printable.h"
#include "common/ros/ros_node.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {
namespace {

using Clock = RosInput::Clock;
constexpr std::chrono::seconds kSilence{5};
constexpr std::chrono::seconds kReminder{60};
constexpr std::chrono::milliseconds kStopPoll{100};
// A publisher that sent nothing for so long does not count as one of several.
constexpr std::chrono::seconds kPublisherLives{2};

const RosType& TypeOf(RosRole role, bool is_compressed) {
  return *TypesOf(role)[is_compressed ? 1 : 0];
}

bool NamesCompressed(RosRole role, const std::string& topic) {
  return TypesOf(role).size() > 1 &&
         (topic.ends_with("/compressed") || topic.ends_with("/compressedDepth"));
}

bool IsImage(RosRole role) {
  return role == RosRole::kLeft || role == RosRole::kRight || role == RosRole::kDepth;
}

bool IsCalibration(RosRole role) { return !IsImage(role) && role != RosRole::kPoints; }

// The best quality of service, tried first. A camera that is faster than the loop fills no more
// than `depth` messages.
RosQos BestQos(RosRole role, const std::string& topic) {
  // /tf is not latched: a reader that wants it latched gets nothing.
  if (role == RosRole::kTf) {
    return {.reliable = true, .latched = topic.ends_with("/tf_static"), .depth = 100};
  }
  return {.reliable = true, .latched = IsCalibration(role), .depth = 8};
}

RosQos Compatible(RosQos wanted, const RosQos& offered) {
  wanted.reliable = wanted.reliable && offered.reliable;
  wanted.latched = wanted.latched && offered.latched;
  return wanted;
}

// When a publisher sent its first and its newest message.
struct Heard {
  Clock::time_point first;
  Clock::time_point newest;
};

struct LiveTopic {
  RosRole role;
  std::string name;
  bool is_compressed;
  size_t max_bytes;
  RosQos qos = {};
  RosNode::Handle reader = 0;
  Clock::time_point heard = {};
  Clock::time_point next_reminder = {};
  bool was_heard = false;
  std::map<uint64_t, Heard> publishers = {};
  size_t told_publishers = 1;

  const RosType& type() const { return TypeOf(role, is_compressed); }
};

// How many send at one time: one that was started again has taken the place of the one before.
size_t CountAtOnce(const std::map<uint64_t, Heard>& publishers) {
  Clock::time_point newest_begin{};
  for (const auto& [number, heard] : publishers) newest_begin = std::max(newest_begin, heard.first);
  return static_cast<size_t>(std::ranges::count_if(
      publishers, [&](const auto& one) { return one.second.newest >= newest_begin; }));
}

class LiveInput : public RosInput {
 public:
  LiveInput(const RosSettings& settings, RosReports reports, scenes::Waiting waiting)
      : settings_(settings), reports_(std::move(reports)), waiting_(std::move(waiting)) {
    // A cloud says in which frame its points are.
    if (settings_.rig.empty()) Open(RosLimits(), [](RosRole role) { return !IsImage(role); });
  }

  bool is_live() const override { return true; }

  // DDS takes no larger message than the domain was told at its begin, so it begins again.
  void StartImages(const RosLimits& limits) override {
    topics_.clear();
    node_.reset();
    Open(limits, [this](RosRole role) { return settings_.rig.empty() || !IsCalibration(role); });
  }

  bool Next(RosBytes& message, const std::stop_token& stop, Clock::time_point deadline) override {
    while (!stop.stop_requested()) {
      if (waiting_) waiting_("");
      CheckTopics();
      // Topics are read in turn, so that none waits for another one.
      for (size_t i = 0; i < topics_.size(); ++i) {
        next_ = (next_ + 1) % topics_.size();
        if (Take(topics_[next_], message)) return true;
      }
      const auto now = Clock::now();
      if (now >= deadline) break;
      node_->Wait(
          std::min(kStopPoll, std::chrono::ceil<std::chrono::milliseconds>(deadline - now)));
    }
    return false;
  }

  std::string Alternatives(RosRole role) override {
    const auto topic = std::ranges::find(topics_, role, &LiveTopic::role);
    return topic == topics_.end() ? "" : PublishersText(*topic);
  }

 private:
  void Open(const RosLimits& limits, const std::function<bool(RosRole)>& is_wanted) {
    // CameraInfo and /tf_static are small, but not that small.
    constexpr size_t kMinBytes = size_t{1} << 20;
    const size_t of_points = settings_.points.empty() ? 0 : limits.range_bytes;
    const size_t most = std::max({limits.image_bytes, of_points, kMinBytes});
    try {
      node_.emplace(RosNodeOptions{.domain = settings_.domain,
                                   .name = "sprout_capture",
                                   .max_message_bytes = static_cast<uint32_t>(most)});
      for (const RosRole role : kAllRosRoles) {
        if (!is_wanted(role)) continue;
        for (const std::string& topic : settings_.TopicsOf(role)) Add(role, topic, limits);
      }
      node_->Announce();
    } catch (const ConfigError& e) {
      throw ConfigError(std::string("capture.source = ros2: ") + e.what());
    }
    next_look_ = Clock::now() + std::chrono::seconds(1);
  }

  void Add(RosRole role, const std::string& name, const RosLimits& limits) {
    const auto now = Clock::now();
    LiveTopic topic{.role = role,
                    .name = name,
                    .is_compressed = NamesCompressed(role, name),
                    .max_bytes = IsImage(role) ? limits.image_bytes : limits.range_bytes,
                    .qos = BestQos(role, name),
                    .heard = now,
                    .next_reminder = now + kSilence};
    topic.reader = node_->AddReader(name, topic.type(), topic.qos);
    topics_.push_back(std::move(topic));
  }

  bool Take(LiveTopic& topic, RosBytes& message) {
    const std::optional<RosNode::Taken> taken = node_->Take(topic.reader, topic.max_bytes, cdr_);
    ReportReplaced(topic);
    if (!taken) return false;
    topic.heard = Clock::now();
    topic.was_heard = true;
    topic.next_reminder = topic.heard + kSilence;
    topic.publishers.try_emplace(taken->publisher, Heard{.first = topic.heard, .newest = {}})
        .first->second.newest = topic.heard;
    if (taken->is_too_big) {
      reports_.Refuse(topic.name,
                      fmt::format("{} bytes: allowed are up to {} with this calibration",
                                  taken->bytes, topic.max_bytes));
      return false;
    }
    message = {.role = topic.role, .is_compressed = topic.is_compressed, .cdr = cdr_};
    return true;
  }

  // Reports images and points that were lost here, but none from before the first one was taken.
  void ReportReplaced(LiveTopic& topic) {
    const int64_t replaced = node_->TakeReplaced(topic.reader);
    if (!topic.was_heard || IsCalibration(topic.role)) return;
    for (int64_t i = 0; i < replaced; ++i) {
      reports_.Refuse(topic.name, "came faster than messages are taken, or while nothing ran here");
    }
  }

  std::string PublishersText(const LiveTopic& topic) {
    const RosNode::Publishers there = node_->PublishersOf(topic.name, topic.type());
    if (there.of_others > 0) {
      return fmt::format("{} publishers, {} of other types such as {}; allowed is {}",
                         there.of_type + there.of_others, there.of_others, there.other_type,
                         topic.type().name);
    }
    return there.of_type == 0 ? OthersText(topic) : fmt::format("{} publishers", there.of_type);
  }

  // Lists the topics that there are, beside which a mistyped name is seen.
  std::string OthersText(const LiveTopic& topic) {
    constexpr size_t kMaxListed = 20;
    const std::set<std::string> there = node_->TopicsOf(topic.type());
    std::string text = fmt::format(
        "no publisher in domain {}; topics of {} there:", settings_.domain, topic.type().name);
    size_t count = 0;
    for (const std::string& name : there) {
      if (++count <= kMaxListed) text += " " + Printable(name);
    }
    if (count == 0) text += " none";
    if (count > kMaxListed) text += fmt::format(" and {} more", count - kMaxListed);
    return text;
  }

  // Asks for what publishers offer: as soon as DDS could not connect one of them to our reader, and
  // each second, in case a publisher that offers more has taken its place.
  void AdaptQos(LiveTopic& topic, const RosNode::Publishers& there) {
    // /tf_static may have several publishers; the latched ones count.
    if (there.of_type == 0 || (topic.role == RosRole::kTf && there.of_type > 1)) return;
    const RosQos fitting = Compatible(BestQos(topic.role, topic.name), there.offered);
    if (fitting == topic.qos) return;
    node_->RemoveReader(topic.reader);
    topic.qos = fitting;
    topic.reader = node_->AddReader(topic.name, topic.type(), topic.qos);
    node_->Announce();
  }

  void CheckTopics() {
    for (LiveTopic& topic : topics_) {
      const std::string policy = node_->TakeMisfit(topic.reader);
      if (policy.empty()) continue;
      const RosQos before = topic.qos;
      const RosNode::Publishers there = node_->PublishersOf(topic.name, topic.type());
      AdaptQos(topic, there);
      // DDS compares policies of other types, too.
      if (topic.qos == before && there.of_type > 0) {
        reports_.tell(
            fmt::format("a publisher of {} cannot be heard: it offers less {} than is needed",
                        topic.name, policy));
      }
    }
    const auto now = Clock::now();
    if (now < next_look_) return;
    next_look_ = now + std::chrono::seconds(1);
    for (LiveTopic& topic : topics_) CheckTopic(topic, now);
  }

  void CheckTopic(LiveTopic& topic, Clock::time_point now) {
    std::erase_if(topic.publishers,
                  [&](const auto& one) { return one.second.newest + kPublisherLives < now; });
    if (topic.role == RosRole::kTf) return;  // transforms may come once, and from several nodes
    AdaptQos(topic, node_->PublishersOf(topic.name, topic.type()));
    // A latched calibration needs no second message.
    const bool is_known = topic.qos.latched && topic.was_heard;
    if (now >= topic.next_reminder && !is_known) {
      const auto silence = std::chrono::duration_cast<std::chrono::seconds>(now - topic.heard);
      reports_.tell(fmt::format("no message on {} for {} s; {}", topic.name, silence.count(),
                                PublishersText(topic)));
      topic.next_reminder = now + kReminder;
    }
    const size_t count = CountAtOnce(topic.publishers);
    if (count > 1 && count != topic.told_publishers) {
      reports_.tell(fmt::format("{} publishers on {}; allowed is one", count, topic.name));
    }
    topic.told_publishers = std::max<size_t>(count, 1);
  }

  RosSettings settings_;
  RosReports reports_;
  scenes::Waiting waiting_;
  std::optional<RosNode> node_;
  std::vector<LiveTopic> topics_;
  std::vector<uint8_t> cdr_;
  size_t next_ = 0;
  Clock::time_point next_look_;
};

}  // namespace

std::unique_ptr<RosInput> ListenToRos(const RosSettings& settings, RosReports reports,
                                      scenes::Waiting waiting) {
  return std::make_unique<LiveInput>(settings, std::move(reports), std::move(waiting));
}

}  // namespace sprout::capture
