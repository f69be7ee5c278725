// The subcommands that make a log smaller, and as it was: compress and expand.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <iostream>

#include "common/core/printable.h"
#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "common/messages/compressor.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {
namespace {

using Bytes = std::vector<uint8_t>;

LogError AtEvent(const std::filesystem::path& log, const LogEvent& event, const std::string& what) {
  return LogError(log, fmt::format("event at byte {}, {}: {}", event.offset, event.channel, what));
}

// Copies a log, of each event what `change` gives in its place. Numbers and times stay.
// @param change  gives nothing for an event that stays as it is.
template <typename Change>
void ChangeEvents(const std::filesystem::path& in, const std::filesystem::path& out, bool force,
                  const Change& change) {
  const auto begun = std::chrono::steady_clock::now();
  LogReader reader(in);
  LogWriter writer(out, force, OutputFile::OverInput::kAllowed);
  ReadProgress progress("reading " + in.string(), reader.size());
  int64_t changed = 0;
  int64_t bytes = 0;
  for (LogEvent event; reader.Next(event); progress.Update(reader.position())) {
    const std::optional<Bytes> instead = change(event);
    const std::span<const uint8_t> data = instead ? std::span(*instead) : event.data;
    writer.Write(event.utime, event.channel, data, event.number);
    changed += instead.has_value();
    bytes += std::ssize(data);
  }
  progress.Clear();
  if (!reader.damage().empty()) {
    throw LogError(in, SkippedText(reader.damage().front()) +
                           "; allowed is an undamaged log, such as sprout-log repair writes");
  }
  writer.Close();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begun;
  const double mb = static_cast<double>(reader.size()) / 1e6;
  std::cout << Printable(fmt::format("{}: {} of {} events changed, {:.1f} MB of {:.1f} MB, {:.0f} "
                                     "MB/s",
                                     out.string(), changed, writer.events(),
                                     static_cast<double>(bytes) / 1e6, mb, mb / seconds.count()))
            << "\n";
}

}  // namespace

int RunCompress(const CompressOptions& options) {
  MessageCompressor compressor(options.jpeg_quality);
  ChangeEvents(options.in, options.out, options.force, [&](const LogEvent& event) {
    std::optional<Bytes> smaller = compressor.Compress(event.channel, event.data);
    if (!smaller || !IsPacked(*smaller)) return smaller;
    // Nothing is lost that was not looked at.
    const Result<Bytes> back = Unpack(*smaller);
    if (!back || !std::ranges::equal(*back, event.data)) {
      throw AtEvent(options.in, event, "does not come back as it was");
    }
    return smaller;
  });
  return 0;
}

int RunExpand(const ExpandOptions& options) {
  ChangeEvents(options.in, options.out, options.force,
               [&](const LogEvent& event) -> std::optional<Bytes> {
                 if (!IsPacked(event.data)) return std::nullopt;
                 Result<Bytes> message = Unpack(event.data);
                 if (!message) throw AtEvent(options.in, event, message.error().text);
                 return *std::move(message);
               });
  return 0;
}

}  // namespace sprout::log
