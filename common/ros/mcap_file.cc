#include "common/ros/mcap_file.h"

#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "common/core/input_files.h"
#include "common/core/read_text.h"
#include "common/ros/chunk_codec.h"
#include "common/ros/mcap_reader.h"

namespace sprout {
namespace {

// What a file that was packed with zstd holds.
struct UnpackedFile {
  std::ifstream file;
  uint64_t size = 0;
  std::string complaint;  ///< why it is not whole; empty: it is
};

namespace fs = std::filesystem;

struct StreamDeleter {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// Unpacks a file that is packed as a whole (rosbag2's --compression-mode file) into a temporary
// one in TMPDIR, which has no name: it goes away with the program, however that ends. From a torn
// file all that is there is unpacked.
// @param magic  what its content must begin with; else nothing is unpacked.
// @throws ConfigError when it begins otherwise, or there is no room for it.
UnpackedFile UnpackFile(const fs::path& path, std::string_view magic) {
  std::string temporary = (fs::temp_directory_path() / "sprout-XXXXXX").string();
  const int descriptor = mkstemp(temporary.data());
  if (descriptor >= 0) close(descriptor);
  UnpackedFile unpacked;
  std::ofstream to(temporary, std::ios::binary);
  unpacked.file.open(temporary, std::ios::binary);
  std::error_code ignored;
  fs::remove(temporary, ignored);  // who has it open keeps its content, and nobody else
  std::ifstream from(path, std::ios::binary);
  const std::unique_ptr<ZSTD_DCtx, StreamDeleter> context(ZSTD_createDCtx());
  std::vector<char> packed(ZSTD_DStreamInSize());
  std::vector<char> block(ZSTD_DStreamOutSize());
  size_t result = 0;  // 0 at the end of a frame
  while (unpacked.complaint.empty() && from.read(packed.data(), std::ssize(packed)).gcount() > 0) {
    ZSTD_inBuffer in{packed.data(), static_cast<size_t>(from.gcount()), 0};
    for (bool is_full = true; in.pos < in.size || is_full;) {
      ZSTD_outBuffer out{block.data(), block.size(), 0};
      result = ZSTD_decompressStream(context.get(), &out, &in);
      if (ZSTD_isError(result) != 0) {
        unpacked.complaint =
            std::string("cannot be unpacked further: ") + ZSTD_getErrorName(result);
        break;
      }
      is_full = out.pos == out.size && result != 0;  // at the end of a frame nothing is left inside
      if (unpacked.size == 0 && out.pos > 0 &&
          !std::string_view(block.data(), out.pos).starts_with(magic)) {
        const std::span begin(reinterpret_cast<const uint8_t*>(block.data()), out.pos);
        throw ConfigError(path.string() + ": no MCAP file in it" + OtherBag(begin));
      }
      to.write(block.data(), static_cast<std::streamsize>(out.pos));
      unpacked.size += out.pos;
    }
    if (!to) throw ConfigError(path.string() + ": no room to unpack it in " + temporary);
  }
  if (unpacked.size == 0) throw ConfigError(path.string() + ": no MCAP file in it");
  if (unpacked.complaint.empty() && result != 0) {
    unpacked.complaint = "the packed file ends before its content does";
  }
  to.close();
  if (!to || !unpacked.file) {
    throw ConfigError(path.string() + ": no room to unpack it in " + temporary);
  }
  return unpacked;
}

// Messages outside of chunks are read by so many bytes at once.
constexpr uint64_t kStretchBytes = uint64_t{1} << 20;

// Bytes of a message's head: channel, sequence, log time and publish time. A chunk begins with its
// first time.
constexpr size_t kMessageHead = 22;

bool IsMessage(const McapStretch& stretch, uint64_t end) {
  return !stretch.is_chunk && stretch.offset + stretch.size == end && stretch.size < kStretchBytes;
}

}  // namespace

void McapTrouble::Tell(const std::string& file, uint64_t offset, const std::string& what) {
  constexpr size_t kMaxLines = 10;
  std::string line =
      (file.empty() ? "" : file + ": ") + "byte " + std::to_string(offset) + ": " + what;
  if (std::ranges::find(lines, line) != lines.end()) return;  // what is read again
  ++count;
  if (lines.size() < kMaxLines) lines.push_back(std::move(line));
}

// Head of a record: opcode and length, and the first bytes of its content.
struct McapFile::Head {
  McapOpcode opcode{};
  uint64_t size = 0;  // of its content
  std::array<uint8_t, kMessageHead> begin{};

