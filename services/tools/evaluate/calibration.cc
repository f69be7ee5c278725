#include "services/tools/evaluate/calibration.h"

#include <algorithm>
#include <cmath>

#include "common/core/prior_map.h"

namespace sprout::evaluate {
namespace {

struct Level {
  double pixels = 0;
  double bad = 0;
};

// Surest first; pixels of one confidence are spread evenly over the bins that it belongs to.
void FillBins(const std::array<Level, 256>& levels, double all, Calibration& result) {
  const double size = all / Calibration::kBins;
  size_t level = levels.size() - 1;
  double left = levels[level].pixels;  // of the level
  for (Calibration::Bin& bin : result.bins) {
    double room = size;
    double claimed = 0;
    double bad = 0;
    while (room > 0) {
      while (left <= 0 && level > 0) left = levels[--level].pixels;
      const double taken = level == 0 ? room : std::min(room, left);
      claimed += taken * (1 - static_cast<double>(level) / 255);
      if (levels[level].pixels > 0) bad += taken * levels[level].bad / levels[level].pixels;
      left -= taken;
      room -= taken;
    }
    bin = {.claimed_percent = 100 * claimed / size, .bad1_percent = 100 * bad / size};
    result.error_points += std::abs(bin.claimed_percent - bin.bad1_percent) / Calibration::kBins;
  }
}

}  // namespace

Calibration Calibrate(const cv::Mat1f& disparity_px, const cv::Mat1f& truth, const cv::Mat1b& mask,
                      const cv::Mat1b& confidence, const cv::Mat1b& sigma) {
  std::array<Level, 256> levels{};
  double all = 0;
  double bad = 0;
  double claimed = 0;
  double within_1 = 0;
  double within_2 = 0;
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      const double error = std::abs(double{disparity_px(v, u)} - double{truth(v, u)});
      if (mask(v, u) == 0 || !std::isfinite(error)) continue;
      Level& level = levels[confidence(v, u)];
      level.pixels += 1;
      level.bad += error > 1;
      all += 1;
      bad += error > 1;
      claimed += 1 - confidence(v, u) / 255.0;
      const double sigma_px = double{SigmaToPx(sigma(v, u))};
      within_1 += error <= sigma_px;
      within_2 += error <= 2 * sigma_px;
    }
  }
  Calibration result;
  result.claimed_percent = 100 * claimed / all;
  result.bad1_percent = 100 * bad / all;
  result.within_1_sigma_percent = 100 * within_1 / all;
  result.within_2_sigma_percent = 100 * within_2 / all;
  if (all > 0) {
    FillBins(levels, all, result);
  } else {
    result.error_points = std::nan("");
  }
  return result;
}

}  // namespace sprout::evaluate
