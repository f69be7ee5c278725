#ifndef SPROUT_COMMON_MCAP_MCAP_READER_H_
#define SPROUT_COMMON_MCAP_MCAP_READER_H_

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/mcap/mcap_format.h"

namespace sprout {

/// A file that cannot be opened, or is no MCAP file.
class McapError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A message; views are valid until the next call of McapReader::Next().
struct McapMessage {
  const McapChannel* channel = nullptr;
  const McapSchema* schema = nullptr;  ///< null when the channel has none
  uint32_t sequence = 0;
  uint64_t log_time_ns = 0;
  uint64_t publish_time_ns = 0;
  std::span<const uint8_t> data;
};

/// Reads the messages of a file in the order in which they stand in it: chunked or not, packed with
/// zstd or lz4, with or without index; of a truncated file all complete messages. Memory is that of
/// the largest chunk. What cannot be read is skipped and reported by trouble().
class McapReader {
 public:
  /// @throws McapError.
  explicit McapReader(std::filesystem::path path);

  /// @returns false at the end of the messages.
  bool Next(McapMessage& message);

  /// One line for each stretch that could not be read, at most 10; how many there were.
  const std::vector<std::string>& trouble() const { return trouble_; }
  int64_t trouble_count() const { return trouble_count_; }

  const std::string& profile() const { return profile_; }
  const std::string& library() const { return library_; }
  const std::map<uint16_t, McapChannel>& channels() const { return channels_; }  ///< met so far
  /// Names of the metadata that were met so far, and their values.
  const std::map<std::string, std::map<std::string, std::string>>& metadata() const {
    return metadata_;
  }
  uint64_t size() const { return size_; }          ///< bytes of the file
  uint64_t position() const { return position_; }  ///< bytes read so far
  int64_t chunks() const { return chunks_; }       ///< whole ones so far
  bool has_ended() const { return has_ended_; }    ///< the end of the data was met

 private:
  bool ReadRecord(McapOpcode& opcode);
  void TakeChunk();
  bool TakeMessage(std::span<const uint8_t> content, McapMessage& message);
  void TakeOther(McapOpcode opcode, std::span<const uint8_t> content);
  void Tell(uint64_t offset, const std::string& what);

  std::filesystem::path path_;
  std::ifstream file_;
  uint64_t size_ = 0;
  uint64_t position_ = 0;
  uint64_t record_offset_ = 0;
  McapBytes record_;               // content of the record at the outer level
  McapBytes chunk_;                // records of the chunk
  std::span<const uint8_t> left_;  // of the chunk
  std::map<uint16_t, McapSchema> schemas_;
  std::map<uint16_t, McapChannel> channels_;
  std::map<std::string, std::map<std::string, std::string>> metadata_;
  std::string profile_;
  std::string library_;
  std::vector<std::string> trouble_;
  int64_t trouble_count_ = 0;
  int64_t chunks_ = 0;
  bool has_ended_ = false;
  bool is_over_ = false;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_MCAP_MCAP_READER_H_
