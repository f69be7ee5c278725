#include "services/capture/image_list.h"

#include <glob.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

#include "common/config/config_error.h"
#include "common/core/number_text.h"
#include "common/core/pair_names.h"

namespace sprout::capture {
namespace {

// The text as it is in a pattern of glob().
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '*' || c == '?' || c == '[' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::vector<std::string> Matching(const std::string& pattern) {
  glob_t found{};
  std::vector<std::string> files;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    for (const char* path : std::span(found.gl_pathv, found.gl_pathc)) files.emplace_back(path);
  }
  globfree(&found);
  return files;
}

// Whether printf() writes a number so with at least `width` digits.
bool IsNumber(std::string_view text, size_t width) {
  const bool is_number =
      !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
  return is_number && text.size() >= width &&
         (text.size() == std::max<size_t>(width, 1) || text.front() != '0');
}

}  // namespace

std::vector<std::string> ImageList(const std::string& pattern) {
  const auto refuse = [&](const std::string& why) {
    throw ConfigError("image list " + pattern + ": " + why);
  };
  const size_t percent = pattern.find('%');
  const size_t end = pattern.find('d', percent);
  const std::string before = pattern.substr(0, percent);
  const std::string after = end == std::string::npos ? std::string() : pattern.substr(end + 1);
  const std::string width = pattern.substr(percent + 1, end - percent - 1);
  const auto digits = width.empty() ? 0 : ParseNumber<int>(width);
  constexpr int kMaxDigits = 20;
  if (end == std::string::npos || after.find('%') != std::string::npos || !digits || *digits < 0 ||
      *digits > kMaxDigits) {
    refuse("not a name with one number; allowed: such as left_%04d.png");
  }
  std::vector<std::string> files = Matching(Escaped(before) + '*' + Escaped(after));
  std::erase_if(files, [&](const std::string& file) {
    const std::string_view number =
        std::string_view(file).substr(before.size(), file.size() - before.size() - after.size());
    return !IsNumber(number, static_cast<size_t>(*digits));
  });
  if (files.empty()) refuse("cannot be opened: no image is called so");
  std::ranges::sort(files, ComesBefore);
  return files;
}

}  // namespace sprout::capture
