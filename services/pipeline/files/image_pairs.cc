#include "services/pipeline/files/image_pairs.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <system_error>

#include "common/config/config_error.h"
#include "common/core/joined.h"
#include "common/core/read_text.h"
#include "services/capture/video_pictures.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

// What a folder is searched for; a file that is named may be called anything.
constexpr std::string_view kExtensions[] = {".png", ".jpg", ".jpeg", ".pgm",  ".ppm",
                                            ".pnm", ".bmp", ".tif",  ".tiff", ".pfm"};

constexpr std::string_view kVideoExtensions[] = {".mp4", ".avi", ".mkv",  ".mov", ".webm",
                                                 ".m4v", ".mpg", ".mpeg", ".wmv", ".ts"};

bool HasExtension(const fs::path& path, std::span<const std::string_view> extensions) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return std::ranges::find(extensions, extension) != extensions.end();
}

// Hidden files, such as macOS leaves beside each one ("._7.png"), are no images of the user's.
bool IsImageName(const fs::path& path) {
  return HasExtension(path, kExtensions) && !path.filename().native().starts_with('.');
}

bool IsVideo(const fs::path& path) {
  std::error_code ignored;
  return HasExtension(path, kVideoExtensions) && fs::is_regular_file(path, ignored);
}

std::vector<std::string> ImagesIn(const std::string& what, const fs::path& folder) {
  std::vector<std::string> images;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored) && IsImageName(entry->path())) {
      images.push_back(entry->path());
    }
  }
  if (error) throw ConfigError(what + ' ' + folder.string() + ": " + error.message());
  return images;
}

