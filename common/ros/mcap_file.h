#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "common/config/config_error.h"
#include "common/ros/mcap_format.h"

namespace sprout {

/// What of files could not be read: one line a place, at most 10, and how many there were.
struct McapTrouble {
  std::vector<std::string> lines;
  int64_t count = 0;

  void Tell(const std::string& file, uint64_t offset, const std::string& what);
};

/// A part of a file that is read at once: a chunk, or messages that follow one another outside of
/// chunks.
struct McapStretch {
  uint64_t offset = 0;  ///< in the file, of its first record
  uint64_t size = 0;    ///< bytes in the file
  bool is_chunk = false;
  uint64_t first_ns = 0;  ///< of its messages; of a chunk as it says itself
};

/// One MCAP file and where its messages stand: chunked or not, with or without index, torn off or
/// whole. One that is packed as a whole with zstd (".mcap.zstd") is unpacked into a temporary file
/// first, which is gone when the program ends. Memory is that of its schemas and channels, and 32
/// bytes a stretch.
class McapFile {
 public:
  /// Looks at the heads of all records, not at what they hold; O(records).
  /// @param name  of the file in trouble's lines; empty: they name none.
  /// @throws ConfigError for a file that cannot be opened, or is no MCAP file.
  McapFile(const std::filesystem::path& path, std::string name, McapTrouble& trouble);

  /// The stretches in the order of the file.
  const std::vector<McapStretch>& stretches() const { return stretches_; }

  /// The records of a stretch; nothing, and trouble, when it cannot be read.
  McapBytes Load(const McapStretch& stretch);

  /// Takes a record that is no message, at a place of the file.
  void TakeOther(uint64_t offset, const McapRecord& record);

  /// Null when no record of the file tells of it.
  const McapChannel* FindChannel(uint16_t id);
  const McapSchema* FindSchema(uint16_t id) const;

  void Tell(uint64_t offset, const std::string& what) { trouble_->Tell(name_, offset, what); }

  const std::map<uint16_t, McapChannel>& channels() const { return channels_; }
  const std::map<std::string, std::map<std::string, std::string>>& metadata() const {
    return metadata_;
  }
  const std::string& profile() const { return profile_; }
  const std::string& library() const { return library_; }
  uint64_t size() const { return size_; }
  bool has_ended() const { return has_ended_; }

 private:
  struct Head;

  void Unpack(const std::filesystem::path& path);
  void Walk();
  bool ReadHead(uint64_t offset, Head& head);
  bool ReadContent(uint64_t offset, uint64_t size, McapBytes& content);
  void AddStretch(uint64_t offset, const Head& head);
  void ReadSummary(uint64_t offset);
  void ReadAllChannels();

  std::string name_;
  McapTrouble* trouble_;
  std::ifstream file_;
  uint64_t size_ = 0;
  std::vector<McapStretch> stretches_;
  std::map<uint16_t, McapSchema> schemas_;
  std::map<uint16_t, McapChannel> channels_;
  std::map<std::string, std::map<std::string, std::string>> metadata_;
  std::string profile_;
  std::string library_;
  bool has_ended_ = false;
  bool has_read_all_channels_ = false;
};

}  // namespace sprout
