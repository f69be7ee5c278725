// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"
#include "services/refine/stereo/stereo_search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/refine/stereo/match_costs.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "services/refine/stereo/byte_lanes-inl.h"

#ifndef SPROUT_SERVICES_REFINE_MATCH_COSTS_SHARED_
#define SPROUT_SERVICES_REFINE_MATCH_COSTS_SHARED_
namespace sprout::refine {
namespace {

constexpr int kRadius = StereoRules::kCensusRadius;
constexpr int kWindow = 2 * kRadius + 1;
constexpr int kSpare = 16;                          // columns behind a row, for whole vectors
constexpr size_t kSlopes = StereoRules::kBits / 8;  // index of the plane behind those of bits
constexpr size_t kPlanes = kSlopes + 1;

// A row of the search.
struct CostRow {
  const int16_t* first;
  const int16_t* known;
  int labels;
  cv::Range columns;
  const uint8_t* left[kPlanes];
  const uint8_t* right[kPlanes];  // may be read before its begin
  uint8_t* costs;
};

}  // namespace
}  // namespace sprout::refine
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

// The slopes of grey along the row, Sobel's sum, in half levels a px (a quarter of the sum,
// rounded) from −128 to 127, plus 128.
// @param u  the column of the first window's left border in its rows.
HWY_INLINE Bytes SlopesOf(const uint8_t* const (&rows)[kWindow], int u) {
  static_assert(kRadius == 2);
  Bytes slopes[2][3];  // the columns on the left and on the right
  for (int y = 0; y < 3; ++y) {
    slopes[0][y] = Load(rows[y + 1] + u + 1);
    slopes[1][y] = Load(rows[y + 1] + u + 3);
  }
  const auto sum = [&](const Bytes(&column)[3], auto widened) HWY_ATTR {
    const Words middle = widened(column[1]);
    return widened(column[0]) + middle + middle + widened(column[2]);
  };
  const auto half = [&](auto widened) HWY_ATTR {
    const Words right = sum(slopes[1], widened) + uint16_t{4 * 128 + 2};
    const Words left = sum(slopes[0], widened);
    const Words quarter = (right > left ? right - left : Words{}) >> 2;
    return Least(quarter, Words{} + uint16_t{UINT8_MAX});
  };
  return Narrowed(half([](Bytes x) HWY_ATTR { return Widened<0>(x); }),
                  half([](Bytes x) HWY_ATTR { return Widened<1>(x); }));
}

// The census bits of the 5×5 windows (whether a pixel is darker than the centre), and the slopes.
// @param rows   the windows', from the first column of the first window on.
// @param count  of pixels; up to 15 more are written.
void DescribeOnTarget(const uint8_t* const (&rows)[kWindow], int count,
                      uint8_t* const (&planes)[kPlanes]) {
  for (int u = 0; u < count; u += kLanes) {
    const Bytes centre = Load(rows[kRadius] + u + kRadius);
    Bytes bits[kSlopes] = {};
    HWY_UNROLL(25)
    for (int i = 0; i < kWindow * kWindow; ++i) {
      if (i == kWindow * kWindow / 2) continue;
      const auto is_darker =
          Load(rows[i / kWindow] + u + i % kWindow) < centre;  // all bits or none
      Bytes& plane = bits[(i - (i > kWindow * kWindow / 2)) / 8];
      plane = plane + plane - reinterpret_cast<Bytes>(is_darker);
    }
    for (size_t k = 0; k < kSlopes; ++k) Store(bits[k], planes[k] + u);
    Store(SlopesOf(rows, u), planes[kSlopes] + u);
  }
}

// Number of ones in every lane, by adding neighbouring fields.
HWY_INLINE Bytes CountOnes(Bytes bits) {
  bits -= bits >> 1 & uint8_t{0x55};
  bits = (bits & uint8_t{0x33}) + (bits >> 2 & uint8_t{0x33});
  return (bits + (bits >> 4)) & uint8_t{0x0f};
}

HWY_INLINE Bytes Reversed(Bytes x) {
  return Shuffled<15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0>(x);
}

