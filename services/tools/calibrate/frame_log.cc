#include "services/tools/calibrate/frame_log.h"

#include <fmt/ranges.h>

#include <vector>

#include "common/config/config_error.h"
#include "common/frames/log_frames.h"

namespace sprout::calibrate {
namespace {

ConfigError NoFrame(const std::filesystem::path& path, const std::string& prefix, PartSet parts,
                    const ChannelCounts& channels) {
  std::vector<std::string> wanted;
  for (const Part part : kAllParts) {
    if (parts.Has(part)) wanted.push_back(prefix + std::string(ChannelOf(part)));
  }
  return ConfigError(fmt::format("{}: no whole frame of {} in it; it has {}", path.string(),
                                 fmt::join(wanted, ", "), channels.Text()));
}

}  // namespace

int64_t CountMessages(const std::filesystem::path& path, const std::string& channel) {
  LogReader reader(path);
  int64_t count = 0;
  for (LogEvent event; reader.Next(event);) count += event.channel == channel ? 1 : 0;
  return count;
}

std::string ReadFrameLog(const std::filesystem::path& path, const std::string& prefix,
                         PartSet parts, const std::function<void(const Frame&)>& visit) {
  int64_t refused = 0;
  std::string first_refusal;
  WholeFrames log(path, prefix, parts, [&](const LogEvent&, const std::string& why) {
    if (refused++ == 0) first_refusal = why;
  });
  int64_t frames = 0;
  for (; const auto next = log.Next(); ++frames) visit(next->frame);
  if (frames == 0) throw NoFrame(path, prefix, parts, log.channels());
  const int64_t incomplete = log.joiner().incomplete();
  const size_t damaged = log.log().damage().size();
  std::vector<std::string> complaints;
  if (refused > 0) {
    complaints.push_back(fmt::format("{} messages cannot be read ({})", refused, first_refusal));
  }
  if (incomplete > 0) complaints.push_back(fmt::format("{} frames are not whole", incomplete));
  if (damaged > 0)
    complaints.push_back(fmt::format("damaged in {} place{}", damaged, damaged == 1 ? "" : "s"));
  if (complaints.empty()) return "";
  return fmt::format("{}: {}", path.string(), fmt::join(complaints, "; "));
}

}  // namespace sprout::calibrate
