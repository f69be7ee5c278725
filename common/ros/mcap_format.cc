#include "common/ros/mcap_format.h"

#include <zlib.h>

namespace sprout {

void RecordWriter::Text(std::string_view text) {
  Number(static_cast<uint32_t>(text.size()));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
}

void RecordWriter::Texts(const std::map<std::string, std::string>& texts) {
  const size_t at = bytes_.size();
  Number(uint32_t{0});
  for (const auto& [key, value] : texts) {
    Text(key);
    Text(value);
  }
  const auto size = static_cast<uint32_t>(bytes_.size() - at - sizeof(uint32_t));
  std::memcpy(bytes_.data() + at, &size, sizeof size);
}

size_t RecordWriter::Begin(McapOpcode opcode) {
  const size_t begin = bytes_.size();
  Number(opcode);
  Number(uint64_t{0});
  return begin;
}

void RecordWriter::End(size_t begin) {
  const uint64_t size = bytes_.size() - begin - kRecordHead;
  std::memcpy(bytes_.data() + begin + 1, &size, sizeof size);
}

bool RecordReader::Has(uint64_t size) {
  ok_ = ok_ && size <= bytes_.size();
  return ok_;
}

std::string RecordReader::Text() {
  const std::span raw = Raw(Number<uint32_t>());
  return {raw.begin(), raw.end()};
}

std::map<std::string, std::string> RecordReader::Texts() {
  RecordReader inner(Raw(Number<uint32_t>()));
  std::map<std::string, std::string> texts;
  while (inner.ok() && !inner.rest().empty()) {
    std::string key = inner.Text();
    texts[std::move(key)] = inner.Text();
  }
  ok_ = ok_ && inner.ok();
  return texts;
}

std::span<const uint8_t> RecordReader::Raw(uint64_t size) {
  if (!Has(size)) return {};
  const std::span raw = bytes_.first(size);
  bytes_ = bytes_.subspan(size);
  return raw;
}

Result<McapRecord> TakeRecord(std::span<const uint8_t>& bytes) {
  RecordReader reader(bytes);
  const auto opcode = reader.Number<McapOpcode>();
  const std::span content = reader.Raw(reader.Number<uint64_t>());
  if (!reader.ok()) return Fail("chunk: ends within a record");
  bytes = reader.rest();
  return McapRecord{opcode, content};
}

void WriteSchema(const McapSchema& schema, RecordWriter& writer) {
  const size_t begin = writer.Begin(McapOpcode::kSchema);
  writer.Number(schema.id);
  writer.Text(schema.name);
  writer.Text(schema.encoding);
  writer.Text(schema.data);
  writer.End(begin);
}

void WriteChannel(const McapChannel& channel, RecordWriter& writer) {
  const size_t begin = writer.Begin(McapOpcode::kChannel);
  writer.Number(channel.id);
  writer.Number(channel.schema_id);
  writer.Text(channel.topic);
  writer.Text(channel.encoding);
  writer.Texts(channel.metadata);
  writer.End(begin);
}

Result<McapSchema> ReadSchema(std::span<const uint8_t> content) {
  RecordReader reader(content);
  McapSchema schema{.id = reader.Number<uint16_t>(),
                    .name = reader.Text(),
                    .encoding = reader.Text(),
                    .data = reader.Text()};
  if (!reader.ok() || schema.id == 0) return Fail("schema: not whole, or of id 0");
  return schema;
}

Result<McapChannel> ReadChannel(std::span<const uint8_t> content) {
  RecordReader reader(content);
  McapChannel channel{.id = reader.Number<uint16_t>(),
                      .schema_id = reader.Number<uint16_t>(),
                      .topic = reader.Text(),
                      .encoding = reader.Text(),
                      .metadata = reader.Texts()};
  if (!reader.ok()) return Fail("channel: not whole");
  return channel;
}

uint32_t Crc32(uint32_t crc, std::span<const uint8_t> bytes) {
  return static_cast<uint32_t>(crc32_z(crc, bytes.data(), bytes.size()));
}

}  // namespace sprout
