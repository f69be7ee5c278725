#ifndef SPROUT_SERVICES_BATCH_LOG_INDEX_H_
#define SPROUT_SERVICES_BATCH_LOG_INDEX_H_

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/frame_id.h"

namespace sprout::batch {

/// A message of a log that belongs to a frame, or a calibration.
struct IndexedEvent {
  int64_t line = 0;      ///< byte in the index file where its line begins
  int64_t line_end = 0;  ///< where the next one does
  int64_t offset = 0;    ///< byte in the log where the event begins
  int64_t bytes = 0;     ///< of the event, its header included
  int64_t utime = 0;     ///< µs, when the recorder got it
  std::string channel;
  FrameId id;
  uint64_t hash = 0;  ///< of the message
};

/// State of a log's file: shows whether an index or a manifest still fits it.
struct FileStamp {
  int64_t bytes = 0;
  int64_t mtime_ns = 0;

  bool operator==(const FileStamp&) const = default;
};

/// @throws LogError when there is no such file.
FileStamp StampOf(const std::filesystem::path& log);

/// What an index knows about its log as a whole.
struct IndexSummary {
  FileStamp stamp;
  int64_t events = 0;         ///< indexed
  int64_t other_events = 0;   ///< of channels that carry no part of a frame
  int64_t undecodable = 0;    ///< on channels of the graph, but refused by stages
  int64_t damaged_bytes = 0;  ///< without a readable event
  bool cuttable = true;       ///< no event is older than an undecodable one before it
};

/// Members of the lines of JSON that begin an index, and that describe a log in a manifest.
nlohmann::json ToJson(const IndexSummary& summary);

/// @throws ConfigError when a member is missing or invalid.
IndexSummary IndexSummaryFrom(const nlohmann::json& json);

/// The frames' messages of a log with their positions and digests: one line of JSON, then a line of
/// text for each message. Made by reading the log once, kept beside it as `LOG.index`, or in
/// another folder if the log's own is not writable. Some 100 bytes a message.
class LogIndex {
 public:
  /// Reads the index of a log; makes it if it is missing, damaged, or belongs to an older state of
  /// the log.
  /// @param fallback  folder for indexes that cannot be kept beside their logs; is created. Empty:
  ///                  none.
  /// @throws LogError when the log cannot be read, or the index cannot be written anywhere.
  static LogIndex Ensure(const std::filesystem::path& log, const std::filesystem::path& fallback);

  /// Reads an index file. @throws LogError when it is not one, or damaged.
  static LogIndex Read(const std::filesystem::path& index);

  /// Whether a file is the index of a log in this state, and of full length. Reads only its first
  /// line.
  static bool IsOf(const std::filesystem::path& index, const FileStamp& stamp);

  const std::filesystem::path& path() const { return path_; }
  const IndexSummary& summary() const { return summary_; }
  const std::vector<IndexedEvent>& events() const { return events_; }

  /// Why Ensure() did not use the existing index; empty: there was none, or it was valid.
  const std::string& replaced() const { return replaced_; }

 private:
  std::filesystem::path path_;
  IndexSummary summary_;
  std::vector<IndexedEvent> events_;
  std::string replaced_;
};

/// Writes an index as Read() reads it. @throws LogError.
void WriteIndex(const std::filesystem::path& path, const IndexSummary& summary,
                const std::vector<IndexedEvent>& events);

/// The events of an index file from byte `begin` to `end` (places of lines, see IndexedEvent),
/// without reading the rest. @throws LogError.
std::vector<IndexedEvent> ReadIndexLines(const std::filesystem::path& path, int64_t begin,
                                         int64_t end);

/// The one whose line begins at `line`. @throws LogError.
IndexedEvent ReadIndexLine(const std::filesystem::path& path, int64_t line);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_LOG_INDEX_H_
