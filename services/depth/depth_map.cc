#include "services/depth/depth_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "common/core/prior_map.h"
#include "common/core/quantile.h"
#include "services/depth/rays.h"

namespace sprout::depth {
namespace {

// Counts of every disparity that a map can have: at 2 MP the division would be done 2 million times
// for 65536 results.
std::vector<uint16_t> DepthTable(const RectifiedPair& pair, double metres_per_count) {
  return TableOf<uint16_t>([&](double disparity_px) {
    const double counts = pair.DepthFromDisparity(disparity_px) / metres_per_count;
    const bool fits = counts > 0 && counts < std::numeric_limits<uint16_t>::max() + 0.5;
    return fits ? static_cast<uint16_t>(std::lround(counts)) : uint16_t{0};
  });
}

// Median of the depths in a block; 0 when less than half of its pixels have one.
uint16_t MedianOfBlock(const cv::Mat1w& counts, int u, int v, int scale) {
  std::array<uint16_t, 16> depths{};
  size_t found = 0;
  for (int y = v; y < v + scale; ++y) {
    for (int x = u; x < u + scale; ++x) {
      if (counts(y, x) > 0) depths[found++] = counts(y, x);
    }
  }
  if (2 * found < static_cast<size_t>(scale * scale)) return 0;
  return OrderStatistic(std::span(depths).first(found), (found - 1) / 2);
}

// Counts of σ_z for a count of σ_d, eq. (D1), at every disparity that a map can have.
std::vector<float> SigmaTable(const RectifiedPair& pair, double metres_per_count) {
  return TableOf<float>([&](double disparity_px) {
    const double sigma_m = pair.DepthSigma(disparity_px, 1.0 / kSigmaCountsPerPx);
    return static_cast<float>(std::min(sigma_m / metres_per_count, double{kMaxDepthSigmaCounts}));
  });
}

uint16_t SigmaCounts(float counts_per_count, uint8_t sigma) {
  const float counts = counts_per_count * static_cast<float>(sigma);
  if (sigma == kMaxSigmaCounts || !(counts < kMaxDepthSigmaCounts)) return kMaxDepthSigmaCounts;
  return static_cast<uint16_t>(std::max(1.0F, counts + 0.5F));  // rounds down
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

DepthImage DepthOf(const DisparityImage& disparity, const RectifiedPair& pair,
                   double metres_per_count, int scale) {
  assert(disparity.size() == pair.size() && scale >= 1 && scale <= 4);
  const std::vector<uint16_t> table = DepthTable(pair, metres_per_count);
  cv::Mat1w counts(disparity.size());
  for (int v = 0; v < counts.rows; ++v) {
    const int16_t* const disparities = disparity.counts()[v];
    uint16_t* const depths = counts[v];
    for (int u = 0; u < counts.cols; ++u) {
      depths[u] = table[IndexOf(disparities[u])];
    }
  }
  // The centre of block 0 is at (scale − 1) / 2 of the whole image.
  const double shift = (scale - 1) / 2.0;
  DepthImage depth{.counts = counts,
                   .metres_per_count = metres_per_count,
                   .focal_px = pair.focal_px / scale,
                   .cx = (pair.cx - shift) / scale,
                   .cy = (pair.cy - shift) / scale};
  if (scale == 1) return depth;
  depth.counts = cv::Mat1w(counts.rows / scale, counts.cols / scale);
  for (int v = 0; v < depth.counts.rows; ++v) {
    for (int u = 0; u < depth.counts.cols; ++u) {
      depth.counts(v, u) = MedianOfBlock(counts, scale * u, scale * v, scale);
    }
  }
  return depth;
}

int CountTooFar(const DisparityImage& disparity, const RectifiedPair& pair, double farthest_m) {
  const auto counts_at = [&](double depth_m) {
    return std::floor(pair.DisparityFromDepth(depth_m) * DisparityImage::kCountsPerPixel);
  };
  const double infinitely_far = std::max(counts_at(std::numeric_limits<double>::infinity()),
                                         double{DisparityImage::kInvalid});
  cv::Mat1b too_far;
  cv::inRange(disparity.counts(), infinitely_far + 1, counts_at(farthest_m), too_far);
  return cv::countNonZero(too_far);
}

DepthImage DepthSigmaOf(const DepthImage& depth, const DisparityImage& disparity,
                        const cv::Mat1b& sigma, const RectifiedPair& pair, int scale) {
  assert(disparity.size() == pair.size() && sigma.size() == pair.size());
  assert(depth.size() == cv::Size(pair.width / scale, pair.height / scale));
  DepthImage result = depth;
  result.metres_per_count = depth.metres_per_count / kSigmaCountsPerDepthCount;
  result.counts = cv::Mat1w(depth.size(), uint16_t{0});
  const std::vector<float> table = SigmaTable(pair, result.metres_per_count);
  for (int v = 0; v < depth.counts.rows; ++v) {
    const uint16_t* const depths = depth.counts[v];
    uint16_t* const sigmas = result.counts[v];
    const int16_t* const disparities = disparity.counts()[v];
    for (int u = 0; u < depth.counts.cols; ++u) {
      if (depths[u] == 0) continue;
      if (scale == 1) {
        sigmas[u] = SigmaCounts(table[IndexOf(disparities[u])], sigma(v, u));
        continue;
      }
      const cv::Point pixel = Chosen(disparity, sigma, scale * cv::Point(u, v), scale,
                                     pair.DisparityFromDepth(depth.Metres(u, v)));
      sigmas[u] = SigmaCounts(table[IndexOf(disparity.counts()(pixel))], sigma(pixel));
    }
  }
  return result;
}

}  // namespace sprout::depth
