#include "common/ros/mcap_parts.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "common/core/read_text.h"
#include "common/ros/mcap_file.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

constexpr char kOfSqlite[] =
    "a bag in SQLite; make MCAP of it with ros2 bag convert, or with mcap convert";

bool IsPart(const fs::path& path) {
  return path.string().ends_with(".mcap") || path.string().ends_with(".mcap.zstd");
}

// What metadata.yaml names, whether it was unpacked since (as rosbag2 does to play it) or not.
fs::path PartThere(const fs::path& part) {
  fs::path other = part;
  part.extension() == ".zstd" ? other.replace_extension() : other += ".zstd";
  return !fs::exists(part) && fs::exists(other) ? other : part;
}

std::vector<fs::path> PartsOfMetadata(const fs::path& folder, const fs::path& metadata) {
  const Result<std::string> text = ReadText(metadata, kMaxListBytes);
  if (!text) throw McapError(metadata.string() + ": " + text.error().text);
  std::vector<fs::path> parts;
  try {
    const YAML::Node bag = YAML::Load(*text)["rosbag2_bagfile_information"];
    for (const YAML::Node& file : bag["relative_file_paths"]) {
      // Old ones have the folder's name in front.
      const fs::path part = folder / fs::path(file.as<std::string>()).filename();
      if (part.extension() == ".db3") throw McapError(part.string() + ": " + kOfSqlite);
      parts.push_back(PartThere(part));
      if (!fs::exists(parts.back())) {
        throw McapError(metadata.string() + " names " + part.filename().string() +
                        ", which is not there");
      }
    }
  } catch (const YAML::Exception& e) {
    throw McapError(metadata.string() + ": cannot be read: " + e.what());
  }
  if (parts.empty()) throw McapError(metadata.string() + ": names no file");
  return parts;
}

std::vector<fs::path> PartsOf(const fs::path& folder) {
  const fs::path metadata = folder / "metadata.yaml";
  if (fs::exists(metadata)) return PartsOfMetadata(folder, metadata);
  std::vector<fs::path> parts;
  bool has_sqlite = false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (IsPart(entry.path())) parts.push_back(entry.path());
    has_sqlite = has_sqlite || entry.path().extension() == ".db3";
  }
  // The packed form of a part that is there twice is left out.
  std::ranges::sort(parts);
  std::erase_if(parts, [&](const fs::path& part) {
    return part.extension() == ".zstd" &&
           std::ranges::binary_search(parts, fs::path(part).replace_extension());
  });
  if (parts.empty() && has_sqlite) throw McapError(folder.string() + ": " + kOfSqlite);
  if (parts.empty()) throw McapError(folder.string() + ": a folder without .mcap files");
  return parts;
}

}  // namespace

std::vector<fs::path> McapParts(std::string_view bag) {
  std::error_code failed;
  try {
    if (fs::is_directory(bag, failed)) return PartsOf(bag);
  } catch (const fs::filesystem_error& e) {
    throw McapError(std::string(bag) + ": " + e.code().message());
  }
  if (fs::exists(bag, failed)) return {fs::path(bag)};
  std::vector<fs::path> parts;
  while (true) {
    const size_t comma = std::min(bag.find(','), bag.size());
    parts.emplace_back(bag.substr(0, comma));
    if (comma == bag.size()) return parts;
    bag.remove_prefix(comma + 1);
  }
}

std::string OtherBag(std::span<const uint8_t> begin) {
  const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
  if (text.starts_with("SQLite")) return std::string(": ") + kOfSqlite;
  if (text.starts_with("#ROSBAG")) {
    return ": a bag of ROS 1; make one of ROS 2 of it with rosbags-convert (of Python's package "
           "rosbags)";
  }
  return "";
}

}  // namespace sprout
