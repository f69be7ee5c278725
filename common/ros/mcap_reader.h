#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <queue>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/ros/mcap_file.h"
#include "common/ros/mcap_format.h"

namespace sprout {

/// A message; views are valid until the next call of McapReader::Next().
struct McapMessage {
  const McapChannel* channel = nullptr;
  const McapSchema* schema = nullptr;  ///< null when the channel has none
  uint32_t sequence = 0;
  uint64_t log_time_ns = 0;
  uint64_t publish_time_ns = 0;
  std::span<const uint8_t> data;
};

/// What a channel says of its topic.
struct McapTopic {
  std::string name;
  std::string type;      ///< name of its schema; empty: it has none
  std::string encoding;  ///< of its messages
  auto operator<=>(const McapTopic&) const = default;
};

/// Reads the messages of one or more files as one recording, in the order of their log times; those
/// of one time in the order of the files, and as they stand in them. Chunked or not, packed with
/// zstd or lz4, with or without index; of a truncated file all complete messages. What cannot be
/// read is skipped and reported by trouble().
///
/// Memory: what stands in the files at one time, but of chunks no more than kMaxUnpackedBytes and
/// one. Of chunks that overlap beyond that, 16 bytes a message are kept, and they are unpacked
/// again and again.
class McapReader {
 public:
  static constexpr uint64_t kMaxUnpackedBytes = uint64_t{512} << 20;

  /// Looks at the heads of all records; O(records of the outer level).
  /// @param files  at least one.
  /// @param most_unpacked_bytes  of chunks that are kept in memory.
  /// @throws ConfigError.
  explicit McapReader(const std::vector<std::filesystem::path>& files,
                      uint64_t most_unpacked_bytes = kMaxUnpackedBytes);
  explicit McapReader(const std::filesystem::path& file) : McapReader(std::vector{file}) {}

  /// @returns false at the end of the messages.
  bool Next(McapMessage& message);

  /// One line for each stretch that could not be read, at most 10; how many there were.
  const std::vector<std::string>& trouble() const { return trouble_.lines; }
  int64_t trouble_count() const { return trouble_.count; }

  /// What the files have channels of, whether they have messages or not, by name.
  std::vector<McapTopic> Topics() const;

  const std::string& profile() const { return files_.front().profile(); }
  const std::string& library() const { return files_.front().library(); }
  /// Names of the metadata, and their values; of several files the last one's counts.
  std::map<std::string, std::map<std::string, std::string>> Metadata() const;

  uint64_t size() const;                           ///< bytes of the files
  uint64_t position() const { return position_; }  ///< bytes of them that are done with
  int64_t chunks() const { return chunks_; }       ///< whole ones so far
  bool has_ended() const;                          ///< every file has an end of data

 private:
  struct Place {
    uint64_t log_time_ns = 0;
    uint64_t offset = 0;  // in the stretch's records
  };
  // A stretch with messages that are still to come.
  struct Open {
    McapBytes records;  // empty: to be read again
    std::vector<Place> places;
    size_t next = 0;
    uint64_t used = 0;  // the higher, the later
  };
  struct Stretch {
    size_t file = 0;
    McapStretch place;
  };
  using TimeAndStretch = std::pair<uint64_t, size_t>;

  void OpenStretches();
  void OpenStretch(size_t number);
  void CloseStretch(size_t number);
  void MakeRoom();
  bool NeedRecords(size_t number);
  bool Take(size_t number, McapMessage& message);
  void Tell(size_t number, const std::string& what);

  McapTrouble trouble_;
  std::deque<McapFile> files_;
  std::vector<Stretch> stretches_;       // in file order
  std::vector<TimeAndStretch> to_come_;  // sorted; the first `opened_` were opened
  size_t opened_ = 0;
  std::map<size_t, Open> open_;  // by number of the stretch
  std::priority_queue<TimeAndStretch, std::vector<TimeAndStretch>, std::greater<>> heads_;
  size_t current_ = 0;  // stretch of the message that was given last
  uint64_t most_unpacked_bytes_;
  uint64_t unpacked_bytes_ = 0;
  uint64_t uses_ = 0;
  uint64_t newest_ns_ = 0;
  uint64_t position_ = 0;
  int64_t chunks_ = 0;
};

/// The files of a bag: of a folder, or of rosbag2's metadata.yaml in it, those that this names or,
/// without one, all *.mcap and *.mcap.zstd; of "a.mcap,b.mcap" both; else the file itself.
/// @throws ConfigError naming the folder that has none, or what of it is missing.
std::vector<std::filesystem::path> McapParts(std::string_view bag);

/// Which other kind of bag begins with these bytes, and what makes an MCAP file of it, for the end
/// of a line; empty: none that is known.
std::string OtherBag(std::span<const uint8_t> begin);

}  // namespace sprout
