#include "common/mcap/mcap_reader.h"

#include <array>
#include <utility>

#include "common/mcap/chunk_codec.h"

namespace sprout {
namespace {

constexpr size_t kMostTrouble = 10;

// McapOpcode and content of the record in front of `bytes`, which go on behind it.
struct Record {
  McapOpcode opcode{};
  std::span<const uint8_t> content;
};
Result<Record> TakeRecord(std::span<const uint8_t>& bytes) {
  RecordReader reader(bytes);
  const auto opcode = reader.Number<McapOpcode>();
  const std::span content = reader.Raw(reader.Number<uint64_t>());
  if (!reader.ok()) return Fail("chunk: ends within a record");
  bytes = reader.rest();
  return Record{opcode, content};
}

}  // namespace

McapReader::McapReader(std::filesystem::path path)
    : path_(std::move(path)), file_(path_, std::ios::binary) {
  std::error_code failed;
  size_ = std::filesystem::is_regular_file(path_, failed)
              ? std::filesystem::file_size(path_, failed)
              : 0;
  if (!file_ || failed) throw McapError(path_.string() + ": cannot be opened");
  std::string magic(kMcapMagic.size(), '\0');
  file_.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (!file_ || magic != kMcapMagic) throw McapError(path_.string() + ": no MCAP file");
  position_ = kMcapMagic.size();
}

void McapReader::Tell(uint64_t offset, const std::string& what) {
  ++trouble_count_;
  if (trouble_.size() >= kMostTrouble) return;
  trouble_.push_back("byte " + std::to_string(offset) + ": " + what);
}

// The next record of the file into record_. @returns false at its end.
bool McapReader::ReadRecord(McapOpcode& opcode) {
  record_offset_ = position_;
  const uint64_t left = size_ - position_;
  if (left == 0) {
    Tell(position_, "the file ends without an end of data");
    return false;
  }
  std::array<uint8_t, kRecordHead> head{};
  if (left >= head.size()) {
    file_.read(reinterpret_cast<char*>(head.data()), head.size());
  }
  RecordReader reader(head);
  opcode = reader.Number<McapOpcode>();
  const auto size = reader.Number<uint64_t>();
  if (left < head.size() || size > left - head.size()) {
    Tell(position_, "the file ends within a record, " + std::to_string(left) + " bytes lost");
    return false;
  }
  // What is not looked at is not read.
  const bool is_of_use =
      opcode != McapOpcode::kMessageIndex && static_cast<uint8_t>(opcode) <= 0x0F;
  if (is_of_use) {
    record_.resize(size);
    file_.read(reinterpret_cast<char*>(record_.data()), static_cast<std::streamsize>(size));
  } else {
    file_.seekg(static_cast<std::streamoff>(size), std::ios::cur);
    record_.clear();
  }
  if (!file_) {
    Tell(position_, "cannot be read");
    return false;
  }
  position_ += head.size() + size;
  return true;
}

void McapReader::TakeChunk() {
  RecordReader reader(record_);
  reader.Number<uint64_t>();  // times
  reader.Number<uint64_t>();
  const auto size = reader.Number<uint64_t>();
  const auto crc = reader.Number<uint32_t>();
  const std::string compression = reader.Text();
  const std::span packed = reader.Raw(reader.Number<uint64_t>());
  if (!reader.ok()) return Tell(record_offset_, "chunk: not whole");
  Result<McapBytes> chunk = UnpackChunk(compression, packed, size);
  if (!chunk) return Tell(record_offset_, chunk.error().text);
  if (crc != 0 && Crc32(0, *chunk) != crc) {
    return Tell(record_offset_, "chunk: its CRC is another");
  }
  chunk_ = std::move(*chunk);
  left_ = chunk_;
  ++chunks_;
}

bool McapReader::TakeMessage(std::span<const uint8_t> content, McapMessage& message) {
  RecordReader reader(content);
  const auto id = reader.Number<uint16_t>();
  message.sequence = reader.Number<uint32_t>();
  message.log_time_ns = reader.Number<uint64_t>();
  message.publish_time_ns = reader.Number<uint64_t>();
  message.data = reader.rest();
  const auto channel = channels_.find(id);
  if (!reader.ok() || channel == channels_.end()) {
    Tell(record_offset_, "message: not whole, or of a channel that is not known");
    return false;
  }
  message.channel = &channel->second;
  const auto schema = schemas_.find(channel->second.schema_id);
  message.schema = schema == schemas_.end() ? nullptr : &schema->second;
  return true;
}

void McapReader::TakeOther(McapOpcode opcode, std::span<const uint8_t> content) {
  RecordReader reader(content);
  if (opcode == McapOpcode::kSchema) {
    Result<McapSchema> schema = ReadSchema(content);
    if (!schema) return Tell(record_offset_, schema.error().text);
    schemas_.insert_or_assign(schema->id, std::move(*schema));
  } else if (opcode == McapOpcode::kChannel) {
    Result<McapChannel> channel = ReadChannel(content);
    if (!channel) return Tell(record_offset_, channel.error().text);
    channels_.insert_or_assign(channel->id, std::move(*channel));
  } else if (opcode == McapOpcode::kHeader) {
    profile_ = reader.Text();
    library_ = reader.Text();
  } else if (opcode == McapOpcode::kMetadata) {
    std::string name = reader.Text();
    metadata_[std::move(name)] = reader.Texts();
  }
}

bool McapReader::Next(McapMessage& message) {
  while (!is_over_) {
    if (!left_.empty()) {
      const Result<Record> record = TakeRecord(left_);
      if (!record) {
        Tell(record_offset_, record.error().text);
        left_ = {};
      } else if (record->opcode == McapOpcode::kMessage) {
        if (TakeMessage(record->content, message)) return true;
      } else {
        TakeOther(record->opcode, record->content);
      }
      continue;
    }
    McapOpcode opcode{};
    if (!ReadRecord(opcode)) {
      is_over_ = true;
    } else if (opcode == McapOpcode::kMessage) {
      if (TakeMessage(record_, message)) return true;
    } else if (opcode == McapOpcode::kChunk) {
      TakeChunk();
    } else if (opcode == McapOpcode::kDataEnd || opcode == McapOpcode::kFooter) {
      has_ended_ = true;
      is_over_ = true;  // behind it stands only what was there before
    } else {
      TakeOther(opcode, record_);
    }
  }
  return false;
}

}  // namespace sprout
