#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace sprout::temporal {

/// By how much the memory's variance grows where the new image differs from the last one: (T5) and
/// (T6).
class PhotometricDoubt {
 public:
  /// @param doubt_grey  grey levels that let the variance grow e-fold.
  /// @param drop_grey   from here on the memory is dropped, grey levels.
  PhotometricDoubt(double doubt_grey, double drop_grey);

  /// @param grey         the new left image.
  /// @param differences  of each cell of 2×2 pixels, grey levels; −1 = not known.
  /// @param growth       of the variance, of each cell; 0 = drop the memory.
  void Compute(const cv::Mat1b& grey, const cv::Mat1f& differences, cv::Mat1f& growth);

 private:
  static constexpr int kSteps = 16;             // of the table, in an e-fold
  static constexpr int kMaxSteps = 8 * kSteps;  // exp(8) times any variance is no knowledge

  float doubt_grey_, drop_grey_;
  std::array<float, kMaxSteps + 2> growth_;  // by steps; the last one drops
  cv::Mat1f means_, spreads_;                // memory
};

}  // namespace sprout::temporal
