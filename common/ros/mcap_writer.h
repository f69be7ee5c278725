#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/core/output_file.h"
#include "common/ros/mcap_format.h"

namespace sprout {

struct McapWriterOptions {
  std::string profile = {};              ///< "ros2"
  std::string library = {};              ///< which wrote the file
  size_t chunk_bytes = size_t{4} << 20;  ///< unpacked; a message is never split
};

/// Writes an MCAP file: chunks with their message indexes, then schemas, channels, statistics,
/// indexes of chunks and metadata, and CRCs of all of it. Memory is that of a chunk, and some 40
/// bytes a chunk. The file appears whole or not at all (OutputFile).
class McapWriter {
 public:
  McapWriter(const std::filesystem::path& path, McapWriterOptions options);

  /// @returns its id. At most 65535.
  uint16_t AddSchema(std::string name, std::string encoding, std::string data);
  uint16_t AddChannel(uint16_t schema_id, std::string topic, std::string encoding,
                      std::map<std::string, std::string> metadata = {});

  /// Appends a message. @param time_ns  since 1970-01-01 UTC, for both of its times.
  void Write(uint16_t channel_id, uint32_t sequence, uint64_t time_ns,
             std::span<const uint8_t> data);

  void AddMetadata(const std::string& name, const std::map<std::string, std::string>& values);

  /// Ends the file and gives it its name. Call once, at the end.
  [[nodiscard]] Result<void> Commit();

  uint64_t messages() const { return messages_; }
  const std::string& failure() const { return file_.failure(); }

 private:
  using TimeAndOffset = std::pair<uint64_t, uint64_t>;
  struct ChunkIndex {
    uint64_t first_ns = 0;
    uint64_t last_ns = 0;
    uint64_t offset = 0;
    uint64_t bytes = 0;
    std::map<uint16_t, uint64_t> message_indexes;
    uint64_t message_index_bytes = 0;
    uint64_t packed = 0;
    uint64_t unpacked = 0;
  };
  struct MetadataIndex {
    uint64_t offset = 0;
    uint64_t bytes = 0;
    std::string name;
  };

  void Append(std::span<const uint8_t> bytes);
  void EndChunk();
  McapBytes Summary(uint64_t begin) const;
  void WriteStatistics(RecordWriter& writer) const;
  void WriteChunkIndexes(RecordWriter& writer) const;

  McapWriterOptions options_;
  OutputFile file_;
  uint64_t position_ = 0;
  uint32_t crc_ = 0;  // of the data section
  std::vector<McapSchema> schemas_;
  std::vector<McapChannel> channels_;
  McapBytes chunk_;
  McapBytes packed_;
  std::map<uint16_t, std::vector<TimeAndOffset>> chunk_messages_;
  std::vector<ChunkIndex> chunks_;
  std::vector<MetadataIndex> metadata_;
  std::map<uint16_t, uint64_t> counts_;
  uint64_t messages_ = 0;
  uint64_t first_ns_ = 0;
  uint64_t last_ns_ = 0;
};

}  // namespace sprout
