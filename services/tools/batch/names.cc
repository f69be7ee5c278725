#include "services/tools/batch/names.h"

#include <fmt/format.h>

#include "common/config/config_error.h"
#include "common/core/printable.h"
#include "common/messages/shortened.h"

namespace sprout::batch {
namespace {

constexpr size_t kLongestName = 200;  // a file name has 255 bytes, and endings come behind it
constexpr std::string_view kNotInNames = "/,\"";

}  // namespace

bool IsPlainText(std::string_view text) { return Printable(text) == text; }

void RequirePlainText(const std::string& flag, const std::string& text) {
  if (IsPlainText(text)) return;
  throw ConfigError(
      fmt::format("{} '{}': allowed is UTF-8 without control characters", flag, Printable(text)));
}

bool IsResultName(std::string_view name) {
  return !name.empty() && name.size() <= kLongestName && name != "." && name != ".." &&
         name.find_first_of(kNotInNames) == std::string_view::npos && IsPlainText(name);
}

std::string ResultNameOf(const std::filesystem::path& log, std::set<std::string>& taken) {
  constexpr size_t kRoomForNumber = 20;
  std::string stem = Shortened(log.stem().string(), kLongestName - kRoomForNumber);
  for (char& letter : stem) {
    if (kNotInNames.find(letter) != std::string_view::npos) letter = '_';
  }
  if (!IsResultName(stem)) stem = "log";
  std::string name = stem;
  for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}-{}", stem, i);
  return name;
}

}  // namespace sprout::batch
