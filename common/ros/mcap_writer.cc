#include "common/ros/mcap_writer.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "common/ros/chunk_codec.h"

namespace sprout {
namespace {

constexpr std::string_view kCompression = "zstd";  // PackChunk()'s, as files call it

std::string_view TextOf(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path, McapWriterOptions options)
    : options_(std::move(options)), file_(path) {
  McapBytes bytes(kMcapMagic.begin(), kMcapMagic.end());
  RecordWriter writer(bytes);
  const size_t begin = writer.Begin(McapOpcode::kHeader);
  writer.Text(options_.profile);
  writer.Text(options_.library);
  writer.End(begin);
  Append(bytes);
}

void McapWriter::Append(std::span<const uint8_t> bytes) {
  file_.Write(TextOf(bytes));
  position_ += bytes.size();
  crc_ = Crc32(crc_, bytes);
}

uint16_t McapWriter::AddSchema(std::string name, std::string encoding, std::string data) {
  assert(schemas_.size() < std::numeric_limits<uint16_t>::max());
  const auto id = static_cast<uint16_t>(schemas_.size() + 1);
  schemas_.push_back({id, std::move(name), std::move(encoding), std::move(data)});
  RecordWriter writer(chunk_);
  WriteSchema(schemas_.back(), writer);
  return id;
}

uint16_t McapWriter::AddChannel(uint16_t schema_id, std::string topic, std::string encoding,
                                std::map<std::string, std::string> metadata) {
  assert(channels_.size() < std::numeric_limits<uint16_t>::max());
  const auto id = static_cast<uint16_t>(channels_.size());
  channels_.push_back({id, schema_id, std::move(topic), std::move(encoding), std::move(metadata)});
  RecordWriter writer(chunk_);
  WriteChannel(channels_.back(), writer);
  return id;
}

void McapWriter::Write(uint16_t channel_id, uint32_t sequence, uint64_t time_ns,
                       std::span<const uint8_t> data) {
  assert(channel_id < channels_.size());
  chunk_messages_[channel_id].emplace_back(time_ns, chunk_.size());
  RecordWriter writer(chunk_);
  const size_t begin = writer.Begin(McapOpcode::kMessage);
  writer.Number(channel_id);
  writer.Number(sequence);
  writer.Number(time_ns);
  writer.Number(time_ns);
  writer.Raw(data);
  writer.End(begin);
  ++counts_[channel_id];
  first_ns_ = messages_ == 0 ? time_ns : std::min(first_ns_, time_ns);
  last_ns_ = std::max(last_ns_, time_ns);
  ++messages_;
  if (chunk_.size() >= options_.chunk_bytes) EndChunk();
}

void McapWriter::EndChunk() {
  if (chunk_.empty()) return;
  ChunkIndex index;
  index.offset = position_;
  index.unpacked = chunk_.size();
  index.first_ns = chunk_messages_.empty() ? 0 : std::numeric_limits<uint64_t>::max();
  for (const auto& [channel, messages] : chunk_messages_) {
    for (const auto& [time_ns, offset] : messages) {
      index.first_ns = std::min(index.first_ns, time_ns);
      index.last_ns = std::max(index.last_ns, time_ns);
    }
  }
  PackChunk(chunk_, packed_);
  index.packed = packed_.size();
  McapBytes head;
  RecordWriter writer(head);
  const size_t begin = writer.Begin(McapOpcode::kChunk);
  writer.Number(index.first_ns);
  writer.Number(index.last_ns);
  writer.Number(uint64_t{chunk_.size()});
  writer.Number(Crc32(0, chunk_));
  writer.Text(kCompression);
  writer.Number(index.packed);
  // The record goes on with the packed bytes, which are not copied.
  const uint64_t size = head.size() - begin - kRecordHead + index.packed;
  std::memcpy(head.data() + begin + 1, &size, sizeof size);
  Append(head);
  Append(packed_);
  index.bytes = position_ - index.offset;

  McapBytes indexes;
  RecordWriter index_writer(indexes);
  for (const auto& [channel, messages] : chunk_messages_) {
    index.message_indexes[channel] = position_ + indexes.size();
    const size_t record = index_writer.Begin(McapOpcode::kMessageIndex);
    index_writer.Number(channel);
    index_writer.Number(static_cast<uint32_t>(messages.size() * sizeof(TimeAndOffset)));
    for (const auto& [time_ns, offset] : messages) {
      index_writer.Number(time_ns);
      index_writer.Number(offset);
    }
    index_writer.End(record);
  }
  Append(indexes);
  index.message_index_bytes = indexes.size();
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_messages_.clear();
}

void McapWriter::AddMetadata(const std::string& name,
                             const std::map<std::string, std::string>& values) {
  EndChunk();
  McapBytes bytes;
  RecordWriter writer(bytes);
  const size_t begin = writer.Begin(McapOpcode::kMetadata);
  writer.Text(name);
  writer.Texts(values);
  writer.End(begin);
  metadata_.push_back({position_, bytes.size(), name});
  Append(bytes);
}

void McapWriter::WriteStatistics(RecordWriter& writer) const {
  const size_t begin = writer.Begin(McapOpcode::kStatistics);
  writer.Number(messages_);
  writer.Number(static_cast<uint16_t>(schemas_.size()));
  writer.Number(static_cast<uint32_t>(channels_.size()));
  writer.Number(uint32_t{0});  // attachments
  writer.Number(static_cast<uint32_t>(metadata_.size()));
  writer.Number(static_cast<uint32_t>(chunks_.size()));
  writer.Number(first_ns_);
  writer.Number(last_ns_);
  writer.Number(static_cast<uint32_t>(counts_.size() * (sizeof(uint16_t) + sizeof(uint64_t))));
  for (const auto& [channel, count] : counts_) {
    writer.Number(channel);
    writer.Number(count);
  }
  writer.End(begin);
}

void McapWriter::WriteChunkIndexes(RecordWriter& writer) const {
  for (const ChunkIndex& index : chunks_) {
    const size_t begin = writer.Begin(McapOpcode::kChunkIndex);
    writer.Number(index.first_ns);
    writer.Number(index.last_ns);
    writer.Number(index.offset);
    writer.Number(index.bytes);
    writer.Number(static_cast<uint32_t>(index.message_indexes.size() *
                                        (sizeof(uint16_t) + sizeof(uint64_t))));
    for (const auto& [channel, offset] : index.message_indexes) {
      writer.Number(channel);
      writer.Number(offset);
    }
    writer.Number(index.message_index_bytes);
    writer.Text(kCompression);
    writer.Number(index.packed);
    writer.Number(index.unpacked);
    writer.End(begin);
  }
}

// Groups of records of one kind, and where in the file each stands.
McapBytes McapWriter::Summary(uint64_t begin) const {
  McapBytes bytes;
  RecordWriter writer(bytes);
  struct Group {
    McapOpcode opcode;
    uint64_t offset;
    uint64_t size;
  };
  std::vector<Group> groups;
  const auto add = [&](McapOpcode opcode, const auto& write) {
    const size_t at = bytes.size();
    write();
    if (bytes.size() > at) groups.push_back({opcode, begin + at, bytes.size() - at});
  };
  add(McapOpcode::kSchema, [&] {
    for (const McapSchema& schema : schemas_) WriteSchema(schema, writer);
  });
  add(McapOpcode::kChannel, [&] {
    for (const McapChannel& channel : channels_) WriteChannel(channel, writer);
  });
  add(McapOpcode::kStatistics, [&] { WriteStatistics(writer); });
  add(McapOpcode::kChunkIndex, [&] { WriteChunkIndexes(writer); });
  add(McapOpcode::kMetadataIndex, [&] {
    for (const MetadataIndex& index : metadata_) {
      const size_t record = writer.Begin(McapOpcode::kMetadataIndex);
      writer.Number(index.offset);
      writer.Number(index.bytes);
      writer.Text(index.name);
      writer.End(record);
    }
  });
  const uint64_t offsets = begin + bytes.size();
  for (const Group& group : groups) {
    const size_t record = writer.Begin(McapOpcode::kSummaryOffset);
    writer.Number(group.opcode);
    writer.Number(group.offset);
    writer.Number(group.size);
    writer.End(record);
  }
  // The footer's CRC is of all from the summary's begin up to itself.
  const size_t footer = writer.Begin(McapOpcode::kFooter);
  writer.Number(begin);
  writer.Number(offsets);
  const uint64_t size = sizeof(uint64_t) + sizeof(uint64_t) + sizeof(uint32_t);
  std::memcpy(bytes.data() + footer + 1, &size, sizeof size);
  writer.Number(Crc32(0, bytes));
  writer.Raw({reinterpret_cast<const uint8_t*>(kMcapMagic.data()), kMcapMagic.size()});
  return bytes;
}

Result<void> McapWriter::Commit() {
  EndChunk();
  McapBytes end;
  RecordWriter writer(end);
  const size_t begin = writer.Begin(McapOpcode::kDataEnd);
  writer.Number(crc_);
  writer.End(begin);
  Append(end);
  Append(Summary(position_));
  return file_.Commit();
}

}  // namespace sprout