  // Zeros: bytes that were never written.
  bool is_nothing() const { return opcode == McapOpcode{} && size == 0; }

  uint64_t time_ns() const {
    uint64_t time = 0;
    const size_t at = opcode == McapOpcode::kMessage ? 6 : 0;
    std::memcpy(&time, begin.data() + at, sizeof time);
    return time;
  }
};

McapFile::McapFile(const fs::path& path, std::string name, McapTrouble& trouble)
    : name_(std::move(name)), trouble_(&trouble) {
  std::error_code failed;
  const auto closed = [&] {
    return ConfigError(path.string() + ": cannot be opened" + WhyClosed(path));
  };
  if (!fs::is_regular_file(path, failed)) throw closed();
  NoteInputFile(path);
  file_.open(path, std::ios::binary);
  size_ = fs::file_size(path, failed);
  if (!file_ || failed) throw closed();
  McapBytes magic(std::min<uint64_t>(size_, kMcapMagic.size()));
  ReadContent(0, magic.size(), magic);
  if (IsZstd(magic)) {
    Unpack(path);
  } else if (!std::ranges::equal(magic, kMcapMagic, {}, {},
                                 [](char c) { return static_cast<uint8_t>(c); })) {
    throw ConfigError(path.string() + ": no MCAP file" + OtherBag(magic));
  }
  Walk();
  if (channels_.empty()) ReadAllChannels();
}

void McapFile::Unpack(const fs::path& path) {
  UnpackedFile unpacked = UnpackFile(path, kMcapMagic);
  file_ = std::move(unpacked.file);
  size_ = unpacked.size;
  if (!unpacked.complaint.empty()) Tell(size_, unpacked.complaint);
}

bool McapFile::ReadContent(uint64_t offset, uint64_t size, McapBytes& content) {
  content.resize(size);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(offset));
  file_.read(reinterpret_cast<char*>(content.data()), static_cast<std::streamsize>(size));
  return static_cast<bool>(file_);
}

// @returns false when the file ends before the record does.
bool McapFile::ReadHead(uint64_t offset, Head& head) {
  McapBytes bytes;
  const uint64_t left = size_ - offset;
  if (left < kRecordHead) return false;
  if (!ReadContent(offset, std::min<uint64_t>(left, kRecordHead + kMessageHead), bytes)) {
    return false;
  }
  RecordReader reader(bytes);
  head.opcode = reader.Number<McapOpcode>();
  head.size = reader.Number<uint64_t>();
  head.begin = {};
  std::copy_n(reader.rest().begin(), std::min<uint64_t>(reader.rest().size(), head.size),
              head.begin.begin());
  return head.size <= left - kRecordHead;
}

void McapFile::AddStretch(uint64_t offset, const Head& head) {
  const uint64_t size = kRecordHead + head.size;
  const bool is_chunk = head.opcode == McapOpcode::kChunk;
  if (!is_chunk && !stretches_.empty() && IsMessage(stretches_.back(), offset)) {
    stretches_.back().size += size;
    stretches_.back().first_ns = std::min(stretches_.back().first_ns, head.time_ns());
  } else {
    stretches_.push_back({offset, size, is_chunk, head.time_ns()});
  }
}

void McapFile::Walk() {
  uint64_t offset = kMcapMagic.size();
  McapBytes content;
  for (Head head; offset < size_; offset += kRecordHead + head.size) {
    if (!ReadHead(offset, head)) {
      return Tell(offset, "the file ends within a record, " + std::to_string(size_ - offset) +
                              " bytes lost");
    }
    if (head.is_nothing()) {
      return Tell(offset, "no record, " + std::to_string(size_ - offset) + " bytes lost");
    }
    const auto can_be_read = [&] {
      if (head.size <= kMaxMcapRecordBytes) return true;
      Tell(offset, "a record of " + std::to_string(head.size) + " bytes: allowed are up to " +
                       std::to_string(kMaxMcapRecordBytes));
      return false;
    };
    switch (head.opcode) {
      case McapOpcode::kMessage:
      case McapOpcode::kChunk:
        if (can_be_read()) AddStretch(offset, head);
        break;
      case McapOpcode::kHeader:
      case McapOpcode::kSchema:
      case McapOpcode::kChannel:
      case McapOpcode::kMetadata:
        if (!can_be_read()) break;
        if (!ReadContent(offset + kRecordHead, head.size, content)) {
          return Tell(offset, "cannot be read");
        }
        TakeOther(offset, {head.opcode, content});
        break;
      case McapOpcode::kDataEnd:
      case McapOpcode::kFooter:
        has_ended_ = true;
        return ReadSummary(offset + kRecordHead + head.size);
      default:
        break;  // what is not looked at is skipped by its length
    }
  }
  Tell(offset, "the file ends without an end of data");
}

// Behind the data stands what was there before, all channels together: damage there is none of
// the messages'.
void McapFile::ReadSummary(uint64_t offset) {
  McapBytes content;
  for (Head head;
       ReadHead(offset, head) && head.opcode != McapOpcode::kFooter && !head.is_nothing();
       offset += kRecordHead + head.size) {
    if (head.opcode != McapOpcode::kSchema && head.opcode != McapOpcode::kChannel) continue;
    if (head.size > kMaxMcapRecordBytes) continue;
    if (!ReadContent(offset + kRecordHead, head.size, content)) return;
    if (head.opcode == McapOpcode::kSchema ? ReadSchema(content).has_value()
                                           : ReadChannel(content).has_value()) {
      TakeOther(offset, {head.opcode, content});
    }
  }
}

McapBytes McapFile::Load(const McapStretch& stretch) {
  McapBytes bytes;
  if (!ReadContent(stretch.offset, stretch.size, bytes)) {
    Tell(stretch.offset, "cannot be read");
    return {};
  }
  if (!stretch.is_chunk) return bytes;
  Result<McapBytes> records = UnpackChunkRecord(std::span(bytes).subspan(kRecordHead));
  if (records) return std::move(*records);
  Tell(stretch.offset, records.error().text);
  return {};
}

void McapFile::TakeOther(uint64_t offset, const McapRecord& record) {
  RecordReader reader(record.content);
  if (record.opcode == McapOpcode::kSchema) {
    Result<McapSchema> schema = ReadSchema(record.content);
    if (!schema) return Tell(offset, schema.error().text);
    schemas_.insert_or_assign(schema->id, std::move(*schema));
  } else if (record.opcode == McapOpcode::kChannel) {
    Result<McapChannel> channel = ReadChannel(record.content);
    if (!channel) return Tell(offset, channel.error().text);
    channels_.insert_or_assign(channel->id, std::move(*channel));
  } else if (record.opcode == McapOpcode::kHeader) {
    profile_ = reader.Text();
    library_ = reader.Text();
  } else if (record.opcode == McapOpcode::kMetadata) {
    std::string name = reader.Text();
    metadata_[std::move(name)] = reader.Texts();
  }
}

// Reads the channels of a file without summary: they are in its chunks, which are not read in file
// order.
void McapFile::ReadAllChannels() {
  if (std::exchange(has_read_all_channels_, true)) return;
  McapTrouble untold;  // it is told when the messages are read, which nobody does without channels
  McapTrouble* const told = std::exchange(trouble_, &untold);
  for (const McapStretch& stretch : stretches_) {
    if (!stretch.is_chunk) continue;
    const McapBytes bytes = Load(stretch);
    for (std::span<const uint8_t> left(bytes); !left.empty();) {
      const Result<McapRecord> record = TakeRecord(left);
      if (!record) break;
      if (record->opcode != McapOpcode::kMessage) TakeOther(stretch.offset, *record);
    }
  }
  trouble_ = told;
  if (!channels_.empty()) return;
  told->count += untold.count;
  std::ranges::copy(untold.lines, std::back_inserter(told->lines));
}

const McapChannel* McapFile::FindChannel(uint16_t id) {
  auto found = channels_.find(id);
  if (found == channels_.end()) {
    ReadAllChannels();
    found = channels_.find(id);
  }
  return found == channels_.end() ? nullptr : &found->second;
}

const McapSchema* McapFile::FindSchema(uint16_t id) const {
  const auto found = schemas_.find(id);
  return found == schemas_.end() ? nullptr : &found->second;
}

}  // namespace sprout
