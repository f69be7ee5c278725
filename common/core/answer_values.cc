#include "common/core/answer_values.h"

#include <algorithm>
#include <opencv2/core.hpp>

#include "common/core/image.h"

namespace sprout {
namespace {

bool InImage(float u, float v, cv::Size size) {
  return u >= -0.5F && u <= static_cast<float>(size.width) - 0.5F && v >= -0.5F &&
         v <= static_cast<float>(size.height) - 0.5F;
}

}  // namespace

double LeastDisparity(const RectifiedPair& pair) {
  constexpr double kRoundingPx = 1;
  return std::min(0.0, pair.cx - pair.cx_right) - kRoundingPx;
}

std::optional<std::string> WrongDisparity(const DisparityImage& map, double least_px) {
  const double begin = least_px * DisparityImage::kCountsPerPixel;
  const int end = map.width() * DisparityImage::kCountsPerPixel;
  for (int v = 0; v < map.height(); ++v) {
    const int16_t* counts = map.counts()[v];
    for (int u = 0; u < map.width(); ++u) {
      if ((counts[u] >= begin && counts[u] < end) || counts[u] == DisparityImage::kInvalid)
        continue;
      return cv::format("disparity %g px at (%d, %d); allowed is %g to %d, or no disparity",
                        static_cast<double>(map.Px(u, v)), u, v, least_px, map.width() - 1);
    }
  }
  return std::nullopt;
}

std::optional<std::string> WrongSeed(std::span<const Seed> seeds, cv::Size size, double least_px) {
  for (size_t i = 0; i < seeds.size(); ++i) {
    const Seed& seed = seeds[i];
    const bool inside = InImage(seed.u, seed.v, size) && InImage(seed.u_right, seed.v, size);
    if (inside && seed.disparity() >= least_px) continue;
    return cv::format(
        "seed %zu is (u %g, v %g, u_right %g); allowed are places in both images (%s) with "
        "u - u_right >= %g",
        i, static_cast<double>(seed.u), static_cast<double>(seed.v),
        static_cast<double>(seed.u_right), SizeText(size).c_str(), least_px);
  }
  return std::nullopt;
}

}  // namespace sprout
