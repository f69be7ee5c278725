#include "common/logfile/log_writer.h"

#include <limits>
#include <string>

#include "common/logfile/event_format.h"

namespace sprout {
namespace {

std::string_view AsText(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

LogWriter::LogWriter(const std::filesystem::path& path, bool overwrite,
                     OutputFile::OverInput over_input)
    : path_(path), file_(path, over_input) {
  RequireNoFailure();
  if (file_.replaces() && !overwrite) {
    throw LogError(path_, "exists already; --force overwrites it");
  }
}

void LogWriter::RequireNoFailure() const {
  if (file_.failure().empty()) return;
  throw LogError(path_, "cannot be written (" + file_.failure() + ")");
}

void LogWriter::Write(int64_t utime, std::string_view channel, std::span<const uint8_t> data,
                      std::optional<int64_t> number) {
  if (channel.empty() || channel.size() > kMaxChannelBytes) {
    throw LogError(path_, "channel '" + std::string(channel) + "': allowed are 1 to 63 characters");
  }
  if (data.size() > static_cast<size_t>(std::numeric_limits<int32_t>::max())) {
    throw LogError(path_, "a message of " + std::to_string(data.size()) +
                              " bytes: allowed are less than 2^31");
  }
  const auto header = EncodeHeader({.number = number.value_or(events_),
                                    .utime = utime,
                                    .channel_bytes = static_cast<int32_t>(channel.size()),
                                    .data_bytes = static_cast<int32_t>(data.size())});
  file_.Write(AsText(header));
  file_.Write(channel);
  file_.Write(AsText(data));
  RequireNoFailure();
  ++events_;
}

void LogWriter::Close() {
  if (!file_.Commit()) RequireNoFailure();
}

}  // namespace sprout
