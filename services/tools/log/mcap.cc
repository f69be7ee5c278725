// What sprout-log knows of MCAP: export --mcap, a log as ROS 2's messages, and info of a file such
// as rosbag2 writes.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "common/app/version.h"
#include "common/bus/channels.h"
#include "common/config/frame_range.h"
#include "common/config/required.h"
#include "common/core/printable.h"
#include "common/logfile/log_reader.h"
#include "common/messages/message_type.h"
#include "common/ros/frame_topics.h"
#include "common/ros/mcap_reader.h"
#include "common/ros/mcap_writer.h"
#include "services/tools/log/channel_summary.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/print_line.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {
namespace {

constexpr std::string_view kPrefix = "/sprout";

// What rosbag2 offers when it plays a latched topic, in its own words: every reader gets the
// newest.
constexpr char kLatchedQos[] = R"(- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: 1
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false
)";

// The calibrations of a log, also those that stand behind the frames that name them. Reads ahead
// until it meets the one that is asked for.
class RigBook {
 public:
  RigBook(const std::filesystem::path& path, std::string channel)
      : reader_(path), channel_(std::move(channel)) {}

  // Null when the log has none of this name.
  const Rig* Find(const std::string& rig_id) {
    for (LogEvent event; !rigs_.contains(rig_id) && reader_.Next(event);) {
      if (event.channel != channel_) continue;
      Result<DecodedPart> part = DecodePart(Part::kRig, event.data);
      if (part) rigs_.emplace(part->id.rig_id, std::get<Rig>(std::move(part->value)));
    }
    const auto found = rigs_.find(rig_id);
    return found == rigs_.end() ? nullptr : &found->second;
  }

 private:
  LogReader reader_;
  std::string channel_;
  std::map<std::string, Rig> rigs_;
};

// The MCAP file, to which a channel is added with the first message of its topic.
class RosFile {
 public:
  explicit RosFile(const std::filesystem::path& path)
      : writer_(path, {.profile = "ros2", .library = "sprout " + Version()}) {}

  void Write(RosTopic topic, int64_t seq, int64_t utime, const AnyRosMessage& message) {
    WriteCdr(message, cdr_);
    const auto time_ns = static_cast<uint64_t>(std::max<int64_t>(utime, 0)) * 1000;
    writer_.Write(ChannelOf(topic), static_cast<uint32_t>(seq), time_ns, cdr_);
  }

  McapWriter& writer() { return writer_; }

 private:
  uint16_t ChannelOf(RosTopic topic) {
    const auto [channel, is_new] = channels_.try_emplace(topic);
    if (!is_new) return channel->second;
    const RosTopicRow& row = RowOf(topic);
    const RosType& type = row.type();
    const auto [schema, is_new_type] = schemas_.try_emplace(&type);
    if (is_new_type) schema->second = writer_.AddSchema(type.name, "ros2msg", RosSchema(type));
    std::map<std::string, std::string> metadata;
    if (topic == RosTopic::kTransforms) metadata["offered_qos_profiles"] = kLatchedQos;
    channel->second =
        writer_.AddChannel(schema->second, RosTopicName(row, kPrefix), "cdr", std::move(metadata));
    return channel->second;
  }

  McapWriter writer_;
  std::map<RosTopic, uint16_t> channels_;
  std::map<const RosType*, uint16_t> schemas_;
  std::vector<uint8_t> cdr_;
};

class McapExporter {
 public:
  McapExporter(const PicturesOptions& options, const std::filesystem::path& out)
      : options_(options),
        rigs_(options.file, options.prefix + std::string(ChannelOf(Part::kRig))),
        file_(out) {
    if (!options.frames.empty()) frames_ = ParseFrameRange("--frames", options.frames);
  }

  void Take(const LogEvent& event) {
    if (!event.channel.starts_with(options_.prefix)) {
      if (TypeOfChannel(event.channel)) other_channel_ = event.channel;
      return;
    }
    const std::string_view channel = event.channel.substr(options_.prefix.size());
    if (channel == kStatusChannel) return TakeStatus(event);
    if (channel == kProcessChannel) return processes_.Add(event.data);
    if (const std::optional<Part> part = PartOf(channel)) {
      TakePart(event, *part);
    } else if (channel != kRigChangeChannel && TypeOfChannel(event.channel)) {
      other_channel_ = event.channel;
    }
  }

  // What to look at when nothing was exported; begins with "; ", or is empty.
  std::string Hint() const {
    return other_channel_.empty()
               ? ""
               : "; there are channels as " + Printable(other_channel_) + ", see --channel-prefix";
  }

