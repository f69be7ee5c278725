#include "services/pipeline/files/image_pairs.h"

#include <fmt/core.h>
#include <glob.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <span>
#include <string_view>
#include <system_error>

#include "common/config/config_error.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

// What a folder is searched for; a file that is named may be called anything.
constexpr std::string_view kExtensions[] = {".png", ".jpg", ".jpeg", ".pgm",  ".ppm",
                                            ".pnm", ".bmp", ".tif",  ".tiff", ".pfm"};

bool IsImageName(const fs::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return std::ranges::find(kExtensions, extension) != std::end(kExtensions);
}

std::vector<fs::path> ImagesIn(const std::string& what, const fs::path& folder) {
  std::vector<fs::path> images;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored) && IsImageName(entry->path())) images.push_back(*entry);
  }
  if (error) throw ConfigError(what + ' ' + folder.string() + ": " + error.message());
  return images;
}

std::vector<fs::path> Matching(const std::string& pattern) {
  glob_t found{};
  std::vector<fs::path> files;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    for (const char* path : std::span(found.gl_pathv, found.gl_pathc)) files.emplace_back(path);
  }
  globfree(&found);
  return files;
}

bool IsPattern(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

std::vector<fs::path> FilesOf(const std::string& what, const std::string& text) {
  std::error_code ignored;
  if (fs::is_regular_file(text, ignored)) return {text};
  const bool is_folder = fs::is_directory(text, ignored);
  if (!is_folder && !IsPattern(text)) {
    throw ConfigError(fmt::format(
        "{} {}: not there; allowed: an image, a folder of images, or a pattern in quotes", what,
        text));
  }
  std::vector<fs::path> files = is_folder ? ImagesIn(what, text) : Matching(text);
  if (files.empty()) {
    throw ConfigError(fmt::format("{} {}: {}", what, text,
                                  is_folder ? "holds no image" : "no file is called so"));
  }
  // Not by the locale, which would be another order on another machine.
  std::ranges::sort(files);
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

void RequireAsMany(const std::string& what, size_t count, size_t lefts) {
  if (count == lefts) return;
  throw ConfigError(
      fmt::format("LEFT has {} images and {} {}: allowed is the same number", lefts, what, count));
}

}  // namespace

std::vector<ImagePair> ListPairs(const std::string& left, const std::string& right,
                                 const std::string& tof) {
  const std::vector<fs::path> lefts = FilesOf("LEFT", left);
  const std::vector<fs::path> rights = FilesOf("RIGHT", right);
  const std::vector<fs::path> tofs = tof.empty() ? std::vector<fs::path>() : FilesOf("--tof", tof);
  RequireAsMany("RIGHT", rights.size(), lefts.size());
  if (!tof.empty()) RequireAsMany("--tof", tofs.size(), lefts.size());
  std::vector<ImagePair> pairs;
  for (size_t i = 0; i < lefts.size(); ++i) {
    pairs.push_back({.left = lefts[i],
                     .right = rights[i],
                     .tof = tof.empty() ? fs::path() : tofs[i],
                     .folder = {}});
  }
  if (lefts[0] != left) NameFolders(pairs);
  return pairs;
}

}  // namespace sprout
