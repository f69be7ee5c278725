#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "common/core/frame.h"
#include "services/tools/log/commands.h"

namespace sprout::log {

/// Reads the selected frames of a log, each with those of `parts` that the log has; see FrameIndex
/// for what is a frame. Shows progress.
/// @returns one line about damage, and about undecodable messages, or about the log's channels if
///          none is the graph's; or nothing. @throws LogError; ConfigError for a bad
///          options.frames.
std::string ReadFrames(const PicturesOptions& options, PartSet parts,
                       const std::function<void(const Frame&)>& visit);

/// Names the files of a frame: "000042_left.png", and, if capture was restarted and there was
/// another frame 42, "000042_1700000000123456_left.png".
class FrameFileNames {
 public:
  /// @param folder  is created with the first name.
  explicit FrameFileNames(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// @throws ConfigError when the folder cannot be created.
  std::filesystem::path Of(const FrameId& id, const std::string& what);

  /// The names of one frame's files.
  auto For(const FrameId& id) {
    return [this, id](const std::string& what) { return Of(id, what); };
  }

  int64_t frames() const { return std::ssize(frames_); }
  int64_t files() const { return files_; }

  /// "; 12 files of other frames were there before", or nothing. They are of an earlier run.
  std::string OthersText() const;

 private:
  std::filesystem::path folder_;
  std::map<int64_t, int64_t> utimes_;  // of the first frame with a number
  std::set<FrameId> frames_;
  std::set<std::string> others_;  // files of frames that were there, and were not named
  int64_t files_ = 0;
};

/// Prints how many files were written, and a complaint of ReadFrames() to stderr.
/// @throws LogError with `nothing` if there is none.
void FinishFiles(const std::string& complaint, const FrameFileNames& names,
                 const PicturesOptions& options, const std::string& nothing);

}  // namespace sprout::log