  // @returns one line about what could not be exported; empty: nothing.
  std::string Complaint() const {
    std::string text;
    if (refused_ > 0)
      text = fmt::format("undecodable messages: {}, the first {}", refused_, first_refused_);
    if (without_rig_ > 0) {
      text += fmt::format("{}{} messages whose calibration is not in the log",
                          text.empty() ? "" : "; ", without_rig_);
    }
    return text;
  }

  McapWriter& Finish() {
    for (const ProcessInfo& process : processes_.processes()) {
      file_.writer().AddMetadata("sprout process " + process.stage,
                                 {{"stage", process.stage},
                                  {"host", process.host},
                                  {"version", process.version},
                                  {"config_digest", process.config_digest},
                                  {"config", process.config_text}});
    }
    return file_.writer();
  }

 private:
  void Refuse(const LogEvent& event, const std::string& why) {
    if (refused_++ > 0) return;
    first_refused_ = fmt::format("{} at byte {}: {}", event.channel, event.offset, why);
  }

  void TakeStatus(const LogEvent& event) {
    const Result<StageStatus> status = DecodeStatus(event.data);
    if (!status) return Refuse(event, status.error().text);
    if (frames_ && !frames_->Has(status->newest_frame.seq)) return;
    const auto message = ToRosDiagnostics(event.utime, {{status->stage, {*status}}});
    file_.Write(RosTopic::kDiagnostics, status->newest_frame.seq, event.utime, message);
  }

  void TakePart(const LogEvent& event, Part part) {
    // Decoding takes time, so parts that no topic shows are skipped.
    const auto is_of_part = [part](const RosTopicRow& row) { return row.part == part; };
    if (std::ranges::none_of(RosTopicRows(), is_of_part)) return;
    if (frames_ && part != Part::kRig) {
      const Result<FrameId> id = DecodeFrameId(event.data);
      if (id && !frames_->Has(id->seq)) return;
    }
    const Result<DecodedPart> decoded = DecodePart(part, event.data);
    if (!decoded) return Refuse(event, decoded.error().text);
    // Calibrations are sent every second, and latched here.
    if (part == Part::kRig && std::exchange(latched_, decoded->id.rig_id) == decoded->id.rig_id) {
      return;
    }
    for (const RosTopicRow& row : RosTopicRows()) {
      if (!is_of_part(row) || row.topic == RosTopic::kDiagnostics) continue;
      const Rig* const rig = row.needs_rig ? rigs_.Find(decoded->id.rig_id) : nullptr;
      if (row.needs_rig && rig == nullptr) ++without_rig_;
      const auto message = ToRos(row.topic, decoded->id, decoded->value, rig, {});
      if (message) file_.Write(row.topic, decoded->id.seq, event.utime, *message);
    }
  }

  const PicturesOptions& options_;
  std::optional<FrameRange> frames_;
  RigBook rigs_;
  RosFile file_;
  ProcessSummary processes_;
  std::string latched_;  // rig_id
  int64_t refused_ = 0;
  std::string first_refused_;
  int64_t without_rig_ = 0;
  std::string other_channel_;  // of another prefix
};

struct TopicSummary {
  std::string type;
  std::string encoding;
  int64_t messages = 0;
  int64_t bytes = 0;
  uint64_t first_ns = 0;
  uint64_t last_ns = 0;

  // Messages a second; 0 when there are fewer than two times, since JSON has no NaN.
  double RateHz() const {
    const double seconds = static_cast<double>(last_ns - first_ns) / 1e9;
    return messages > 1 && seconds > 0 ? static_cast<double>(messages - 1) / seconds : 0;
  }
};

struct McapSummary {
  std::map<std::string, TopicSummary> topics;
  int64_t messages = 0;
};

McapSummary SummarizeMcap(McapReader& reader, const std::filesystem::path& path) {
  McapSummary summary;
  ReadProgress progress("reading " + path.string(), static_cast<int64_t>(reader.size()));
  for (McapMessage message; reader.Next(message);
       progress.Update(static_cast<int64_t>(reader.position()))) {
    TopicSummary& topic = summary.topics[message.channel->topic];
    topic.type = message.schema != nullptr ? message.schema->name : "";
    topic.encoding = message.channel->encoding;
    topic.first_ns =
        topic.messages == 0 ? message.log_time_ns : std::min(topic.first_ns, message.log_time_ns);
    topic.last_ns = std::max(topic.last_ns, message.log_time_ns);
    topic.bytes += static_cast<int64_t>(message.data.size());
    ++topic.messages;
    ++summary.messages;
  }
  progress.Clear();
  return summary;
}

