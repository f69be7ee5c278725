#include "common/inputs/reading.h"

#include <cmath>

namespace sprout::inputs {

double DepthOf(Reading reading, float number, const Eigen::Vector3d& ray) {
  switch (reading) {
    case Reading::kInverse:
      return 1 / number;
    case Reading::kAlongRay:
      return number / ray.norm();
    case Reading::kOtherBytes: {
      const auto mm = std::lround(std::fmod(1000.0 * number, 65536));
      return static_cast<double>((mm & 255) << 8 | mm >> 8) / 1000;
    }
    case Reading::kWithFlags:
      return static_cast<double>(std::lround(std::fmod(1000.0 * number, 65536)) & 0x1fff) / 1000;
    case Reading::kDepth:
      break;
  }
  return number;
}

const char* TextOf(Reading reading) {
  switch (reading) {
    case Reading::kInverse:
      return "ranges are large where stereo is near (one over them agrees with it at {:.0f} % of "
             "the matches): are they disparities, or inverse depths? give depths";
    case Reading::kAlongRay:
      return "ranges are too long towards the sides (as distances along the rays {:.0f} % of them "
             "agree with stereo): give depths along the range camera's axis, z of the points";
    case Reading::kOtherBytes:
      return "the bytes of the ranges are in the other order (swapped {:.0f} % of them agree with "
             "stereo): PNG has the high byte first";
    case Reading::kWithFlags:
      return "the ranges are mm in the lower 13 bits (then {:.0f} % of them agree with stereo): is "
             "their confidence in the upper three (Android's DEPTH16)? give mm alone";
    case Reading::kDepth:
      break;
  }
  return "";
}

}  // namespace sprout::inputs