bool IsPattern(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

std::vector<fs::path> FilesOf(const std::string& what, const std::string& text) {
  std::error_code ignored;
  if (fs::is_regular_file(text, ignored)) return {text};
  const bool is_folder = fs::is_directory(text, ignored);
  if (!is_folder && !IsPattern(text)) {
    throw ConfigError(fmt::format(
        "{} {}: {}{}; allowed: an image, a folder of images, or a pattern in quotes", what, text,
        fs::exists(text, ignored) ? "neither a file nor a folder" : "not there", WhyClosed(text)));
  }
  const std::vector<std::string> names =
      is_folder ? ImagesIn(what, text) : capture::FilesMatching(text);
  if (names.empty()) {
    throw ConfigError(fmt::format("{} {}: {}{}", what, text,
                                  is_folder ? "holds no image" : "no file is called so",
                                  WhyClosed(text)));
  }
  std::vector<fs::path> files(names.begin(), names.end());
  std::ranges::sort(files);  // file systems have no order
  return files;
}

bool HaveDifferentFolders(const std::vector<ImagePair>& pairs) {
  std::set<fs::path> folders;
  return std::ranges::all_of(
      pairs, [&](const ImagePair& pair) { return folders.insert(pair.folder).second; });
}

void NameFolders(std::vector<ImagePair>& pairs) {
  for (ImagePair& pair : pairs) {
    pair.folder = pair.left.stem();
    if (pair.folder == "." || pair.folder == "..") {  // of "..png", "...png"
      throw ConfigError(
          fmt::format("LEFT {}: its results would go to {}; allowed: a name that is no step up",
                      pair.left.string(), pair.folder.string()));
    }
  }
  if (HaveDifferentFolders(pairs)) return;
  for (ImagePair& pair : pairs) {
    pair.folder = pair.left.parent_path().filename().string() + "_" + pair.left.stem().string();
  }
  if (!HaveDifferentFolders(pairs)) {
    throw ConfigError(
        "LEFT: images of one name, so that their results would go to one place; "
        "allowed: names that differ, or folders that do");
  }
}

// "3 images of RIGHT have no partner: r/1.png, r/2.png, r/7.png"
void NoteAlone(const std::string& what, const std::vector<size_t>& alone,
               const std::vector<std::string>& files, const std::string& what_happens,
               std::vector<std::string>& notes) {
  constexpr size_t kNamed = 5;
  if (alone.empty()) return;
  std::string names = Joined(", ", std::span(alone).first(std::min(alone.size(), kNamed)),
                             [&](size_t i) { return files[i]; });
  if (alone.size() > kNamed) names += ", ...";
  notes.push_back(fmt::format("{} of {} images of {} {}: {}", alone.size(), files.size(), what,
                              what_happens, names));
}

void NoteOrder(const std::string& what, const PairedNames& paired,
               std::vector<std::string>& notes) {
  if (paired.by != PairedBy::kOrder) return;
  notes.push_back(fmt::format(
      "{} belong together in the order of their names: nothing in these says more", what));
}

// Warns where one camera may count from 0 and the other from 1: then equal numbers are of different
// moments.
void NoteShifted(const std::string& what, const PairedNames& paired,
                 const std::vector<std::string>& first, const std::vector<std::string>& second,
                 std::vector<std::string>& notes) {
  const bool may_be = paired.by == PairedBy::kName && !paired.pairs.empty() &&
                      !paired.alone_first.empty() && first.size() == second.size();
  if (!may_be) return;
  const auto are_before = [](const auto& alone, const auto& names, size_t from) {
    return std::ranges::all_of(alone, [&](size_t i) { return ComesBefore(names[i], names[from]); });
  };
  const auto are_behind = [](const auto& alone, const auto& names, size_t to) {
    return std::ranges::all_of(alone, [&](size_t i) { return ComesBefore(names[to], names[i]); });
  };
  const auto [first_begin, second_begin] = paired.pairs.front();
  const auto [first_end, second_end] = paired.pairs.back();
  const bool is_shifted = (are_before(paired.alone_first, first, first_begin) &&
                           are_behind(paired.alone_second, second, second_end)) ||
                          (are_behind(paired.alone_first, first, first_end) &&
                           are_before(paired.alone_second, second, second_begin));
  if (!is_shifted) return;
  notes.push_back(fmt::format(
      "{} are as many, and one begins earlier: are equal numbers of one moment? If not: rename one",
      what));
}

std::vector<std::string> Texts(const std::vector<fs::path>& paths) {
  return {paths.begin(), paths.end()};
}

// @param named  both are files that the user names.
PairedNames Join(const std::string& what, bool named, const std::vector<std::string>& first,
                 const std::vector<std::string>& second, double max_spread_ms) {
  if (named) return {.by = PairedBy::kName, .pairs = {{0, 0}}};
  Result<PairedNames> paired = PairNames(first, second, max_spread_ms);
  if (!paired) throw ConfigError(what + ": " + paired.error().text);
  return *std::move(paired);
}

// Gives each pair its ToF image.
void AddTof(bool named, const std::vector<fs::path>& lefts, const std::vector<fs::path>& tofs,
            double max_spread_ms, ImagePairs& found) {
  const std::vector<std::string> tof_names = Texts(tofs);
  const std::vector<std::string> left_names = Texts(lefts);
  const PairedNames paired = Join("LEFT and --tof", named, left_names, tof_names, max_spread_ms);
  NoteOrder("LEFT and --tof", paired, found.notes);
  std::map<fs::path, fs::path> tof_of;
  for (const auto& [left, tof] : paired.pairs) tof_of[lefts[left]] = tofs[tof];
  std::vector<std::string> pairs;
  std::vector<size_t> without;
  for (ImagePair& pair : found.pairs) {
    const auto tof = tof_of.find(pair.left);
    if (tof == tof_of.end()) {
      without.push_back(pairs.size());
    } else {
      pair.tof = tof->second;
    }
    pairs.push_back(pair.left);
  }
  NoteShifted("LEFT and --tof", paired, left_names, tof_names, found.notes);
  NoteAlone("LEFT", without, pairs, "have no ToF image, their pairs are computed without",
            found.notes);
  NoteAlone("--tof", paired.alone_second, tof_names, "have no left image and are not used",
            found.notes);
}

// When the pictures of a video are shown, ns, and how many there are a second.
struct VideoTimes {
  std::vector<int64_t> times;
  double rate = 0;
};

VideoTimes TimesOf(const std::string& what, const std::string& path) {
  constexpr int64_t kNsPerUs = 1000;
  const auto video = capture::OpenVideoPictures(path);
  if (!video) throw ConfigError(what + " " + path + ": cannot be opened as a video");
  VideoTimes found{.times = {}, .rate = video->Rate()};
  if (found.rate <= 0) throw ConfigError(what + " " + path + ": does not say its rate");
  while (video->Grab()) {
    const std::optional<int64_t> time = video->Time();
    if (!time) break;
    found.times.push_back(kNsPerUs * *time);
  }
  return found;
}

void RequireDifferent(const std::string& left, const std::string& right) {
  std::error_code none;
  if (left != right && !fs::equivalent(left, right, none)) return;
  throw ConfigError("LEFT and RIGHT: both are " + left +
                    "; allowed: one of each camera, of views side by side its half");
}

ImagePairs ListVideoPairs(const std::string& left, const std::string& right,
                          const std::string& tof) {
  if (!IsVideo(left) || !IsVideo(right)) {
    throw ConfigError("LEFT and RIGHT: one is a video, the other is not; allowed: two of a kind");
  }
  if (!tof.empty()) throw ConfigError("--tof " + tof + ": not with videos; allowed: none");
  const VideoTimes lefts = TimesOf("LEFT", left);
  const VideoTimes rights = TimesOf("RIGHT", right);
  const double half_period_ms = 500 / std::max(lefts.rate, rights.rate);
  const PairedNames paired = PairTimes(lefts.times, rights.times, half_period_ms);
  ImagePairs found;
  for (const auto& [first, second] : paired.pairs) {
    found.pairs.push_back({.left = left,
                           .right = right,
                           .tof = {},
                           .left_frame = static_cast<int64_t>(first),
                           .right_frame = static_cast<int64_t>(second),
                           .folder = fmt::format("{:06}", first)});
  }
  // Most pictures of the faster video have no partner.
  const bool left_is_slower = lefts.rate <= rights.rate;
  found.left_out = std::ssize(left_is_slower ? paired.alone_first : paired.alone_second);
  if (lefts.rate != rights.rate) {
    found.notes.push_back(fmt::format("videos of {:g} and {:g} pictures a second: joined by time",
                                      lefts.rate, rights.rate));
  }
  if (found.left_out > 0) {
    found.notes.push_back(fmt::format("{} pictures of {} have no partner and are left out",
                                      found.left_out, left_is_slower ? "LEFT" : "RIGHT"));
  }
  if (found.pairs.empty()) throw ConfigError("LEFT and RIGHT: no two pictures are of one time");
  return found;
}

}  // namespace

