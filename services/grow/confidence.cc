#include "services/grow/confidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/core/parallel.h"

namespace sprout {
namespace {

// Shares of the confidence, in whole numbers, so that its bytes are the same on every machine.
constexpr int kOne = 1 << 16;
constexpr int kEdgeWeight = kOne * 45 / 100;
constexpr int kGapWeight = kOne * 15 / 100;
constexpr int kPhotoWeight = kOne * 15 / 100;
constexpr int kHoleWeight = kOne * 25 / 100;
constexpr double kEdgeRangePx = 8;
constexpr double kLargestExponent = 5;
constexpr int kGapWindow = 9;
constexpr float kUsualSpacings = 0.75;  // to the next seed
constexpr int kPhotoWindow = 5;

// The left image as the disparities make it from the right one; black where they leave it.
void Warp(const cv::Mat1b& right, const DisparityImage& map, cv::Mat1b& warped) {
  constexpr int kCounts = DisparityImage::kCountsPerPixel;
  warped.create(map.size());
  for (int v = 0; v < map.height(); ++v) {
    const int16_t* counts = map.counts()[v];
    for (int u = 0; u < map.width(); ++u) {
      const int u_right = u - (counts[u] + kCounts / 2) / kCounts;
      const bool inside =
          counts[u] != DisparityImage::kInvalid && u_right >= 0 && u_right < right.cols;
      warped(v, u) = inside ? right(v, u_right) : uint8_t{0};
    }
  }
}

void SumSquares(const cv::Mat1b& image, cv::Mat1i& sums) {
  cv::sqrBoxFilter(image, sums, CV_32S, {kPhotoWindow, kPhotoWindow}, {-1, -1},
                   /*normalize=*/false);
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

}  // namespace

cv::Mat1b Confidence(const cv::Mat1b& left, const cv::Mat1b& right, std::span<const Seed> seeds,
                     const DisparityImage& grown, const DisparityImage& filled,
                     double sigma_s_squared) {
  return ConfidenceJudge().Judge(left, right, seeds, grown, filled, sigma_s_squared);
}

void ConfidenceJudge::MeasureEdges(const DisparityImage& filled) {
  static const cv::Mat1b window(3, 3, uint8_t{1});
  cv::dilate(filled.counts(), most_, window);
  cv::erode(filled.counts(), least_, window);
  cv::subtract(most_, least_, range_);  // saturates
  cv::compare(range_, DisparityImage::kCountsPerPixel, even_, cv::CMP_LE);
  cv::distanceTransform(even_, edge_px_, cv::DIST_L2, cv::DIST_MASK_3);
}

void ConfidenceJudge::MeasureHoles(std::span<const Seed> seeds, cv::Size size) {
  no_seed_.create(size);
  no_seed_ = 1;
  for (const Seed& seed : seeds) {
    const cv::Point position(cvRound(seed.u), cvRound(seed.v));
    if (cv::Rect({}, size).contains(position)) no_seed_(position) = 0;
  }
  const int count = size.area() - cv::countNonZero(no_seed_);
  spacing_px_ = std::sqrt(static_cast<float>(size.area()) / static_cast<float>(std::max(count, 1)));
  cv::distanceTransform(no_seed_, seed_px_, cv::DIST_L2, cv::DIST_MASK_3);
}

void ConfidenceJudge::CountGaps(const DisparityImage& grown) {
  cv::compare(grown.counts(), DisparityImage::kInvalid, gap_, cv::CMP_EQ);
  cv::min(gap_, 1, gap_);
  cv::boxFilter(gap_, gaps_, CV_32S, {kGapWindow, kGapWindow}, {-1, -1}, /*normalize=*/false);
}

void ConfidenceJudge::Compare(const cv::Mat1b& left, const cv::Mat1b& right,
                              const DisparityImage& filled) {
  Warp(right, filled, warped_);
  cv::absdiff(left, warped_, off_);
  SumSquares(off_, difference_);
  SumSquares(left, energy_);
  SumSquares(warped_, warped_energy_);
  cv::add(energy_, warped_energy_, energy_);
}

cv::Mat1b ConfidenceJudge::Judge(const cv::Mat1b& left, const cv::Mat1b& right,
                                 std::span<const Seed> seeds, const DisparityImage& grown,
                                 const DisparityImage& filled, double sigma_s_squared) {
  static const EdgePenalty edge_penalty;
  RunBoth(
      [&] {
        MeasureEdges(filled);
        MeasureHoles(seeds, filled.size());
      },
      [&] {
        CountGaps(grown);
        Compare(left, right, filled);
      });
  Renew(result_, filled.size());
  ForEachParallel(static_cast<size_t>(filled.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < filled.width(); ++u) {
      if (!filled.IsValid(u, v)) {
        result_(v, u) = 0;
        continue;
      }
      const double energy = sigma_s_squared * std::max(energy_(v, u), 1);
      const double misfit = difference_(v, u) / energy / kLargestExponent;  // Eq. (4)
      const float hole = seed_px_(v, u) / spacing_px_ - kUsualSpacings;
      const int penalty = edge_penalty.At(edge_px_(v, u)) +
                          static_cast<int>(kHoleWeight * std::clamp(hole, 0.F, 1.F)) +
                          kGapWeight * gaps_(v, u) / (kGapWindow * kGapWindow) +
                          static_cast<int>(kPhotoWeight * std::min(misfit, 1.0));
      result_(v, u) = static_cast<uint8_t>((255 * (kOne - penalty) + kOne / 2) / kOne);
    }
  });
  return result_;
}

void DropUnsure(const cv::Mat1b& confidence, int least, DisparityImage& disparity) {
  if (least == 0) return;
  disparity = DisparityImage(cv::Mat1s(disparity.counts().clone()));  // others may hold the pixels
  disparity.counts().setTo(DisparityImage::kInvalid, confidence < least);
}

}  // namespace sprout
