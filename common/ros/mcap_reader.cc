#include "common/ros/mcap_reader.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "common/config/required.h"
#include "common/core/number_text.h"
#include "common/core/read_text.h"

namespace sprout {
namespace {

// Place of the log time in a message's content, behind channel and sequence.
constexpr size_t kLogTimeAt = sizeof(uint16_t) + sizeof(uint32_t);

uint64_t LogTimeOf(std::span<const uint8_t> content) {
  RecordReader reader(content);
  reader.Raw(kLogTimeAt);
  return reader.Number<uint64_t>();
}

namespace fs = std::filesystem;

constexpr char kOfSqlite[] =
    "a bag in SQLite; make MCAP of it with ros2 bag convert, or with mcap convert";

bool IsPart(const fs::path& path) {
  const std::string name = path.filename();
  const bool is_hidden = name.starts_with('.');  // as macOS leaves beside each file
  return !is_hidden && (name.ends_with(".mcap") || name.ends_with(".mcap.zstd"));
}

bool IsSqlite(const fs::path& path) {
  const std::string name = path.filename();
  return name.ends_with(".db3") || name.ends_with(".db3.zstd");
}

// What metadata.yaml names, whether it was unpacked since (as rosbag2 does to play it) or not.
fs::path PartThere(const fs::path& part) {
  fs::path other = part;
  part.extension() == ".zstd" ? other.replace_extension() : other += ".zstd";
  return !fs::exists(part) && fs::exists(other) ? other : part;
}

std::vector<fs::path> PartsOfMetadata(const fs::path& folder, const fs::path& metadata) {
  const std::string text = Required(ReadText(metadata, kMaxListBytes), metadata.string() + ": ");
  std::vector<fs::path> parts;
  try {
    const YAML::Node bag = YAML::Load(text)["rosbag2_bagfile_information"];
    for (const YAML::Node& file : bag["relative_file_paths"]) {
      // Old ones have the folder's name in front.
      const fs::path part = folder / fs::path(file.as<std::string>()).filename();
      if (IsSqlite(part)) throw ConfigError(part.string() + ": " + kOfSqlite);
      parts.push_back(PartThere(part));
      if (!fs::exists(parts.back())) {
        throw ConfigError(metadata.string() + " names " + part.filename().string() +
                          ", which is not there");
      }
    }
  } catch (const YAML::Exception& e) {
    throw ConfigError(metadata.string() + ": cannot be read: " + e.what());
  }
  if (parts.empty()) throw ConfigError(metadata.string() + ": names no file");
  return parts;
}

std::vector<fs::path> PartsOf(const fs::path& folder) {
  const fs::path metadata = folder / "metadata.yaml";
  if (fs::exists(metadata)) return PartsOfMetadata(folder, metadata);
  std::vector<fs::path> parts;
  bool has_sqlite = false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (IsPart(entry.path())) parts.push_back(entry.path());
    has_sqlite = has_sqlite || IsSqlite(entry.path());
  }
  // The packed form of a part that is there twice is left out.
  std::ranges::sort(parts);
  std::erase_if(parts, [&](const fs::path& part) {
    return part.extension() == ".zstd" &&
           std::ranges::binary_search(parts, fs::path(part).replace_extension());
  });
  if (parts.empty() && has_sqlite) throw ConfigError(folder.string() + ": " + kOfSqlite);
  if (parts.empty()) {
    throw ConfigError(folder.string() +
                      ": a folder without .mcap files; a log of LCM is given by its file");
  }
  return parts;
}

}  // namespace

McapReader::McapReader(const std::vector<std::filesystem::path>& files,
                       uint64_t most_unpacked_bytes)
    : most_unpacked_bytes_(most_unpacked_bytes) {
  for (const std::filesystem::path& path : files) {
    const bool is_named = files.size() > 1;
    const McapFile& file =
        files_.emplace_back(path, is_named ? path.filename().string() : "", trouble_);
    for (const McapStretch& stretch : file.stretches()) {
      to_come_.emplace_back(stretch.first_ns, stretches_.size());
      stretches_.push_back({files_.size() - 1, stretch});
    }
  }
  std::ranges::sort(to_come_);
}

void McapReader::Tell(size_t number, const std::string& what) {
  files_[stretches_[number].file].Tell(stretches_[number].place.offset, what);
}

// Finds the messages of a stretch, which are sorted by time.
void McapReader::OpenStretch(size_t number) {
  const Stretch& stretch = stretches_[number];
  McapFile& file = files_[stretch.file];
  Open open;
  open.records = file.Load(stretch.place);
  if (stretch.place.is_chunk && !open.records.empty()) ++chunks_;
  for (std::span<const uint8_t> left(open.records); !left.empty();) {
    const uint64_t offset = open.records.size() - left.size();
    const Result<McapRecord> record = TakeRecord(left);
    if (!record) {
      Tell(number, record.error().text);
      break;
    }
    if (record->opcode == McapOpcode::kMessage) {
      open.places.push_back({LogTimeOf(record->content), offset});
    } else {
      file.TakeOther(stretch.place.offset, *record);
    }
  }
  std::ranges::stable_sort(open.places, {}, &Place::log_time_ns);
  if (open.places.empty()) {
    position_ += stretch.place.size;
    return;
  }
  if (open.places.front().log_time_ns < newest_ns_) {
    Tell(number, "has earlier messages than it says; they come late");
  }
  heads_.emplace(open.places.front().log_time_ns, number);
  unpacked_bytes_ += open.records.size();
  open.used = ++uses_;
  open_.emplace(number, std::move(open));
}

