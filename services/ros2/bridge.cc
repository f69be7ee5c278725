#include "services/ros2/bridge.h"

#include <algorithm>
#include <cctype>
#include <exception>
#include <utility>

#include "common/app/status_board.h"
#include "common/bus/channels.h"
#include "common/ros/compressed.h"

namespace sprout::ros2 {
namespace {

// Calibrations that are kept, for frames that are still under way.
constexpr size_t kMaxRigs = 8;
constexpr size_t kMaxStatuses = 64;

// "/robot/front": what ROS allows.
void RequirePrefix(const std::string& prefix) {
  const auto is_of_name = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '/';
  };
  const bool is_name =
      prefix.size() > 1 && prefix.size() <= 128 && prefix.front() == '/' && prefix.back() != '/' &&
      std::isdigit(static_cast<unsigned char>(prefix[1])) == 0 &&
      prefix.find("//") == std::string::npos && std::ranges::all_of(prefix, is_of_name);
  if (is_name) return;
  throw ConfigError("ros2.prefix = '" + prefix +
                    "': allowed are names as /robot/front, of letters, digits and '_'");
}

// A transform needs two frames of different names.
void RequireOwnFrames(const Ros2Config& config) {
  const std::set<std::string> frames = {config.left_frame(), config.right_frame(),
                                        config.tof_frame()};
  if (frames.size() == 3) return;
  throw ConfigError(
      "ros2.left_frame, right_frame, tof_frame = '" + config.left_frame() + "', '" +
      config.right_frame() + "', '" + config.tof_frame() +
      "': allowed are names that differ, since /tf_static says how these frames stand");
}

void RequireFrame(const char* field, const std::string& frame) {
  if (!frame.empty() && frame.front() != '/' && frame.size() <= 128) return;
  throw ConfigError(std::string("ros2.") + field + " = '" + frame +
                    "': allowed are 1 to 128 characters without a '/' in front");
}

// The rows of the topics that the configuration names.
std::vector<const RosTopicRow*> ChosenTopics(const Ros2Config& config) {
  std::vector<const RosTopicRow*> chosen;
  std::string all;
  for (const RosTopicRow& row : RosTopicRows()) {
    const bool is_named = std::ranges::count(config.topics(), row.name) > 0;
    if (config.topics().empty() || is_named) chosen.push_back(&row);
    all += " " + std::string(row.name);
  }
  for (const std::string& name : config.topics()) {
    if (std::ranges::count(RosTopicRows(), name, &RosTopicRow::name) > 0) continue;
    throw ConfigError("ros2.topics = '" + name + "': allowed are" + all);
  }
  return chosen;
}

// A reliable topic keeps its newest messages for slow subscribers: a second at 10 Hz, 40 MB of 2 MP
// depth. It never keeps all, or one subscriber that died would stop the others.
RosQos QosOf(const RosTopicRow& row, bool reliable) {
  if (row.topic == RosTopic::kTransforms) return {.reliable = true, .latched = true, .depth = 1};
  return {
      .reliable = row.topic == RosTopic::kDiagnostics || reliable, .latched = false, .depth = 10};
}

// What ROS's image_transport appends to a topic's name; empty for topics that are not compressed.
std::string_view CompressedSuffix(const RosTopicRow& row) {
  if (row.topic == RosTopic::kLeft || row.topic == RosTopic::kRight) return "/compressed";
  return row.topic == RosTopic::kDepth ? "/compressedDepth" : "";
}

}  // namespace

Bridge::Bridge(const Ros2Config& config, const DepthConfig& depth, StageMonitor& monitor)
    : config_(config),
      depth_every_(depth.every()),
      cloud_stride_(depth.cloud_stride()),
      monitor_(monitor),
      options_{.frames = {config.left_frame(), config.right_frame(), config.tof_frame()},
               .depth = config.depth_encoding() == Ros2Config::METRES ? RosDepth::kMetres
                                                                      : RosDepth::kMillimetres},
      node_((RequireInRange(config, "ros2"),
             RosNodeOptions{.domain = config.domain(), .name = "sprout"})) {
  RequirePrefix(config.prefix());
  RequireFrame("left_frame", config.left_frame());
  RequireFrame("right_frame", config.right_frame());
  RequireFrame("tof_frame", config.tof_frame());
  RequireOwnFrames(config);
  for (const RosTopicRow* row : ChosenTopics(config)) {
    const std::string name = RosTopicName(*row, config.prefix());
    const RosQos qos = QosOf(*row, config.reliable());
    topics_.push_back({row, name, false, node_.AddWriter(name, row->type(), qos)});
    const std::string_view suffix = CompressedSuffix(*row);
    if (!config.compressed() || suffix.empty()) continue;
    const std::string beside = name + std::string(suffix);
    topics_.push_back(
        {row, beside, true, node_.AddWriter(beside, RosTypeOf<RosCompressedImage>(), qos)});
  }
  node_.Announce();
}

