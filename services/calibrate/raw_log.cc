#include "services/calibrate/raw_log.h"

#include <fmt/format.h>

#include <map>
#include <optional>

#include "common/bus/channels.h"
#include "common/bus/frame_joiner.h"
#include "common/config/config.h"
#include "common/logfile/log_reader.h"
#include "common/messages/codec.h"

namespace sprout {
namespace {

constexpr Part kRawParts[] = {Part::kLeft, Part::kRight, Part::kTof};

std::optional<Part> PartOf(std::string_view channel, const std::string& prefix) {
  for (const Part part : kRawParts) {
    if (channel == prefix + std::string(ChannelOf(part))) return part;
  }
  return std::nullopt;
}

std::string ChannelText(const std::map<std::string, int64_t>& channels) {
  std::string text;
  for (const auto& [channel, count] : channels) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", channel, count);
  }
  return text.empty() ? "no events" : text;
}

}  // namespace

std::string ReadRawLog(const std::filesystem::path& path, const std::string& prefix,
                       const std::function<void(const RigImages&, int64_t)>& visit) {
  const std::string raw_prefix = prefix + "RAW_";
  LogReader reader(path);
  FrameJoiner joiner({Part::kLeft, Part::kRight, Part::kTof});
  std::map<std::string, int64_t> channels;
  int64_t triplets = 0;
  int64_t refused = 0;
  std::string first_refusal;
  for (LogEvent event; reader.Next(event);) {
    ++channels[std::string(event.channel)];
    const std::optional<Part> part = PartOf(event.channel, raw_prefix);
    if (!part) continue;
    Result<DecodedPart> decoded = DecodePart(*part, event.data);
    if (!decoded) {
      if (refused++ == 0) first_refusal = decoded.error().text;
      continue;
    }
    for (Frame& frame : joiner.Add(decoded->id, *part, std::move(decoded->value))) {
      ++triplets;
      visit({.left = frame.left, .right = frame.right, .tof = *frame.tof}, frame.id.utime);
    }
  }
  joiner.DropPending();
  if (triplets == 0) {
    throw ConfigError(
        fmt::format("{}: no whole triplet on {}SPROUT_LEFT, {}SPROUT_RIGHT and "
                    "{}SPROUT_TOF in it; it has {}",
                    path.string(), raw_prefix, raw_prefix, raw_prefix, ChannelText(channels)));
  }
  std::string complaint;
  const auto add = [&](const std::string& text) {
    complaint += (complaint.empty() ? path.string() + ": " : "; ") + text;
  };
  if (refused > 0) add(fmt::format("{} messages cannot be read ({})", refused, first_refusal));
  if (joiner.incomplete() > 0) add(fmt::format("{} triplets are not whole", joiner.incomplete()));
  if (!reader.damage().empty()) add(fmt::format("damaged in {} places", reader.damage().size()));
  return complaint;
}

}  // namespace sprout
