#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_CALIBRATION_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_CALIBRATION_H_

#include <array>
#include <opencv2/core.hpp>

namespace sprout::evaluate {

/// Whether a map is as wrong as its confidence and its standard deviations say. NaN when no pixel
/// has a disparity and is scored; pixels without a disparity claim nothing, and are left out.
struct Calibration {
  static constexpr int kBins = 10;
  /// Pixels by the claimed probability p of an error > 1 px, a tenth each: mean p, and the share
  /// whose error is > 1 px, per cent.
  struct Bin {
    double claimed_percent = 0;
    double bad1_percent = 0;
  };
  std::array<Bin, kBins> bins{};
  double claimed_percent = 0;         ///< mean p of all
  double bad1_percent = 0;            ///< share of all with an error > 1 px
  double error_points = 0;            ///< mean of |claimed − bad 1| over the bins
  double within_1_sigma_percent = 0;  ///< |error| ≤ σ
  double within_2_sigma_percent = 0;  ///< |error| ≤ 2σ
};

/// @param disparity_px, truth, mask  as Score(), of one size.
/// @param confidence, sigma          of that size, as Part::kConfidence and Part::kSigma.
/// O(pixels).
Calibration Calibrate(const cv::Mat1f& disparity_px, const cv::Mat1f& truth, const cv::Mat1b& mask,
                      const cv::Mat1b& confidence, const cv::Mat1b& sigma);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_CALIBRATION_H_
