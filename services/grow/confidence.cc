#include "services/grow/confidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace sprout {
namespace {

// Shares of the confidence, in whole numbers, so that its bytes are the same on every machine.
constexpr int kOne = 1 << 16;
constexpr int kEdgeWeight = kOne * 6 / 10;
constexpr int kGapWeight = kOne * 2 / 10;
constexpr int kPhotoWeight = kOne * 2 / 10;
constexpr double kEdgeRangePx = 8;
constexpr double kLargestExponent = 5;
constexpr int kGapWindow = 9;
constexpr int kPhotoWindow = 5;

// Distance to the next depth edge, px.
cv::Mat1f DistanceToEdges(const DisparityImage& map) {
  const cv::Mat1b window(3, 3, uint8_t{1});
  cv::Mat1s most;
  cv::Mat1s least;
  cv::dilate(map.counts(), most, window);
  cv::erode(map.counts(), least, window);
  cv::Mat1s range;
  cv::subtract(most, least, range);  // saturates
  cv::Mat1b even;
  cv::compare(range, DisparityImage::kCountsPerPixel, even, cv::CMP_LE);
  cv::Mat1f distance_px;
  cv::distanceTransform(even, distance_px, cv::DIST_L2, cv::DIST_MASK_3);
  return distance_px;
}

// Number of pixels in the window that have no disparity.
cv::Mat1i GapsAround(const DisparityImage& map) {
  cv::Mat1b gap;
  cv::compare(map.counts(), DisparityImage::kInvalid, gap, cv::CMP_EQ);
  cv::min(gap, 1, gap);
  cv::Mat1i gaps;
  cv::boxFilter(gap, gaps, CV_32S, {kGapWindow, kGapWindow}, {-1, -1}, /*normalize=*/false);
  return gaps;
}

// The left image as the disparities make it from the right one; black where they leave it.
cv::Mat1b Warped(const cv::Mat1b& right, const DisparityImage& map) {
  constexpr int kCounts = DisparityImage::kCountsPerPixel;
  cv::Mat1b warped(map.size(), uint8_t{0});
  for (int v = 0; v < map.height(); ++v) {
    const int16_t* counts = map.counts()[v];
    for (int u = 0; u < map.width(); ++u) {
      if (counts[u] == DisparityImage::kInvalid) continue;
      const int u_right = u - (counts[u] + kCounts / 2) / kCounts;
      if (u_right >= 0 && u_right < right.cols) warped(v, u) = right(v, u_right);
    }
  }
  return warped;
}

cv::Mat1i SumsOfSquares(const cv::Mat1b& image) {
  cv::Mat1i sums;
  cv::sqrBoxFilter(image, sums, CV_32S, {kPhotoWindow, kPhotoWindow}, {-1, -1},
                   /*normalize=*/false);
  return sums;
}

// Σ (wL − wR)² and Σ (wL² + wR²) around every pixel.
struct PhotoSums {
  cv::Mat1i difference;
  cv::Mat1i energy;

  PhotoSums(const cv::Mat1b& left, const cv::Mat1b& warped) {
    cv::Mat1b off;
    cv::absdiff(left, warped, off);
    difference = SumsOfSquares(off);
    cv::add(SumsOfSquares(left), SumsOfSquares(warped), energy);
  }
};

// exp(−r / 8) for r in quarters of a pixel.
class EdgePenalty {
 public:
  EdgePenalty() {
    for (size_t i = 0; i < penalty_.size(); ++i) {
      const double exponent = static_cast<double>(i) / (kSteps * kEdgeRangePx);
      penalty_[i] = static_cast<int>(std::lround(kEdgeWeight * std::exp(-exponent)));
    }
  }
  int At(float distance_px) const {
    const auto step = static_cast<size_t>(std::lround(distance_px * kSteps));
    return penalty_[std::min(step, penalty_.size() - 1)];
  }

 private:
  static constexpr int kSteps = 4;
  std::array<int, 64 * kSteps> penalty_{};
};

}  // namespace

cv::Mat1b Confidence(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& grown,
                     const DisparityImage& filled, double sigma_s_squared) {
  static const EdgePenalty edge_penalty;
  const cv::Mat1f edge_px = DistanceToEdges(filled);
  const cv::Mat1i gaps = GapsAround(grown);
  const PhotoSums photo(left, Warped(right, filled));
  cv::Mat1b confidence(filled.size(), uint8_t{0});
  for (int v = 0; v < confidence.rows; ++v) {
    for (int u = 0; u < confidence.cols; ++u) {
      if (!filled.IsValid(u, v)) continue;
      const double energy = sigma_s_squared * std::max(photo.energy(v, u), 1);
      const double misfit = photo.difference(v, u) / energy / kLargestExponent;  // Eq. (4)
      const int penalty = edge_penalty.At(edge_px(v, u)) +
                          kGapWeight * gaps(v, u) / (kGapWindow * kGapWindow) +
                          static_cast<int>(kPhotoWeight * std::min(misfit, 1.0));
      confidence(v, u) = static_cast<uint8_t>((255 * (kOne - penalty) + kOne / 2) / kOne);
    }
  }
  return confidence;
}

}  // namespace sprout
