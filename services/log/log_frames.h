#ifndef SPROUT_SERVICES_LOG_LOG_FRAMES_H_
#define SPROUT_SERVICES_LOG_LOG_FRAMES_H_

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "common/core/frame.h"
#include "common/logfile/log_reader.h"
#include "services/log/commands.h"

namespace sprout::log {

/// The frames of a log, each put together from those of its messages that are there.
class LogFrames {
 public:
  /// Called for each frame with what the log holds of it; its calibration comes from anywhere in
  /// the log. A frame may come again, when parts of it were recorded again or long after the
  /// others.
  using Visit = std::function<void(const Frame&)>;

  /// @param parts  that are wanted; others are not decoded.
  LogFrames(const PicturesOptions& options, PartSet parts, Visit visit);

  /// Reads the whole log. Memory: some 16 frames. @throws LogError.
  void Read();

  /// What could not be decoded, and what the log has instead when it has no channel of the graph;
  /// one line, or nothing.
  std::string Complaint() const;

 private:
  void Add(const LogEvent& event);
  void Put(const FrameId& id, Part part, PartValue value);
  void Emit(Frame frame);
  std::optional<Rig> FindRig(const std::string& rig_id);

  PicturesOptions options_;
  FrameRange range_;
  PartSet parts_;
  Visit visit_;
  std::deque<Frame> pending_;  // in order of arrival
  std::map<std::string, std::optional<Rig>> rigs_;
  int64_t undecodable_ = 0;
  std::string first_error_;
  bool channel_seen_ = false;
  std::string other_channel_;  // one of another prefix
};

/// Names the files of a frame: "000042_left.png", and when capture began anew and there was another
/// frame 42, "000042_1700000000123456_left.png".
class FrameFileNames {
 public:
  /// @param folder  is created with the first name.
  explicit FrameFileNames(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// @throws ConfigError when the folder cannot be created.
  std::filesystem::path Of(const FrameId& id, const std::string& what);

  int64_t frames() const { return static_cast<int64_t>(utimes_.size()); }
  int64_t files() const { return files_; }

 private:
  std::filesystem::path folder_;
  std::map<int64_t, int64_t> utimes_;  // of the first frame with a number
  int64_t files_ = 0;
};

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_LOG_LOG_FRAMES_H_
