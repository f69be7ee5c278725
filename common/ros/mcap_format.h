#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"

// The format of MCAP files (https://mcap.dev/spec): records of an opcode (1 byte), a length (8
// bytes) and a content, between two magics. All numbers are little endian.
namespace sprout {

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

enum class McapOpcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Bytes of opcode and length.
inline constexpr size_t kRecordHead = 9;

/// What messages of a channel are made of; id 0: no schema.
struct McapSchema {
  uint16_t id = 0;
  std::string name;      ///< "sensor_msgs/msg/Image"
  std::string encoding;  ///< "ros2msg"
  std::string data;
};

/// A topic.
struct McapChannel {
  uint16_t id = 0;
  uint16_t schema_id = 0;
  std::string topic;
  std::string encoding;  ///< of its messages: "cdr"
  std::map<std::string, std::string> metadata;
};

using McapBytes = std::vector<uint8_t>;

/// Appends the parts of records.
class RecordWriter {
 public:
  explicit RecordWriter(McapBytes& bytes) : bytes_(bytes) {}

  template <typename T>
  void Number(T number) {
    static_assert(std::endian::native == std::endian::little);
    const auto* at = reinterpret_cast<const uint8_t*>(&number);
    bytes_.insert(bytes_.end(), at, at + sizeof number);
  }
  void Text(std::string_view text);
  void Texts(const std::map<std::string, std::string>& texts);
  void Raw(std::span<const uint8_t> raw) { bytes_.insert(bytes_.end(), raw.begin(), raw.end()); }

  /// Begins a record. @returns what End() wants.
  size_t Begin(McapOpcode opcode);
  void End(size_t begin);

 private:
  McapBytes& bytes_;
};

/// Takes the parts of a record from its content; never reads behind the end.
class RecordReader {
 public:
  explicit RecordReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  template <typename T>
  T Number() {
    T number{};
    if (!Has(sizeof number)) return number;
    std::memcpy(&number, bytes_.data(), sizeof number);
    bytes_ = bytes_.subspan(sizeof number);
    return number;
  }
  std::string Text();
  std::map<std::string, std::string> Texts();
  std::span<const uint8_t> Raw(uint64_t size);
  std::span<const uint8_t> rest() const { return bytes_; }

  /// False once anything was missing.
  bool ok() const { return ok_; }

 private:
  bool Has(uint64_t size);

  std::span<const uint8_t> bytes_;
  bool ok_ = true;
};

/// A record: its opcode, and a view of its content.
struct McapRecord {
  McapOpcode opcode{};
  std::span<const uint8_t> content;
};

/// The record in front of `bytes`, which go on behind it; an error when it is not whole.
Result<McapRecord> TakeRecord(std::span<const uint8_t>& bytes);

void WriteSchema(const McapSchema& schema, RecordWriter& writer);
void WriteChannel(const McapChannel& channel, RecordWriter& writer);
Result<McapSchema> ReadSchema(std::span<const uint8_t> content);
Result<McapChannel> ReadChannel(std::span<const uint8_t> content);

/// Continues the CRC-32 `crc` (0: begins one) with these bytes.
uint32_t Crc32(uint32_t crc, std::span<const uint8_t> bytes);

}  // namespace sprout
