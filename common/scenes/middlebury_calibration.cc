#include "common/scenes/middlebury_calibration.h"

#include <fmt/core.h>

#include <cmath>
#include <optional>
#include <sstream>
#include <vector>

#include "common/config/required.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"
#include "common/core/read_text.h"
#include "common/scenes/calibration_lines.h"

namespace sprout::scenes {
namespace {

constexpr double kFullSizeFocalPx = 3740;  // 2005 and 2006, as Middlebury publishes them
constexpr double kBaselineM = 0.160;
constexpr double kMinBaselineMm = 1;     // less is in m
constexpr double kDoffsTolerancePx = 1;  // they may be rounded

// The "key=value" lines of a calib.txt.
CalibrationLines MiddleburyLines(const std::filesystem::path& path) {
  return {path, "=", "cam0, cam1 and baseline"};
}

double Number(const CalibrationLines& calib, const std::string& key) {
  const std::optional<double> number = ParseNumber<double>(calib.Text(key));
  if (!number) throw calib.Bad(key, "a finite number");
  return *number;
}

// Camera matrix [f 0 cx; 0 f cy; 0 0 1], row by row.
std::vector<double> Matrix(const CalibrationLines& calib, const std::string& key) {
  const std::string& text = calib.Text(key);
  constexpr char kAllowed[] = "[f 0 cx; 0 f cy; 0 0 1] with finite numbers";
  if (text.size() < 2 || text.front() != '[' || text.back() != ']') throw calib.Bad(key, kAllowed);
  std::string body = text.substr(1, text.size() - 2);
  for (char& c : body) {
    if (c == ';' || c == ',') c = ' ';
  }
  std::vector<double> numbers;
  std::istringstream words(body);
  for (std::string word; words >> word;) {
    const std::optional<double> number = ParseNumber<double>(word);
    if (!number) throw calib.Bad(key, kAllowed);
    numbers.push_back(*number);
  }
  if (numbers.size() != 9) throw calib.Bad(key, kAllowed);
  return numbers;
}

double ReadDmin(const std::filesystem::path& path, double missing_dmin_px) {
  std::error_code ignored;
  const auto kind = std::filesystem::symlink_status(path, ignored).type();
  if (kind == std::filesystem::file_type::not_found) return missing_dmin_px;
  NoteInputFile(path);
  const Result<std::string> text = ReadText(path);
  if (!text) {
    throw ConfigError("calibration " + path.string() + ": " + text.error().text +
                      "; allowed: a file of one finite number, px at full size");
  }
  const std::optional<double> dmin = ParseNumber<double>(Trimmed(*text));
  if (!dmin) {
    throw ConfigError("calibration " + path.string() +
                      ": not a number; allowed: one finite number, px at full size");
  }
  return *dmin;
}

// The pair of images of any size.
RectifiedPair PairOf(const CalibrationLines& calib) {
  const std::vector<double> left = Matrix(calib, "cam0");
  const std::vector<double> right = Matrix(calib, "cam1");
  RectifiedPair pair;
  pair.focal_px = left[0];
  pair.cx = left[2];
  pair.cy = left[5];
  pair.cx_right = right[2];
  pair.baseline_m = Number(calib, "baseline") / 1000;

  if (pair.focal_px <= 0) throw calib.Bad("cam0", "a focal length above 0");
  if (pair.baseline_m <= 0) throw calib.Bad("baseline", "a number above 0, mm");
  if (1000 * pair.baseline_m < kMinBaselineMm) {
    throw calib.Bad("baseline", "at least 1, in Middlebury's unit, which is mm; is it in m?");
  }
  if (!AreRectified({left[0], left[4], left[5]}, {right[0], right[4], right[5]})) {
    throw calib.Bad("cam1", "one focal length for both cameras and axes, and cam0's row");
  }
  if (const double doffs = pair.cx_right - pair.cx;
      calib.Has("doffs") && std::abs(Number(calib, "doffs") - doffs) > kDoffsTolerancePx) {
    throw calib.Bad("doffs",
                    fmt::format("{:.6g} ± 1 px, which is cx of cam1 less that of cam0", doffs));
  }
  for (const char* key : {"width", "height"}) {
    if (calib.Has(key)) Number(calib, key);
  }
  return pair;
}

// The same of images of a size.
RectifiedPair Sized(RectifiedPair pair, const CalibrationLines& calib, cv::Size size) {
  for (const auto& [key, px] : {std::pair{"width", size.width}, {"height", size.height}}) {
    if (calib.Has(key) && Number(calib, key) != px) {
      throw calib.Bad(key, std::to_string(px) + ", as the images have");
    }
  }
  pair.width = size.width;
  pair.height = size.height;
  return pair;
}

}  // namespace

RectifiedPair CalibrationFromDmin(const std::filesystem::path& dmin_file, double missing_dmin_px,
                                  cv::Size size, int scale) {
  RectifiedPair pair{.width = size.width, .height = size.height};
  pair.focal_px = kFullSizeFocalPx / scale;
  pair.cx = (size.width - 1) / 2.0;
  pair.cy = (size.height - 1) / 2.0;
  // Z = f·b / (d + dmin): what was subtracted is the difference of the principal points.
  pair.cx_right = pair.cx + ReadDmin(dmin_file, missing_dmin_px) / scale;
  pair.baseline_m = kBaselineM;
  return pair;
}

RectifiedPair CalibrationFromCalib(const std::filesystem::path& calib_file, cv::Size size) {
  const CalibrationLines calib = MiddleburyLines(calib_file);
  return Sized(PairOf(calib), calib, size);
}

PairCalibration OpenCalibFile(const std::filesystem::path& path) {
  const std::string text = Required(ReadText(path), "calibration " + path.string() + ": ");
  // There may be blanks around '='.
  if (const CalibrationLines calib = MiddleburyLines(path); calib.Has("cam0")) {
    return [calib, pair = PairOf(calib)](cv::Size size, bool) { return Sized(pair, calib, size); };
  }
  if (text.find("P0:") != std::string::npos || text.find("P2:") != std::string::npos ||
      text.find("P_rect_0") != std::string::npos) {
    return OpenKittiPairs(path);
  }
  throw ConfigError(
      "calibration " + path.string() +
      ": neither Middlebury's (cam0=) nor KITTI's (P2:, P_rect_02:); allowed: one of "
      "these, --focal-px and --baseline-m, or of OpenCV, ROS and Kalibr --rig with what "
      "sprout-calibrate import makes of it");
}

}  // namespace sprout::scenes
