#include "services/calibrate/frame_log.h"

#include <fmt/format.h>

#include <map>
#include <optional>

#include "common/bus/channels.h"
#include "common/bus/frame_joiner.h"
#include "common/config/config.h"
#include "common/logfile/log_reader.h"
#include "common/messages/codec.h"

namespace sprout::calibrate {
namespace {

using ChannelCounts = std::map<std::string, int64_t>;

class FrameLog {
 public:
  FrameLog(std::string prefix, const std::vector<Part>& parts)
      : prefix_(std::move(prefix)), parts_(parts), joiner_(SetOf(parts)) {}

  void Add(const LogEvent& event, const std::function<void(const Frame&)>& visit) {
    ++channels_[std::string(event.channel)];
    const std::optional<Part> part = PartOf(event.channel);
    if (!part) return;
    const Result<FrameId> id = DecodeFrameId(event.data);
    Result<DecodedPart> decoded =
        DecodePart(*part, event.data, id ? joiner_.ImageSizeOf(*id) : std::nullopt);
    if (!decoded) {
      if (refused_++ == 0) first_refusal_ = decoded.error().text;
      return;
    }
    for (const Frame& frame : joiner_.Add(decoded->id, *part, std::move(decoded->value))) {
      ++frames_;
      visit(frame);
    }
  }

  void End() { joiner_.DropPending(); }

  int64_t frames() const { return frames_; }

  // What the log has instead of whole frames.
  std::string NoFrameText() const {
    std::string wanted;
    for (const Part part : parts_) {
      wanted += fmt::format("{}{}{}", wanted.empty() ? "" : ", ", prefix_, ChannelOf(part));
    }
    std::string there;
    for (const auto& [channel, count] : channels_) {
      there += fmt::format("{}{} ({})", there.empty() ? "" : ", ", channel, count);
    }
    return fmt::format("no whole frame of {} in it; it has {}", wanted,
                       there.empty() ? "no events" : there);
  }

  std::string Complaint(const std::vector<LogDamage>& damage) const {
    std::string text;
    const auto add = [&](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
    if (refused_ > 0) add(fmt::format("{} messages cannot be read ({})", refused_, first_refusal_));
    if (joiner_.incomplete() > 0) add(fmt::format("{} frames are not whole", joiner_.incomplete()));
    if (!damage.empty()) add(fmt::format("damaged in {} places", damage.size()));
    return text;
  }

 private:
  static PartSet SetOf(const std::vector<Part>& parts) {
    PartSet set;
    for (const Part part : parts) set.Add(part);
    return set;
  }

  std::optional<Part> PartOf(std::string_view channel) const {
    for (const Part part : parts_) {
      if (channel == prefix_ + std::string(ChannelOf(part))) return part;
    }
    return std::nullopt;
  }

  std::string prefix_;
  std::vector<Part> parts_;
  FrameJoiner joiner_;
  ChannelCounts channels_;
  int64_t frames_ = 0;
  int64_t refused_ = 0;
  std::string first_refusal_;
};

}  // namespace

std::string ReadFrameLog(const std::filesystem::path& path, const std::string& prefix,
                         const std::vector<Part>& parts,
                         const std::function<void(const Frame&)>& visit) {
  LogReader reader(path);
  FrameLog log(prefix, parts);
  for (LogEvent event; reader.Next(event);) log.Add(event, visit);
  log.End();
  if (log.frames() == 0) throw ConfigError(path.string() + ": " + log.NoFrameText());
  const std::string complaint = log.Complaint(reader.damage());
  return complaint.empty() ? "" : path.string() + ": " + complaint;
}

}  // namespace sprout::calibrate