void CostsOnTarget(const CostRow& row) {
  static_assert(kSlopes == 3);
  constexpr uint8_t kMaxOff = StereoRules::kMaxSlope / StereoRules::kPerSlope;
  uint8_t* costs = row.costs;
  for (int u = row.columns.start; u < row.columns.end; ++u, costs += row.labels) {
    const int first = row.first[u];
    if (first == StereoSearch::kNowhere) continue;
    for (int i = 0; i < row.labels; i += kLanes) {
      const int last_match = u - first - i - kLanes + 1;  // of these labels, in front of the others
      const auto differing = [&](size_t k) HWY_ATTR {
        return (Bytes{} + row.left[k][u]) ^ Load(row.right[k] + last_match);
      };
      const Bytes slope = Bytes{} + row.left[kSlopes][u];
      const Bytes of_match = Load(row.right[kSlopes] + last_match);
      const Bytes off = slope > of_match ? slope - of_match : of_match - slope;
      const Bytes a = differing(0);
      const Bytes b = differing(1);
      const Bytes c = differing(2);
      // Three bits are a sum and a carry.
      const Bytes carry = (a & b) | ((a ^ b) & c);
      const Bytes carries = CountOnes(carry);
      const Bytes bits = CountOnes(a ^ b ^ c) + carries + carries;
      Store(Reversed(bits + Least(off, Bytes{} + kMaxOff) * uint8_t{StereoRules::kPerSlope}),
            costs + i);
    }
    const int inside = std::clamp(u - first + 1, 0, row.labels);
    for (int i = inside; i < row.labels; ++i) costs[i] = uint8_t{StereoRules::kOutside};
    const int known = row.known[u];
    if (known == StereoSearch::kNowhere) continue;
    for (int i = 0; i < row.labels; ++i) {
      const int off =
          std::min(StereoRules::kMaxKnown, StereoRules::kKnownPerPx * std::abs(first + i - known));
      costs[i] = static_cast<uint8_t>(costs[i] + off);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::refine {
namespace {

HWY_EXPORT(DescribeOnTarget);
HWY_EXPORT(CostsOnTarget);

void AddBorder(const cv::Mat1b& image, cv::Mat1b& bordered) {
  cv::copyMakeBorder(image, bordered, kRadius, kRadius, kRadius, kRadius + kSpare,
                     cv::BORDER_REPLICATE);
}

// @param before  columns of the planes in front of the image's first.
template <typename Planes>
void Describe(const cv::Mat1b& bordered, int v, const cv::Range& columns, int before,
              Planes& planes) {
  const uint8_t* rows[kWindow];
  for (int y = 0; y < kWindow; ++y) rows[y] = bordered[v + y] + columns.start;
  uint8_t* to[kPlanes];
  for (size_t k = 0; k < kPlanes; ++k) to[k] = planes[k][v] + before + columns.start;
  HWY_DYNAMIC_DISPATCH(DescribeOnTarget)(rows, columns.size(), to);
}

}  // namespace

const std::vector<uint8_t>& MatchCosts::Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                                const StereoSearch& search,
                                                const SearchRows& rows) {
  double largest_first = 0;
  cv::minMaxLoc(search.first, nullptr, &largest_first);
  const int most = static_cast<int>(largest_first) + search.labels;
  AddBorder(left, left_bordered_);
  AddBorder(right, right_bordered_);
  for (cv::Mat1b& plane : left_) plane.create(left.rows, left.cols + kSpare);
  // Matches outside the image are in front of it, undefined.
  for (cv::Mat1b& plane : right_) plane.create(left.rows, most + left.cols + kSpare);
  // Never shorter than for the largest image so far, so that nothing is cleared from level to
  // level.
  costs_.resize(std::max(costs_.size(), rows.pixels() * static_cast<size_t>(search.labels)));
  ForRangesParallel(left.rows, left.rows, [&](const cv::Range& range) {
    for (int v = range.start; v < range.end; ++v) {
      const cv::Range& columns = rows.columns(v);
      if (columns.empty()) continue;
      Describe(left_bordered_, v, columns, 0, left_);
      Describe(right_bordered_, v, {std::max(0, columns.start - most), columns.end}, most, right_);
      const auto of_image = [&](size_t k) { return right_[k][v] + most; };
      const size_t begin = rows.IndexOf(v, columns.start) * static_cast<size_t>(search.labels);
      HWY_DYNAMIC_DISPATCH(CostsOnTarget)
      ({.first = search.first[v],
        .known = search.known[v],
        .labels = search.labels,
        .columns = columns,
        .left = {left_[0][v], left_[1][v], left_[2][v], left_[3][v]},
        .right = {of_image(0), of_image(1), of_image(2), of_image(3)},
        .costs = costs_.data() + begin});
    }
  });
  return costs_;
}

}  // namespace sprout::refine
#endif  // HWY_ONCE