bool Bridge::IsWanted(Part part) const {
  return std::ranges::any_of(topics_, [&](const Topic& topic) {
    return topic.row->part == part && node_.HasReaders(topic.writer);
  });
}

std::set<std::string_view> Bridge::WantedChannels() const {
  std::set<std::string_view> channels = {ChannelOf(Part::kRig), kStatusChannel};
  for (const Topic& topic : topics_) {
    if (node_.HasReaders(topic.writer)) channels.insert(ChannelOf(topic.row->part));
  }
  return channels;
}

void Bridge::ReceivesOnly(const std::set<std::string_view>& channels) {
  const std::scoped_lock lock(mutex_);
  for (auto it = gaps_.begin(); it != gaps_.end();) {
    if (channels.contains(ChannelOf(it->first))) {
      ++it;
    } else {
      earlier_gaps_ += it->second.count();
      it = gaps_.erase(it);
    }
  }
}

void Bridge::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  try {
    if (channel == kStatusChannel) return OnStatus(bytes);
    if (channel == ChannelOf(Part::kRig)) return OnRig(bytes);
    if (const std::optional<Part> part = PartOf(channel)) OnPart(*part, bytes);
  } catch (const std::exception& e) {  // out of memory
    monitor_.BadMessage(channel, e.what());
  }
}

void Bridge::OnStatus(std::span<const uint8_t> bytes) {
  const Result<StageStatus> status = DecodeStatus(bytes);
  if (!status) return monitor_.BadMessage(kStatusChannel, status.error().text);
  const std::scoped_lock lock(mutex_);
  const auto now = Clock::now();
  if (statuses_.size() == kMaxStatuses && !statuses_.contains(status->stage)) {
    std::erase_if(statuses_, [&](const auto& entry) {  // those that have ended make room
      return entry.second.status.state == StageStatus::State::kStopped ||
             now - entry.second.when > StatusBoard::kStaleAfter;
    });
    if (statuses_.size() == kMaxStatuses) {
      return monitor_.BadMessage(kStatusChannel, "of more stages than are shown");
    }
  }
  statuses_.insert_or_assign(status->stage, Heard{.status = *status, .when = now});
}

void Bridge::OnRig(std::span<const uint8_t> bytes) {
  const Result<DecodedPart> rig = DecodePart(Part::kRig, bytes);
  if (!rig) return monitor_.BadMessage(ChannelOf(Part::kRig), rig.error().text);
  const std::scoped_lock lock(mutex_);
  if (rig->id.rig_id == newest_rig_) return;  // the same again, each second
  newest_rig_ = rig->id.rig_id;
  rigs_.insert_or_assign(newest_rig_, std::get<Rig>(rig->value));
  std::erase(rig_order_, newest_rig_);
  rig_order_.push_back(newest_rig_);
  if (rig_order_.size() > kMaxRigs) {
    rigs_.erase(rig_order_.front());
    rig_order_.pop_front();
  }
  // /tf_static is latched: a later subscriber gets it as well.
  for (const Topic& topic : topics_) {
    if (topic.row->topic != RosTopic::kTransforms) continue;
    const auto message = ToRos(topic.row->topic, rig->id, rig->value, nullptr, options_);
    Publish(topic, rig->id, *message);
  }
}

// Counts the frame numbers of a part that the bus or a stage lost.
void Bridge::CountGaps(Part part, const FrameId& id) {
  FrameId step = id;
  if (IsOfDepth(part)) step.seq /= depth_every_;
  const std::scoped_lock lock(mutex_);
  gaps_[part].Add(step);
  int64_t gaps = earlier_gaps_;
  for (const auto& [of_part, seen] : gaps_) gaps += seen.count();
  monitor_.SetJoinerCounts(/*incomplete=*/0, gaps);
}

