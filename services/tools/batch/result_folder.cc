#include "services/tools/batch/result_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "common/core/digest.h"
#include "common/core/host_name.h"
#include "common/core/read_text.h"
#include "common/logfile/file_window.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/manifest.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

// "DIGEST" of what follows, then "DIGEST BYTES NAME" a line.
constexpr char kList[] = "files.txt";

std::string TextOf(const fs::path& path) { return ReadText(path, kMaxListBytes).value_or(""); }

std::string ListOf(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::string list;
  for (const fs::path& file : files) {
    list +=
        fmt::format("{} {} {}\n", FileDigest(file), fs::file_size(file), file.filename().string());
  }
  return Digest(list) + "\n" + list;
}

bool IsAsListed(const fs::path& file, const std::string& digest, uintmax_t bytes,
                ResultCheck check) {
  std::error_code error;
  if (fs::file_size(file, error) != bytes || error) return false;
  if (check == ResultCheck::kQuick && file.extension() == ".lcm") return true;
  try {
    return FileDigest(file) == digest;
  } catch (const ConfigError&) {  // cannot be read
    return false;
  }
}

}  // namespace

std::string FileDigest(const fs::path& path) {
  constexpr int64_t kChunk = 1 << 20;
  try {
    const InputFile file(path);
    DigestStream digest;
    std::string bytes(static_cast<size_t>(std::min(kChunk, file.size())), '\0');
    for (int64_t at = 0; at < file.size(); at += kChunk) {
      bytes.resize(static_cast<size_t>(std::min(kChunk, file.size() - at)));
      file.Read(at, {reinterpret_cast<uint8_t*>(bytes.data()), bytes.size()});
      digest.Add(bytes);
    }
    return digest.Text();
  } catch (const LogError& e) {
    throw ConfigError(e.what());
  }
}

ResultFolder::ResultFolder(fs::path path) : path_(std::move(path)) {
  part_ = path_;
  part_ += fmt::format(".part-{}-{}", HostName(), getpid());
  fs::create_directories(part_);
}

ResultFolder::~ResultFolder() {
  std::error_code ignored;
  if (!part_.empty()) fs::remove_all(part_, ignored);
}

void ResultFolder::Commit() {
  WriteText(part_ / kList, ListOf(part_));
  std::error_code error;
  fs::rename(part_, path_, error);
  if (error && IsWhole(path_, ResultCheck::kAll)) return;
  if (error) {  // there is a damaged one
    fs::remove_all(path_, error);
    fs::rename(part_, path_, error);
  }
  if (error) throw LogError(path_, error.message());
  part_.clear();
}

bool IsWhole(const fs::path& result, ResultCheck check) {
  const std::string text = TextOf(result / kList);
  const size_t end = std::min(text.find('\n'), text.size());
  const std::string list = text.substr(std::min(end + 1, text.size()));
  if (list.empty() || text.substr(0, end) != Digest(list)) return false;
  std::istringstream lines(list);
  std::string digest;
  std::string name;
  for (uintmax_t bytes = 0; lines >> digest >> bytes >> name;) {
    if (!IsAsListed(result / name, digest, bytes, check)) return false;
  }
  return true;
}

void MarkDamaged(const fs::path& result) {
  std::error_code ignored;
  fs::remove(result / kList, ignored);
}

}  // namespace sprout::batch
