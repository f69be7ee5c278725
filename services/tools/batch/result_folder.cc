#include "services/tools/batch/result_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <set>
#include <sstream>
#include <string_view>

#include "common/core/digest.h"
#include "common/core/host_name.h"
#include "common/core/read_text.h"
#include "common/core/signal_watcher.h"
#include "common/logfile/file_window.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/log_task.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

// "DIGEST" of what follows, then "DIGEST BYTES NAME" a line.
constexpr char kList[] = "files.txt";

std::string TextOf(const fs::path& path) { return ReadText(path, kMaxListBytes).value_or(""); }

std::string ListOf(const fs::path& folder) {
  const std::set<fs::path> files{fs::directory_iterator(folder), fs::directory_iterator()};
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

bool IsDone(const BatchFolder& folder, const Manifest& manifest, int log) {
  for (int i = 0; i < manifest.variant_size(); ++i) {
    if (!IsWhole(folder.result(manifest, log, i), ResultCheck::kQuick)) return false;
  }
  return !Compares(manifest) || IsWhole(folder.comparison(manifest, log), ResultCheck::kQuick);
}

bool IsLinkToAnswers(const fs::path& path) {
  std::error_code none;
  return fs::read_symlink(path, none).string().starts_with("../results/");
}

// @throws LogError when that is a file of the user's, not a link to answers.
void RemoveLink(const fs::path& link) {
  if (IsLinkToAnswers(link)) {
    fs::remove(link);
  } else if (fs::exists(fs::symlink_status(link))) {
    throw LogError(link, "is where a link to answers belongs; allowed: another --out");
  }
}

// Removes links of logs and variants that only an earlier batch had.
void RemoveOldLinks(const BatchFolder& folder, const Manifest& manifest) {
  std::set<fs::path> old;
  for (const auto& entry : fs::directory_iterator(folder.root() / "logs")) {
    if (IsLinkToAnswers(entry.path())) old.insert(entry.path());
  }
  for (const BatchLog& log : manifest.log()) {
    for (int i = 0; i < manifest.variant_size(); ++i) old.erase(folder.answers(log, i));
  }
  for (const fs::path& link : old) fs::remove(link);
}

// Whether a folder is called as ResultFolder calls an unfinished one: DIGEST.part-HOST-PROCESS.
bool IsPart(std::string_view name) {
  constexpr size_t kDigits = 16;
  return name.find_first_not_of("0123456789abcdef") == kDigits &&
         name.substr(kDigits).starts_with(".part-");
}

// @returns false when the result is damaged.
bool LinkOne(const BatchFolder& folder, const Manifest& manifest, int log, int variant) {
  const fs::path result = folder.result(manifest, log, variant);
  const fs::path link = folder.answers(manifest.log(log), variant);
  const fs::path target = fs::relative(result, link.parent_path()) / kAnswers;
  std::error_code none;
  if (fs::read_symlink(link, none) == target) return true;
  RemoveLink(link);
  if (!IsWhole(result, ResultCheck::kAll)) {
    std::cerr << fmt::format("sprout-batch: {}: damaged; log {} is computed again\n",
                             result.string(), log);
    MarkDamaged(result);
    return false;
  }
  if (fs::exists(result / kAnswers)) fs::create_symlink(target, link);
  return true;
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

std::optional<StageRun> ParseReplayReport(const std::string& output) {
  const size_t at = output.find(" events; frames: ");
  int64_t in = 0, out = 0, degenerate = 0, failed = 0, incomplete = 0, left_out = 0, bad = 0,
          damaged = 0;
  if (at == std::string::npos ||
      std::sscanf(output.c_str() + at,
                  " events; frames: %" SCNd64 " in, %" SCNd64 " out (%" SCNd64
                  " degenerate), %" SCNd64 " failed, %" SCNd64 " incomplete, %" SCNd64
                  " left out; %" SCNd64 " bad messages, %" SCNd64 " damaged bytes",
                  &in, &out, &degenerate, &failed, &incomplete, &left_out, &bad, &damaged) != 8) {
    return std::nullopt;
  }
  StageRun run;
  run.set_frames_in(in);
  run.set_frames_out(out);
  run.set_degenerate(degenerate);
  run.set_failed(failed);
  run.set_incomplete(incomplete);
  run.set_left_out(left_out);
  run.set_bad_messages(bad);
  run.set_damaged_bytes(damaged);
  return run;
}

StageRuns ReadStageRuns(const std::filesystem::path& result, const Manifest& manifest) {
  const std::filesystem::path path = result / kRuns;
  constexpr char kCure[] = "; remove its folder, and the log is computed again";
  StageRuns runs;
  const Result<std::string> text = ReadText(path);
  if (!text) throw LogError(path, text.error().text + kCure);
  try {
    ParseText(*text, "counts", runs);
  } catch (const ConfigError& e) {
    throw LogError(path, e.what() + std::string(kCure));
  }
  if (runs.run_size() != manifest.stage_size()) {
    throw LogError(path, "lacks the counts of a stage" + std::string(kCure));
  }
  for (const StageRun& run : runs.run()) {
    if (run.frames_in() >= 0 && run.frames_out() >= 0 && std::isfinite(run.seconds())) continue;
    throw LogError(path, "has a count that is not possible" + std::string(kCure));
  }
  return runs;
}

BatchState StateOf(const BatchFolder& folder, const Manifest& manifest) {
  BatchState state;
  for (int log = 0; log < manifest.log_size(); ++log) {
    state.done.push_back(IsDone(folder, manifest, log));
    if (!state.done.back()) ++state.missing;
  }
  return state;
}

BatchState LinkAnswers(const BatchFolder& folder, const Manifest& manifest) {
  fs::create_directories(folder.root() / "logs");
  RemoveOldLinks(folder, manifest);
  BatchState state = StateOf(folder, manifest);
  for (int log = 0; log < manifest.log_size(); ++log) {
    const auto at = static_cast<size_t>(log);
    for (int i = 0; i < manifest.variant_size(); ++i) {
      Interrupt::Check();
      if (!state.done[at]) {
        RemoveLink(folder.answers(manifest.log(log), i));  // of an earlier batch
      } else if (!LinkOne(folder, manifest, log, i)) {
        state.done[at] = false;
        ++state.missing;
      }
    }
  }
  return state;
}

void RemoveParts(const BatchFolder& folder) {
  std::vector<fs::path> parts;
  for (const char* const kind : {"results", "comparisons"}) {
    if (!fs::exists(folder.root() / kind)) continue;
    for (const auto& group : fs::directory_iterator(folder.root() / kind)) {
      if (!group.is_directory()) continue;  // a file of the user's
      for (const auto& result : fs::directory_iterator(group)) {
        if (IsPart(result.path().filename().string())) parts.push_back(result.path());
      }
    }
  }
  for (const fs::path& part : parts) fs::remove_all(part);
}

}  // namespace sprout::batch