ImagePairs ListPairs(const std::string& left, const std::string& right, const std::string& tof,
                     double max_spread_ms) {
  RequireDifferent(left, right);
  if (IsVideo(left) || IsVideo(right)) return ListVideoPairs(left, right, tof);
  const std::vector<fs::path> lefts = FilesOf("LEFT", left);
  const std::vector<fs::path> rights = FilesOf("RIGHT", right);
  const std::vector<fs::path> tofs = tof.empty() ? std::vector<fs::path>() : FilesOf("--tof", tof);
  const std::vector<std::string> left_names = Texts(lefts);
  const std::vector<std::string> right_names = Texts(rights);
  const PairedNames paired = Join("LEFT and RIGHT", lefts[0] == left && rights[0] == right,
                                  left_names, right_names, max_spread_ms);
  ImagePairs found;
  for (const auto& [first, second] : paired.pairs) {
    found.pairs.push_back({.left = lefts[first], .right = rights[second]});
  }
  found.left_out = std::ssize(paired.alone_first) + std::ssize(paired.alone_second);
  NoteOrder("LEFT and RIGHT", paired, found.notes);
  NoteShifted("LEFT and RIGHT", paired, left_names, right_names, found.notes);
  NoteAlone("LEFT", paired.alone_first, left_names, "have no right image and are left out",
            found.notes);
  NoteAlone("RIGHT", paired.alone_second, right_names, "have no left image and are left out",
            found.notes);
  if (!tof.empty()) AddTof(lefts[0] == left && tofs[0] == tof, lefts, tofs, max_spread_ms, found);
  if (lefts[0] != left) NameFolders(found.pairs);
  return found;
}

}  // namespace sprout
