// sprout-log info of an MCAP file, such as rosbag2 writes.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "common/config/config_error.h"
#include "common/core/printable.h"
#include "common/ros/mcap_parts.h"
#include "common/ros/mcap_reader.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {
namespace {

struct TopicSummary {
  std::string type;
  std::string encoding;
  int64_t messages = 0;
  int64_t bytes = 0;
  uint64_t first_ns = 0;
  uint64_t last_ns = 0;

  // NaN-free: 0 when it cannot be told.
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

bool IsMcap(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file) || file.string().ends_with(".mcap.zstd")) return true;
  std::ifstream stream(file, std::ios::binary);
  std::array<char, kMcapMagic.size()> begin{};
  stream.read(begin.data(), begin.size());
  return stream && std::string_view(begin.data(), begin.size()) == kMcapMagic;
}

int RunMcapInfo(const InfoOptions& options) {
  try {
    McapReader reader(McapParts(options.file.string()));
    const McapSummary summary = SummarizeMcap(reader, options.file);
    std::cout << (options.json ? McapJson(summary, reader, options)
                               : McapText(summary, reader, options));
    return options.check && reader.trouble_count() > 0 ? 1 : 0;
  } catch (const McapError& e) {
    throw ConfigError(e.what());
  }
}

}  // namespace sprout::log
