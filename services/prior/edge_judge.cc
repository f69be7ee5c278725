#include "services/prior/edge_judge.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>

#include "common/core/disparity_image.h"

namespace sprout {
namespace {

constexpr int kLargestGrey = 20;  // differences above are as bad as this
constexpr int kRadius = 1;        // of the window of differences, px
constexpr int kCensusRadius = 3;  // and of that of the census
constexpr int kWindow = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr int kCensusSide = 2 * kCensusRadius + 1;
constexpr int kCensusWindow = kCensusSide * kCensusSide;
constexpr int kUnlikeBits = 4;  // in which the codes of pixels that have nothing in common differ

// Counts to whole pixels.
int Rounded(int counts) {
  constexpr int kOne = DisparityImage::kCountsPerPixel;
  static_assert(kOne == 1 << 5);
  return (counts + kOne / 2) >> 5;
}

using CensusWindow = std::array<uint64_t, kCensusSide>;  // rows of codes

CensusWindow ReadCensus(const cv::Mat1b& codes, int u, int v) {
  CensusWindow window{};
  for (int y = 0; y < kCensusSide; ++y) {
    std::memcpy(&window[static_cast<size_t>(y)], codes[v - kCensusRadius + y] + u - kCensusRadius,
                kCensusSide);
  }
  return window;
}

// Adds three numbers of one bit in each of 64 places.
struct BitSum {
  BitSum(uint64_t a, uint64_t b, uint64_t c) : ones(a ^ b ^ c), twos((a & b) | (c & (a ^ b))) {}
  uint64_t ones;
  uint64_t twos;
};

// Bits in which windows differ. Adds the seven rows up place by place first: counting bits is slow.
int HammingDistance(const CensusWindow& a, const CensusWindow& b) {
  const auto row = [&](size_t y) { return a[y] ^ b[y]; };
  const BitSum upper(row(0), row(1), row(2));
  const BitSum lower(row(3), row(4), row(5));
  const BitSum all(upper.ones, lower.ones, row(6));
  const BitSum carried(upper.twos, lower.twos, all.twos);
  return std::popcount(all.ones) + 2 * std::popcount(carried.ones) +
         4 * std::popcount(carried.twos);
}

}  // namespace

bool EdgeJudge::IsNear(const EdgePixel& pixel, int edge) const {
  const int u = pixel.u;
  const int v = pixel.v;
  const int near_px = Rounded(pixel.near);
  const int far_px = Rounded(pixel.far);
  const bool inside = u >= kCensusRadius + near_px && u + kCensusRadius < columns() &&
                      v >= kCensusRadius && v + kCensusRadius < rows();
  const Costs costs = inside ? Inside(u, v, near_px, far_px) : AtBorder(u, v, near_px, far_px);
  const SeedVotes::Votes seeds =
      evidence_.seeds->Of(edge, {u, v}, evidence_.left_bgr(v, u), pixel.near, pixel.far);
  const EdgeWeights& weights = evidence_.weights;
  const double for_near = static_cast<double>(costs.differences) / (kWindow * kLargestGrey) +
                          weights.census * costs.census / (kCensusWindow * kUnlikeBits) +
                          weights.colour * seeds.colour + weights.proximity * seeds.proximity;
  return for_near > 0;
}

// All windows lie in their images.
EdgeJudge::Costs EdgeJudge::Inside(int u, int v, int near_px, int far_px) const {
  Costs costs;
  for (int y = v - kRadius; y <= v + kRadius; ++y) {
    const uint8_t* const left = evidence_.left_grey[y] + u;
    const uint8_t* const near = evidence_.right_grey[y] + u - near_px;
    const uint8_t* const far = evidence_.right_grey[y] + u - far_px;
    for (int x = -kRadius; x <= kRadius; ++x) {
      costs.differences += std::min(std::abs(left[x] - far[x]), kLargestGrey) -
                           std::min(std::abs(left[x] - near[x]), kLargestGrey);
    }
  }
  const CensusWindow left = ReadCensus(evidence_.left_census, u, v);
  costs.census = HammingDistance(left, ReadCensus(evidence_.right_census, u - far_px, v)) -
                 HammingDistance(left, ReadCensus(evidence_.right_census, u - near_px, v));
  return costs;
}

// Windows that reach over the border of the left image see its last pixels instead.
EdgeJudge::Costs EdgeJudge::AtBorder(int u, int v, int near_px, int far_px) const {
  Costs costs;
  for (int y = -kCensusRadius; y <= kCensusRadius; ++y) {
    for (int x = -kCensusRadius; x <= kCensusRadius; ++x) {
      const cv::Point left(std::clamp(u + x, 0, columns() - 1), std::clamp(v + y, 0, rows() - 1));
      costs.census += CensusDistance(left, far_px) - CensusDistance(left, near_px);
      if (std::max(std::abs(x), std::abs(y)) > kRadius) continue;
      costs.differences += Difference(left, far_px) - Difference(left, near_px);
    }
  }
  return costs;
}

// Truncated; a pixel that leaves the right image fits as badly as can be.
int EdgeJudge::Difference(cv::Point left, int disparity_px) const {
  const cv::Point right(left.x - disparity_px, left.y);
  if (right.x < 0) return kLargestGrey;
  return std::min(std::abs(evidence_.left_grey(left) - evidence_.right_grey(right)), kLargestGrey);
}

int EdgeJudge::CensusDistance(cv::Point left, int disparity_px) const {
  const cv::Point right(left.x - disparity_px, left.y);
  if (right.x < 0) return kUnlikeBits;
  return std::popcount(
      static_cast<uint8_t>(evidence_.left_census(left) ^ evidence_.right_census(right)));
}

}  // namespace sprout