void McapReader::CloseStretch(size_t number) {
  const auto open = open_.find(number);
  unpacked_bytes_ -= open->second.records.size();
  open_.erase(open);
  position_ += stretches_[number].place.size;
}

// Opens all stretches that may hold the next message.
void McapReader::OpenStretches() {
  while (opened_ < to_come_.size() &&
         (heads_.empty() || to_come_[opened_].first <= heads_.top().first)) {
    OpenStretch(to_come_[opened_++].second);
    MakeRoom();
  }
}

// Drops the stretches of the file that were used longest ago until the open ones fit into the
// memory allowed, but never the last one.
void McapReader::MakeRoom() {
  while (unpacked_bytes_ > most_unpacked_bytes_) {
    const auto oldest = std::ranges::min_element(open_, {}, [](const auto& one) {
      return one.second.records.empty() ? UINT64_MAX : one.second.used;
    });
    if (oldest->second.used == uses_ || oldest->second.records.empty()) return;
    unpacked_bytes_ -= oldest->second.records.size();
    oldest->second.records = {};
  }
}

// @returns false when a stretch cannot be read a second time.
bool McapReader::NeedRecords(size_t number) {
  Open& open = open_.at(number);
  open.used = ++uses_;
  if (!open.records.empty()) return true;
  open.records = files_[stretches_[number].file].Load(stretches_[number].place);
  unpacked_bytes_ += open.records.size();
  MakeRoom();
  return !open.records.empty();
}

bool McapReader::Take(size_t number, McapMessage& message) {
  const Open& open = open_.at(number);
  std::span<const uint8_t> left(open.records);
  left = left.subspan(std::min<uint64_t>(open.places[open.next].offset, left.size()));
  const Result<McapRecord> record = TakeRecord(left);
  McapFile& file = files_[stretches_[number].file];
  RecordReader reader(record ? record->content : std::span<const uint8_t>());
  const auto id = reader.Number<uint16_t>();
  message.sequence = reader.Number<uint32_t>();
  message.log_time_ns = reader.Number<uint64_t>();
  message.publish_time_ns = reader.Number<uint64_t>();
  message.data = reader.rest();
  message.channel = reader.ok() ? file.FindChannel(id) : nullptr;
  if (message.channel == nullptr) {
    Tell(number, "message: not whole, or of a channel that is not known");
    return false;
  }
  message.schema = file.FindSchema(message.channel->schema_id);
  return true;
}

bool McapReader::Next(McapMessage& message) {
  while (true) {
    // The stretch of the message before is kept until now, for its views.
    if (const auto last = open_.find(current_); last != open_.end()) {
      if (last->second.next == last->second.places.size()) CloseStretch(current_);
    }
    OpenStretches();
    if (heads_.empty()) return false;
    current_ = heads_.top().second;
    heads_.pop();
    const bool can_be_read = NeedRecords(current_);
    const bool is_message = can_be_read && Take(current_, message);
    Open& open = open_.at(current_);
    open.next = can_be_read ? open.next + 1 : open.places.size();
    if (open.next < open.places.size()) {
      heads_.emplace(open.places[open.next].log_time_ns, current_);
    }
    if (!is_message) continue;
    newest_ns_ = std::max(newest_ns_, message.log_time_ns);
    return true;
  }
}

std::vector<McapTopic> McapReader::Topics() const {
  std::vector<McapTopic> topics;
  for (const McapFile& file : files_) {
    for (const auto& [id, channel] : file.channels()) {
      const McapSchema* const schema = file.FindSchema(channel.schema_id);
      topics.push_back({channel.topic, schema == nullptr ? "" : schema->name, channel.encoding});
    }
  }
  std::ranges::sort(topics);
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  return topics;
}

std::map<std::string, std::map<std::string, std::string>> McapReader::Metadata() const {
  std::map<std::string, std::map<std::string, std::string>> metadata;
  for (const McapFile& file : files_) {
    for (const auto& [name, values] : file.metadata()) metadata.insert_or_assign(name, values);
  }
  return metadata;
}

uint64_t McapReader::size() const {
  uint64_t size = 0;
  for (const McapFile& file : files_) size += file.size();
  return size;
}

bool McapReader::has_ended() const { return std::ranges::all_of(files_, &McapFile::has_ended); }

std::vector<fs::path> McapParts(std::string_view bag) {
  std::error_code failed;
  const fs::path path(bag);
  try {
    if (path.filename() == "metadata.yaml") return PartsOfMetadata(path.parent_path(), path);
    if (fs::is_directory(bag, failed)) return PartsOf(bag);
  } catch (const fs::filesystem_error& e) {
    throw ConfigError(std::string(bag) + ": " + e.code().message());
  }
  if (fs::exists(bag, failed)) return {path};
  std::vector<fs::path> parts;
  for (const std::string_view part : SplitAt(',', bag)) parts.emplace_back(part);
  return parts;
}

std::string OtherBag(std::span<const uint8_t> begin) {
  const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
  if (text.starts_with("SQLite")) return std::string(": ") + kOfSqlite;
  if (text.starts_with("#ROSBAG")) {
    return ": a bag of ROS 1; make one of ROS 2 of it with rosbags-convert (of Python's package "
           "rosbags)";
  }
  if (text.starts_with("\x1f\x8b")) return ": packed with gzip; unpack it with gunzip";
  if (text.starts_with("\x04\x22\x4d\x18")) return ": packed with lz4; unpack it with unlz4";
  return "";
}

}  // namespace sprout
