#include "common/scenes/calib_file.h"

#include "common/config/config_error.h"
#include "common/core/read_text.h"
#include "common/scenes/kitti_calibration.h"
#include "common/scenes/middlebury_calibration.h"

namespace sprout::scenes {

RectifiedPair ReadCalibFile(const std::filesystem::path& path, cv::Size size, bool grey) {
  const Result<std::string> text = ReadText(path);
  if (!text) throw ConfigError("calibration " + path.string() + ": " + text.error().text);
  if (text->find("cam0=") != std::string::npos) return CalibrationFromCalib(path, size);
  if (text->find("P0:") != std::string::npos || text->find("P2:") != std::string::npos ||
      text->find("P_rect_0") != std::string::npos) {
    return ReadKittiPair(path, size, grey);
  }
  throw ConfigError("calibration " + path.string() +
                    ": neither Middlebury's (cam0=) nor KITTI's (P2:, P_rect_02:); allowed: one of "
                    "these, or --focal-px and --baseline-m");
}

}  // namespace sprout::scenes
