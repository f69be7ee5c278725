#include "services/tools/log/log_frames.h"

#include <fmt/core.h>

#include <optional>
#include <system_error>

#include "common/config/config_error.h"
#include "common/config/frame_range.h"
#include "common/frames/log_frames.h"
#include "common/logfile/log_error.h"
#include "services/tools/log/print_line.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {

std::string ReadFrames(const PicturesOptions& options, PartSet parts,
                       const std::function<void(const Frame&)>& visit) {
  FrameChoice choice{.prefix = options.prefix, .parts = parts};
  if (!options.frames.empty()) choice.frames = ParseFrameRange("--frames", options.frames);
  int64_t undecodable = 0;
  std::string first_error;
  int64_t first_offset = 0;
  LogFrames frames(options.file, choice, [&](const LogEvent& event, const std::string& why) {
    if (undecodable++ > 0 && event.offset > first_offset) return;
    first_offset = event.offset;
    first_error =
        fmt::format("{}, event {} at byte {}: {}", event.channel, event.number, event.offset, why);
  });
  {
    ReadProgress progress("reading " + options.file.string(), frames.log().size());
    const auto show = [&](int64_t position) { progress.Update(position); };
    while (const std::optional<Frame> frame = frames.Next(show)) visit(*frame);
    progress.Clear();
  }
  std::string complaint = DamageWarning(options.file, frames.log().damage());
  const std::string more = undecodable == 0 ? frames.index().OtherPrefixText()
                                            : fmt::format("undecodable messages: {}, the first {}",
                                                          undecodable, first_error);
  if (!complaint.empty() && !more.empty()) complaint += "; ";
  return complaint + more;
}

std::filesystem::path FrameFileNames::Of(const FrameId& id, const std::string& what) {
  if (utimes_.empty()) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error)
      throw ConfigError(folder_.string() + ": cannot be written (" + error.message() + ")");
    for (const auto& entry : std::filesystem::directory_iterator(folder_, error)) {
      const std::string name = entry.path().filename().string();
      if (name.find_first_not_of("0123456789") == 6 && name[6] == '_') others_.insert(name);
    }
  }
  ++files_;
  frames_.insert(id);
  const auto [first, added] = utimes_.emplace(id.seq, id.utime);
  const std::string number = fmt::format("{:06}", id.seq);
  const bool other = !added && first->second != id.utime;
  const std::string name = number + (other ? fmt::format("_{}", id.utime) : "") + "_" + what;
  others_.erase(name);
  return folder_ / name;
}

std::string FrameFileNames::OthersText() const {
  if (others_.empty()) return "";
  return fmt::format("; {} files of other frames were there before", others_.size());
}

void FinishFiles(const std::string& complaint, const FrameFileNames& names,
                 const PicturesOptions& options, const std::string& nothing) {
  if (names.files() == 0) {
    throw LogError(options.file, nothing + (complaint.empty() ? "" : "; " + complaint));
  }
  if (!complaint.empty()) PrintWarning(complaint);
  PrintLine(fmt::format("{}: {} files of {} frames{}", options.folder.string(), names.files(),
                        names.frames(), names.OthersText()));
}

}  // namespace sprout::log
