#pragma once

#include <lz4frame.h>

#include <string_view>

#include "common/ros/chunk_codec.h"
#include "tests/common/logfile/sample_log.h"

namespace sprout {

/// An MCAP file of McapWriter, its chunks packed as other writers do: "zstd" (as they are), "lz4"
/// or "". The indexes are those of the file before, which no reader of ours looks at.
inline Bytes Repacked(const Bytes& file, std::string_view compression) {
  if (compression == "zstd") return file;
  const auto end = file.end() - static_cast<std::ptrdiff_t>(kMcapMagic.size());
  Bytes repacked(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(kMcapMagic.size()));
  RecordWriter writer(repacked);
  std::span<const uint8_t> left(file.begin() + std::ssize(repacked), end);
  while (!left.empty()) {
    const McapRecord record = TakeRecord(left).value();
    std::span<const uint8_t> content = record.content;
    const size_t begin = writer.Begin(record.opcode);
    if (record.opcode == McapOpcode::kChunk) {
      constexpr size_t kHead = 28;  // times, size and CRC of the records
      Bytes records = UnpackChunkRecord(content).value();
      if (compression == "lz4") {
        Bytes packed(LZ4F_compressFrameBound(records.size(), nullptr));
        packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), records.data(),
                                         records.size(), nullptr));
        records = packed;
      }
      writer.Raw(content.first(kHead));
      writer.Text(compression);
      writer.Number(uint64_t{records.size()});
      writer.Raw(records);
    } else {
      writer.Raw(content);
    }
    writer.End(begin);
  }
  repacked.insert(repacked.end(), end, file.end());
  return repacked;
}

}  // namespace sprout
