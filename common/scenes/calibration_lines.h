#pragma once

#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"
#include "common/core/read_text.h"

namespace sprout::scenes {

/// The calibration of a data set as text: a key, a separator and a value a line.
class CalibrationLines {
 public:
  /// @param separator  "=" or ": "; blanks around it do not count.
  /// @param needed     keys that a file should have, for messages.
  /// @throws ConfigError when it cannot be read.
  CalibrationLines(const std::filesystem::path& path, std::string separator, std::string needed)
      : path_(path), separator_(std::move(separator)), needed_(std::move(needed)) {
    NoteInputFile(path);
    const Result<std::string> text = ReadText(path);
    if (!text) throw Refusal(text.error().text);
    for (const std::string_view line : SplitAt('\n', *text)) {
      const size_t end = line.find(separator_.front());
      if (end == std::string_view::npos) continue;
      const std::string key(Trimmed(line.substr(0, end)));
      if (values_.contains(key)) repeated_.insert(key);
      values_[key] = Trimmed(line.substr(end + 1));
    }
  }

  bool Has(const std::string& key) const { return values_.contains(key); }

  /// @throws ConfigError when there is none, or more than one.
  const std::string& Text(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) throw Refusal(key + " is missing");
    if (repeated_.contains(key)) {
      throw ConfigError("calibration " + path_.string() + ": " + key +
                        " is given more than once; allowed: once");
    }
    return found->second;
  }

  /// The error for a value that cannot be used. @pre Has(key).
  ConfigError Bad(const std::string& key, const std::string& allowed) const {
    return ConfigError("calibration " + path_.string() + ": " + key + separator_ + Text(key) +
                       ": allowed: " + allowed);
  }

 private:
  ConfigError Refusal(const std::string& why) const {
    return ConfigError("calibration " + path_.string() + ": " + why + "; allowed: a file with " +
                       needed_);
  }

  std::filesystem::path path_;
  std::string separator_;
  std::string needed_;
  std::map<std::string, std::string> values_;
  std::set<std::string> repeated_;  // only a key that is read must not be
};

/// What the two matrices of a rectified pair have in common.
struct RectifiedLens {
  double fx_px;
  double fy_px;
  double cy_px;  ///< row of the principal point
};

/// Whether both cameras have one focal length, the same on both axes, and the same row of the
/// principal point, but for the rounding of numbers that are written as text (0.01 px).
inline bool AreRectified(const RectifiedLens& left, const RectifiedLens& right) {
  constexpr double kRoundingPx = 0.01;
  const auto same = [](double a, double b) { return std::abs(a - b) <= kRoundingPx; };
  return same(left.fx_px, left.fy_px) && same(left.fx_px, right.fx_px) &&
         same(left.fx_px, right.fy_px) && same(left.cy_px, right.cy_px);
}

}  // namespace sprout::scenes
