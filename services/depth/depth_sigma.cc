#include "services/depth/depth_sigma.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "common/core/prior_map.h"

namespace sprout::depth {
namespace {

size_t IndexOf(int16_t counts) {
  return static_cast<size_t>(int{counts} - int{DisparityImage::kInvalid});
}

// Counts of σ_z for a count of σ_d, eq. (D1), at every disparity that a map can have.
std::vector<double> SigmaTable(const RectifiedPair& pair, double metres_per_count) {
  std::vector<double> table(1 << 16, 0);
  for (size_t i = 1; i < table.size(); ++i) {  // 0: DisparityImage::kInvalid
    const double disparity_px = (static_cast<double>(i) + double{DisparityImage::kInvalid}) /
                                DisparityImage::kCountsPerPixel;
    table[i] = pair.DepthSigma(disparity_px, 1.0 / kSigmaCountsPerPx) / metres_per_count;
  }
  return table;
}

uint16_t SigmaCounts(double counts_per_count, uint8_t sigma) {
  const double counts = counts_per_count * sigma;
  if (sigma == kMaxSigmaCounts || !(counts < kMaxDepthSigmaCounts)) return kMaxDepthSigmaCounts;
  return static_cast<uint16_t>(std::lround(std::max(1.0, counts)));
}

// The pixel of a block whose disparity is nearest to that of the block's depth.
cv::Point Chosen(const DisparityImage& disparity, const cv::Mat1b& sigma, cv::Point corner,
                 int scale, double disparity_px) {
  cv::Point chosen = corner;
  double least = std::numeric_limits<double>::infinity();
  for (int v = corner.y; v < corner.y + scale; ++v) {
    for (int u = corner.x; u < corner.x + scale; ++u) {
      if (!disparity.IsValid(u, v)) continue;
      const double distance = std::abs(double{disparity.Px(u, v)} - disparity_px);
      if (distance > least || (distance == least && sigma(v, u) <= sigma(chosen))) continue;
      least = distance;
      chosen = {u, v};
    }
  }
  return chosen;
}

}  // namespace

DepthImage DepthSigmaOf(const DepthImage& depth, const DisparityImage& disparity,
                        const cv::Mat1b& sigma, const RectifiedPair& pair, int scale) {
  assert(disparity.size() == pair.size() && sigma.size() == pair.size());
  assert(depth.size() == cv::Size(pair.width / scale, pair.height / scale));
  DepthImage result = depth;
  result.metres_per_count = depth.metres_per_count / kSigmaCountsPerDepthCount;
  result.counts = cv::Mat1w(depth.size(), uint16_t{0});
  const std::vector<double> table = SigmaTable(pair, result.metres_per_count);
  for (int v = 0; v < depth.counts.rows; ++v) {
    for (int u = 0; u < depth.counts.cols; ++u) {
      if (depth.counts(v, u) == 0) continue;
      cv::Point pixel(u, v);
      if (scale > 1) {
        pixel = Chosen(disparity, sigma, scale * pixel, scale,
                       pair.DisparityFromDepth(depth.Metres(u, v)));
      }
      result.counts(v, u) = SigmaCounts(table[IndexOf(disparity.counts()(pixel))], sigma(pixel));
    }
  }
  return result;
}

}  // namespace sprout::depth
