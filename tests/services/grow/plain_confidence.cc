#include "tests/services/grow/plain_confidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/core/parallel.h"
#include "services/grow/confidence_kernel.h"
#include "services/grow/similarity-inl.h"

namespace sprout::grow {
namespace {

constexpr double kEdgeRangePx = 8;

// The left image as the disparities make it from the right one; black where they leave it.
cv::Mat1b Warp(const cv::Mat1b& right, const DisparityImage& map) {
  constexpr int kCounts = DisparityImage::kCountsPerPixel;
  cv::Mat1b warped(map.size());
  for (int v = 0; v < map.height(); ++v) {
    const int16_t* counts = map.counts()[v];
    for (int u = 0; u < map.width(); ++u) {
      const int u_right = u - std::min(counts[u] + kCounts / 2, INT16_MAX) / kCounts;
      const bool inside =
          counts[u] != DisparityImage::kInvalid && u_right >= 0 && u_right < right.cols;
      warped(v, u) = inside ? right(v, u_right) : uint8_t{0};
    }
  }
  return warped;
}

cv::Mat1i SumSquares(const cv::Mat1b& image) {
  cv::Mat1i sums;
  cv::sqrBoxFilter(image, sums, CV_32S, {kPhotoWindow, kPhotoWindow}, {-1, -1},
                   /*normalize=*/false);
  return sums;
}

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

// Distance to the next depth edge, px.
cv::Mat1f EdgeDistances(const DisparityImage& filled) {
  const cv::Mat1b window(3, 3, uint8_t{1});
  cv::Mat1s most, least, range;
  cv::dilate(filled.counts(), most, window);
  cv::erode(filled.counts(), least, window);
  cv::subtract(most, least, range);  // saturates
  cv::Mat1f distances;
  cv::distanceTransform(range <= DisparityImage::kCountsPerPixel, distances, cv::DIST_L2,
                        cv::DIST_MASK_3);
  return distances;
}

// Distance to the next seed, in spacings of as many seeds spread evenly.
cv::Mat1f SeedDistances(std::span<const Seed> seeds, cv::Size size) {
  cv::Mat1b no_seed(size, uint8_t{1});
  for (const Seed& seed : seeds) {
    const cv::Point position(cvRound(seed.u), cvRound(seed.v));
    if (cv::Rect({}, size).contains(position)) no_seed(position) = 0;
  }
  const int count = std::max(size.area() - cv::countNonZero(no_seed), 1);
  const float spacing_px = std::sqrt(static_cast<float>(size.area()) / static_cast<float>(count));
  cv::Mat1f distances;
  cv::distanceTransform(no_seed, distances, cv::DIST_L2, cv::DIST_MASK_3);
  for (float& distance : distances) distance /= spacing_px;
  return distances;
}

// Number of pixels in the window that growth left empty.
cv::Mat1i CountGaps(const DisparityImage& grown) {
  const cv::Mat gap = (grown.counts() == DisparityImage::kInvalid) / 255;
  cv::Mat1i gaps;
  cv::boxFilter(gap, gaps, CV_32S, {kGapWindow, kGapWindow}, {-1, -1}, /*normalize=*/false);
  return gaps;
}

}  // namespace

cv::Mat1b PlainConfidence(const cv::Mat1b& left, const cv::Mat1b& right,
                          std::span<const Seed> seeds, const DisparityImage& grown,
                          const DisparityImage& filled, double sigma_s_squared) {
  static const EdgePenalty edge_penalty;
  cv::Mat1f edge_px, seed_spacings;
  cv::Mat1i gaps, difference, energy;
  RunBoth(
      [&] {
        edge_px = EdgeDistances(filled);
        seed_spacings = SeedDistances(seeds, filled.size());
      },
      [&] {
        gaps = CountGaps(grown);
        const cv::Mat1b warped = Warp(right, filled);
        cv::Mat1b off;
        cv::absdiff(left, warped, off);
        difference = SumSquares(off);
        energy = SumSquares(left) + SumSquares(warped);
      });
  cv::Mat1b confidence(filled.size(), uint8_t{0});
  ForEachParallel(static_cast<size_t>(filled.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < filled.width(); ++u) {
      if (!filled.IsValid(u, v)) continue;
      const float exponent = HWY_NAMESPACE::PhotoCost(static_cast<float>(difference(v, u)),
                                                      static_cast<float>(std::max(energy(v, u), 1)),
                                                      static_cast<float>(1 / sigma_s_squared));
      const float photo =
          std::min(exponent * (kPhotoWeight / kLargestExponent), float{kPhotoWeight});
      const float hole = std::clamp(seed_spacings(v, u) - kUsualSpacings, 0.F, 1.F);
      const int penalty = edge_penalty.At(edge_px(v, u)) + static_cast<int>(kHoleWeight * hole) +
                          kGapWeight * gaps(v, u) / (kGapWindow * kGapWindow) +
                          static_cast<int>(photo);
      confidence(v, u) =
          static_cast<uint8_t>((255 * (kFullPenalty - penalty) + kFullPenalty / 2) / kFullPenalty);
    }
  });
  return confidence;
}

}  // namespace sprout::grow