std::string McapText(const McapSummary& summary, const McapReader& reader,
                     const InfoOptions& options) {
  size_t width = 5;
  for (const auto& [name, topic] : summary.topics) width = std::max(width, Printable(name).size());
  std::string text = fmt::format(
      "{}: {:.2f} MB, MCAP{} by {}, {} messages in {} chunks\n\n{:<{}}  {:<33} {:>8} {:>8} {:>9}\n",
      Printable(options.file.string()), static_cast<double>(reader.size()) / 1e6,
      reader.profile().empty() ? "" : " (" + Printable(reader.profile()) + ")",
      reader.library().empty() ? "?" : Printable(reader.library()), summary.messages,
      reader.chunks(), "topic", width, "type", "messages", "per s", "MB");
  for (const auto& [name, topic] : summary.topics) {
    text += fmt::format("{:<{}}  {:<33} {:>8} {:>8.2f} {:>9.2f}\n", Printable(name), width,
                        Printable(topic.type), topic.messages, topic.RateHz(),
                        static_cast<double>(topic.bytes) / 1e6);
  }
  for (const std::string& line : reader.trouble()) text += "damage: " + Printable(line) + "\n";
  const auto more = reader.trouble_count() - std::ssize(reader.trouble());
  if (more > 0) text += fmt::format("damage: and {} more\n", more);
  if (reader.trouble_count() == 0) text += "no damage\n";
  if (!options.config) return text;
  for (const auto& [name, values] : reader.Metadata()) {
    text += "\nmetadata " + Printable(name) + ":\n";
    for (const auto& [key, value] : values)
      text += Printable(key) + ": " + PrintableLines(value) + "\n";
  }
  return text;
}

std::string McapJson(const McapSummary& summary, const McapReader& reader,
                     const InfoOptions& options) {
  nlohmann::json topics = nlohmann::json::array();
  for (const auto& [name, topic] : summary.topics) {
    topics.push_back({{"name", name},
                      {"type", topic.type},
                      {"encoding", topic.encoding},
                      {"messages", topic.messages},
                      {"bytes", topic.bytes},
                      {"rate_hz", topic.RateHz()}});
  }
  const nlohmann::json json = {{"file", options.file.string()},
                               {"bytes", reader.size()},
                               {"profile", reader.profile()},
                               {"library", reader.library()},
                               {"messages", summary.messages},
                               {"whole", reader.trouble_count() == 0},
                               {"topics", topics},
                               {"metadata", reader.Metadata()},
                               {"damage", reader.trouble()}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

int RunMcapExport(const PicturesOptions& options, const std::filesystem::path& out, bool force) {
  std::error_code ignored;
  if (!force && std::filesystem::exists(out, ignored)) {
    throw LogError(out, "exists already; --force overwrites it");
  }
  LogReader reader(options.file);
  McapExporter exporter(options, out);
  ReadProgress progress("reading " + options.file.string(), reader.size());
  for (LogEvent event; reader.Next(event); progress.Update(reader.position())) exporter.Take(event);
  progress.Clear();
  WarnOfDamage(options.file, reader.damage());
  const std::string complaint = exporter.Complaint();
  if (!complaint.empty()) PrintWarning(options.file.string() + ": " + complaint);
  McapWriter& writer = exporter.Finish();
  if (writer.messages() == 0) {
    throw LogError(options.file, "no message of these frames that ROS knows" + exporter.Hint());
  }
  const uint64_t messages = writer.messages();
  Required(writer.Commit(), "export: ");
  PrintLine(fmt::format("{}: {} messages", out.string(), messages));
  return 0;
}

bool IsMcap(const std::filesystem::path& file) {
  std::error_code unreadable;  // reported when the file is opened
  if (std::filesystem::is_directory(file, unreadable) || file.string().ends_with(".mcap.zstd")) {
    return true;
  }
  // A FIFO would wait for its writer.
  if (!std::filesystem::is_regular_file(file, unreadable)) return false;
  std::ifstream stream(file, std::ios::binary);
  std::array<char, kMcapMagic.size()> begin{};
  stream.read(begin.data(), begin.size());
  return stream && std::string_view(begin.data(), begin.size()) == kMcapMagic;
}

int RunMcapInfo(const InfoOptions& options) {
  McapReader reader(McapParts(options.file.string()));
  const McapSummary summary = SummarizeMcap(reader, options.file);
  std::cout << (options.json ? McapJson(summary, reader, options)
                             : McapText(summary, reader, options));
  return options.check && reader.trouble_count() > 0 ? 1 : 0;
}

}  // namespace sprout::log