void Bridge::OnPart(Part part, std::span<const uint8_t> bytes) {
  if (!IsWanted(part)) return;
  const auto arrived = StageMonitor::Clock::now();
  if (const Result<FrameId> id = DecodeFrameId(bytes)) {
    CountGaps(part, *id);
    if (id->seq % config_.every() != 0) return;
  }
  const Result<DecodedPart> decoded = DecodePart(part, bytes);
  if (!decoded) return monitor_.BadMessage(ChannelOf(part), decoded.error().text);
  monitor_.FrameIn(/*skipped=*/false);
  const std::scoped_lock lock(mutex_);
  const auto rig = rigs_.find(decoded->id.rig_id);
  const Rig* const known = rig == rigs_.end() ? nullptr : &rig->second;
  std::string lacking;
  bool is_sent = true;
  for (const Topic& topic : topics_) {
    const RosTopicRow& row = *topic.row;
    if (row.part != part || !node_.HasReaders(topic.writer)) continue;
    const bool is_ordered = row.topic == RosTopic::kPoints && config_.ordered_points();
    if ((row.needs_rig || is_ordered) && known == nullptr) {
      lacking = "no calibration for " + std::string(row.name);
      continue;
    }
    Result<AnyRosMessagePtr> message =
        is_ordered ? OrderedPoints(*decoded, *known) : Converted(topic, *decoded, known);
    if (!message) {
      monitor_.FrameFailed(decoded->id, std::string(row.name) + ": " + message.error().text);
      is_sent = false;
    } else if (*message) {
      is_sent = Publish(topic, decoded->id, **message) && is_sent;
    }
  }
  if (is_sent) monitor_.FrameOut(decoded->id, arrived, lacking);
}

Result<AnyRosMessagePtr> Bridge::OrderedPoints(const DecodedPart& cloud, const Rig& rig) const {
  auto message = ToRosOrderedCloud({cloud.id.utime, config_.left_frame()},
                                   std::get<PointCloud>(cloud.value), rig.pair, cloud_stride_);
  if (!message) return tl::unexpected(message.error());
  return std::make_unique<RosMessage<RosPointCloud>>(std::move(*message));
}

AnyRosMessagePtr Bridge::Converted(const Topic& topic, const DecodedPart& part,
                                   const Rig* rig) const {
  if (!topic.is_compressed) {
    return ToRos(topic.row->topic, part.id, part.value, rig, options_);
  }
  using Compressed = RosMessage<RosCompressedImage>;
  const RosPlace left{part.id.utime, config_.left_frame()};
  if (topic.row->topic == RosTopic::kDepth) {
    return std::make_unique<Compressed>(
        ToRosCompressedDepth(left, std::get<DepthImage>(part.value)));
  }
  const RosPlace right{part.id.utime, config_.right_frame()};
  const cv::Mat& picture = std::get<cv::Mat>(part.value);
  if (picture.empty()) return nullptr;
  return std::make_unique<Compressed>(
      ToRosJpeg(topic.row->topic == RosTopic::kLeft ? left : right, picture));
}

bool Bridge::Publish(const Topic& topic, const FrameId& id, const AnyRosMessage& message) {
  ++converted_;
  const Result<void> sent = node_.Write(topic.writer, message);
  if (!sent) {
    monitor_.FrameFailed(id, topic.name + ": " + sent.error().text);
  }
  return sent.has_value();
}

void Bridge::WarnOfMisfits() {
  for (const Topic& topic : topics_) {
    const std::string policy = node_.TakeMisfit(topic.writer);
    if (policy.empty()) continue;
    monitor_.Warn("a subscriber of " + topic.name +
                  " gets nothing: it asks for more than is offered (" + policy + ")" +
                  (policy == "RELIABILITY" ? "; allowed with ros2 { reliable: true }" : ""));
  }
}

void Bridge::PublishDiagnostics() {
  WarnOfMisfits();
  const std::scoped_lock lock(mutex_);
  for (const Topic& topic : topics_) {
    if (topic.row->topic != RosTopic::kDiagnostics || !node_.HasReaders(topic.writer)) continue;
    std::map<std::string, RosHealth> health;
    for (const auto& [stage, heard] : statuses_) {
      const auto silence = Clock::now() - heard.when;
      const bool is_silent = silence > StatusBoard::kStaleAfter;
      health[stage] = {
          .status = heard.status,
          .silent_s = is_silent ? std::chrono::duration<double>(silence).count() : 0.0};
    }
    Publish(topic, {}, ToRosDiagnostics(NowUtime(), health));
  }
}

}  // namespace sprout::ros2
