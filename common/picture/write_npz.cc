#include "common/picture/write_npz.h"

#include <zlib.h>

#include <cassert>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

#include "common/core/output_file.h"

namespace sprout {
namespace {

// A file of the archive, as ZIP's headers need it (APPNOTE.TXT 4.3.7, 4.3.12, 4.3.16).
struct ZipEntry {
  std::string name;
  uint32_t crc = 0;
  uint32_t size = 0;
  uint32_t offset = 0;
};

constexpr uint16_t kZipVersion = 20;       // 2.0, of plain files
constexpr uint32_t kNoTime = 0x0021'0000;  // 1 January 1980, the first day that ZIP knows

std::string NpyHeader(const NpzArray& array) {
  std::string shape;
  for (const int64_t length : array.shape) shape += std::to_string(length) + ",";
  std::string text =
      "{'descr': '" + array.type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  constexpr size_t kStart = 10;      // magic, version, length
  constexpr size_t kAlignment = 64;  // of the numbers behind the header
  text.append(kAlignment - 1 - (kStart + text.size()) % kAlignment, ' ');
  text += '\n';
  const auto length = static_cast<uint16_t>(text.size());
  std::string header = "\x93NUMPY";
  header += {'\x01', '\x00', static_cast<char>(length & 0xff), static_cast<char>(length >> 8)};
  return header + text;
}

uint32_t CrcOf(std::string_view text, uint32_t crc = 0) {
  return static_cast<uint32_t>(
      crc32_z(crc, reinterpret_cast<const Bytef*>(text.data()), text.size()));
}

// What a local header and the one in the directory have in common.
void WriteEntry(OutputFile& file, const ZipEntry& entry) {
  file.WriteNumber(kZipVersion);
  file.WriteNumber(uint16_t{0});  // flags
  file.WriteNumber(uint16_t{0});  // stored
  file.WriteNumber(kNoTime);
  file.WriteNumber(entry.crc);
  file.WriteNumber(entry.size);  // as stored
  file.WriteNumber(entry.size);
  file.WriteNumber(static_cast<uint16_t>(entry.name.size()));
  file.WriteNumber(uint16_t{0});  // extra field
}

void WriteDirectoryEntry(OutputFile& file, const ZipEntry& entry) {
  file.Write("PK\x01\x02");
  file.WriteNumber(kZipVersion);
  WriteEntry(file, entry);
  file.WriteNumber(uint16_t{0});  // comment
  file.WriteNumber(uint16_t{0});  // disk
  file.WriteNumber(uint16_t{0});  // attributes
  file.WriteNumber(uint32_t{0});
  file.WriteNumber(entry.offset);
  file.Write(entry.name);
}

}  // namespace

NpzArray NpzOf(const std::string& name, const cv::Mat& map) {
  assert(map.type() == CV_8UC1 || map.type() == CV_16UC1 || map.type() == CV_32FC1);
  const char* const type = map.type() == CV_8UC1 ? "|u1" : map.type() == CV_16UC1 ? "<u2" : "<f4";
  NpzArray array{name, type, {map.rows, map.cols}, {}};
  const size_t row_bytes = static_cast<size_t>(map.cols) * map.elemSize();
  array.bytes.resize(row_bytes * static_cast<size_t>(map.rows));
  for (int v = 0; v < map.rows; ++v) {
    std::memcpy(array.bytes.data() + row_bytes * static_cast<size_t>(v), map.ptr(v), row_bytes);
  }
  return array;
}

NpzArray NpzOf(const std::string& name, std::span<const double> numbers,
               std::vector<int64_t> shape) {
  const auto bytes = std::as_bytes(numbers);
  return {name, "<f8", std::move(shape), {bytes.begin(), bytes.end()}};
}

NpzArray NpzOf(const std::string& name, int64_t number) {
  const auto bytes = std::as_bytes(std::span(&number, 1));
  return {name, "<i8", {}, {bytes.begin(), bytes.end()}};
}

Result<void> WriteNpz(const std::filesystem::path& path, const std::vector<NpzArray>& arrays) {
  OutputFile file(path);
  std::vector<ZipEntry> entries;
  uint64_t offset = 0;
  const auto is_too_large = [&](uint64_t more) {
    return offset + more > std::numeric_limits<uint32_t>::max();
  };
  for (const NpzArray& array : arrays) {
    const std::string header = NpyHeader(array);
    const std::string_view content(reinterpret_cast<const char*>(array.bytes.data()),
                                   array.bytes.size());
    constexpr size_t kLocalHeader = 30;
    const size_t size = header.size() + content.size();
    if (is_too_large(size + 2 * kLocalHeader)) {
      return Fail("cannot write " + path.string() + ": more than 4 GB");
    }
    entries.push_back({array.name + ".npy", CrcOf(content, CrcOf(header)),
                       static_cast<uint32_t>(size), static_cast<uint32_t>(offset)});
    file.Write("PK\x03\x04");
    WriteEntry(file, entries.back());
    file.Write(entries.back().name);
    file.Write(header);
    file.Write(content);
    offset += kLocalHeader + entries.back().name.size() + size;
  }
  uint32_t directory_bytes = 0;
  for (const ZipEntry& entry : entries) {
    WriteDirectoryEntry(file, entry);
    directory_bytes += static_cast<uint32_t>(46 + entry.name.size());  // header of 46 bytes
  }
  const auto count = static_cast<uint16_t>(entries.size());
  file.Write("PK\x05\x06");
  file.WriteNumber(uint32_t{0});  // disks
  file.WriteNumber(count);
  file.WriteNumber(count);
  file.WriteNumber(directory_bytes);
  file.WriteNumber(static_cast<uint32_t>(offset));
  file.WriteNumber(uint16_t{0});  // comment
  return file.Commit();
}

}  // namespace sprout
