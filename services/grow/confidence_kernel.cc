// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/grow/confidence_kernel.h"

#include <algorithm>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/confidence_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "services/grow/similarity-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Distances, and sums over windows.
using D = hn::CappedTag<int32_t, 16>;
using V = hn::Vec<D>;
inline constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

using D16 = hn::Rebind<int16_t, D>;
using D8 = hn::Rebind<uint8_t, D>;

// Entries on either side of a row that may be read: a window and a run of lanes.
inline constexpr int kBeside = 32;

// Steps of a distance beside and across, 2⁻¹⁶ px: those of OpenCV's 3×3 mask.
inline constexpr int32_t kBesideStep = 62587;
inline constexpr int32_t kAcrossStep = 89738;
inline constexpr int32_t kFar = 1 << 29;

// Distances along a row: each the least of its own and of one step more than its neighbour's, from
// left to right (kDown) or from right to left.
template <bool kDown>
class AlongRow {
 public:
  AlongRow() {
    for (int i = 0; i < kSteps; ++i) {
      for (int lane = 0; lane < kLanes; ++lane) {
        const int from = kDown ? lane - (1 << i) : lane + (1 << i);
        const bool is_lane = from >= 0 && from < kLanes;
        from_[i][lane] = is_lane ? from : lane;
        costs_[i][lane] = is_lane ? kBesideStep << i : kFar;
      }
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      ramp_[lane] = kBesideStep * (kDown ? lane + 1 : kLanes - lane);
      last_[lane] = kDown ? kLanes - 1 : 0;
    }
  }

  // @param carry  distance of the pixel before the first one, in all lanes; becomes the last one's.
  HWY_INLINE V Run(V distances, V& carry) const {
    const D d;
    HWY_UNROLL(4)
    for (int i = 0; i < kSteps; ++i) {
      const V moved = hn::TableLookupLanes(distances, hn::SetTableIndices(d, from_[i]));
      distances = hn::Min(distances, hn::Add(moved, hn::Load(d, costs_[i])));
    }
    distances = hn::Min(distances, hn::Add(carry, hn::Load(d, ramp_)));
    carry = hn::TableLookupLanes(distances, hn::SetTableIndices(d, last_));
    return distances;
  }

 private:
  static constexpr int kSteps = std::bit_width(static_cast<unsigned>(kLanes)) - 1;
  static constexpr int kAtLeastOne = std::max(kSteps, 1);
  HWY_ALIGN int32_t from_[kAtLeastOne][kLanes];
  HWY_ALIGN int32_t costs_[kAtLeastOne][kLanes];
  HWY_ALIGN int32_t ramp_[kLanes];
  HWY_ALIGN int32_t last_[kLanes];
};

// Two passes over an image as cv::distanceTransform makes them. That from the top is made twice: of
// the first time every 32nd row is kept, from which the rows between are made anew while the pass
// from the bottom needs them. So all of it stays in the cache.
class Distances {
 public:
  // @param start(v, row)  writes row v of the image: 0 where distances start, kFar elsewhere, also
  // for the lanes behind its end. @param finish(v, u, distances)  gets the lanes from u on.
  template <typename Start, typename Finish>
  static void Run(cv::Size size, DistanceMemory& memory, const Start& start, const Finish& finish) {
    Distances distances(size, memory);
    const int bands = (size.height + kBand - 1) / kBand;
    for (int v = 0; v < (bands - 1) * kBand; ++v) {
      distances.PassDown(
          v, v % kBand == 0 ? distances.KeptRow(v / kBand - 1) : distances.Row(v - 1),
          v % kBand == kBand - 1 ? distances.KeptRow(v / kBand) : distances.Row(v), start);
    }
    for (int band = bands; band-- > 0;) {
      const int first = band * kBand;
      const int end = std::min(first + kBand, size.height);
      for (int v = first; v < end; ++v) {
        distances.PassDown(v, v == first ? distances.KeptRow(band - 1) : distances.Row(v - 1),
                           distances.Row(v), start);
      }
      for (int v = end; v-- > first;) distances.PassUp(v, finish);
    }
  }

 private:
  static constexpr int kBand = 32;

  Distances(cv::Size size, DistanceMemory& memory)
      : width_(size.width),
        row_size_(static_cast<size_t>(kBeside + size.width + kBeside)),
        memory_(memory) {
    const auto bands = static_cast<size_t>((size.height + kBand - 1) / kBand);
    memory.kept_rows.assign((bands + 1) * row_size_, kFar);
    memory.rows.assign((kBand + 2) * row_size_, kFar);
  }

  // The last one of a band; −1: above the image, where all is far away.
  int32_t* KeptRow(int band) {
    return memory_.kept_rows.data() + static_cast<size_t>(band + 1) * row_size_ + kBeside;
  }
  int32_t* Row(int v) {
    return memory_.rows.data() + static_cast<size_t>(v % kBand) * row_size_ + kBeside;
  }
  // Of the pass from the bottom.
  int32_t* RowUp(int v) {
    return memory_.rows.data() + static_cast<size_t>(kBand + v % 2) * row_size_ + kBeside;
  }

  static HWY_INLINE V FromRow(const int32_t* row, int u) {
    const D d;
    const V across = hn::Min(hn::LoadU(d, row + u - 1), hn::LoadU(d, row + u + 1));
    return hn::Min(hn::Add(hn::LoadU(d, row + u), hn::Set(d, kBesideStep)),
                   hn::Add(across, hn::Set(d, kAcrossStep)));
  }

  template <typename Start>
  void PassDown(int v, const int32_t* above, int32_t* row, const Start& start) {
    const D d;
    start(v, row);
    V carry = hn::Set(d, kFar);
    for (int u = 0; u < width_; u += kLanes) {
      const V least = hn::Min(hn::LoadU(d, row + u), FromRow(above, u));
      hn::StoreU(right_.Run(least, carry), d, row + u);
    }
  }

  template <typename Finish>
  void PassUp(int v, const Finish& finish) {
    const D d;
    const int32_t* const down = Row(v);
    const int32_t* const below = RowUp(v + 1);  // far away at first
    int32_t* const row = RowUp(v);
    V carry = hn::Set(d, kFar);
    for (int u = (width_ - 1) / kLanes * kLanes; u >= 0; u -= kLanes) {
      const V least = hn::Min(hn::LoadU(d, down + u), FromRow(below, u));
      const V distances = left_.Run(least, carry);
      hn::StoreU(distances, d, row + u);
      finish(v, u, distances);
    }
  }

  const int width_;
  const size_t row_size_;
  DistanceMemory& memory_;
  const AlongRow<true> right_;
  const AlongRow<false> left_;
};

// Stores what of `values` lies in the image, as 16 or 8 bits.
template <class DNarrow, typename T>
HWY_INLINE void StoreInside(DNarrow d, V values, int u, int width, T* row) {
  if (u + kLanes <= width) {
    hn::StoreU(hn::DemoteTo(d, values), d, row + u);
  } else {
    T run[kLanes];
    hn::StoreU(hn::DemoteTo(d, values), d, run);
    std::copy_n(run, width - u, row + u);
  }
}

// Where the disparities of 3×3 pixels differ by more than one.
class EdgeStart {
 public:
  explicit EdgeStart(const DisparityImage& filled)
      : filled_(filled), most_(RowSize()), least_(RowSize()) {}

  void operator()(int v, int32_t* row) {
    const D d;
    const D16 d16;
    const int width = filled_.width();
    const int16_t* const above = filled_.counts()[std::max(v - 1, 0)];
    const int16_t* const here = filled_.counts()[v];
    const int16_t* const below = filled_.counts()[std::min(v + 1, filled_.height() - 1)];
    int16_t* const most = most_.data() + kBeside;
    int16_t* const least = least_.data() + kBeside;
    for (int u = 0; u < width; ++u) {  // the compiler makes vectors of it
      most[u] = std::max({above[u], here[u], below[u]});
      least[u] = std::min({above[u], here[u], below[u]});
    }
    most[-1] = most[0], most[width] = most[width - 1];
    least[-1] = least[0], least[width] = least[width - 1];
    for (int u = 0; u < width; u += kLanes) {
      const auto of_three = [&](const int16_t* values, auto choose) HWY_ATTR {
        return choose(hn::LoadU(d16, values + u),
                      choose(hn::LoadU(d16, values + u - 1), hn::LoadU(d16, values + u + 1)));
      };
      const auto range =
          hn::SaturatedSub(of_three(most, [](auto a, auto b) HWY_ATTR { return hn::Max(a, b); }),
                           of_three(least, [](auto a, auto b) HWY_ATTR { return hn::Min(a, b); }));
      const auto edge =
          hn::And(hn::Gt(hn::PromoteTo(d, range), hn::Set(d, DisparityImage::kCountsPerPixel)),
                  hn::Lt(hn::Iota(d, u), hn::Set(d, width)));
      hn::StoreU(hn::IfThenZeroElse(edge, hn::Set(d, kFar)), d, row + u);
    }
  }

 private:
  size_t RowSize() const { return static_cast<size_t>(kBeside + filled_.width() + kBeside); }

  const DisparityImage& filled_;
  std::vector<int16_t> most_, least_;  // of three pixels one above the other
};

void PenaliseEdgesOnTarget(const DisparityImage& filled, const EdgePenalties& by_distance,
                           DistanceMemory& memory, cv::Mat1w& penalties) {
  const D d;
  const hn::Rebind<uint16_t, D> d_unsigned;
  const int width = filled.width();
  EdgeStart start(filled);
  Distances::Run(
      filled.size(), memory, [&](int v, int32_t* row) HWY_ATTR { start(v, row); },
      [&](int v, int u, V distances) HWY_ATTR {
        // In quarters of a pixel, rounded.
        const V quarters = hn::ShiftRight<14>(hn::Add(distances, hn::Set(d, 1 << 13)));
        const V beyond = hn::Set(d, static_cast<int32_t>(by_distance.size()) - 1);
        const V found = hn::GatherIndex(d, by_distance.data(), hn::Min(quarters, beyond));
        StoreInside(d_unsigned, found, u, width, penalties[v]);
      });
}

void PenaliseHolesOnTarget(const cv::Mat1b& no_seed, float spacing_px, DistanceMemory& memory,
                           cv::Mat1w& penalties) {
  const D d;
  const hn::RebindToFloat<D> df;
  const hn::Rebind<uint16_t, D> d_unsigned;
  const int width = no_seed.cols;
  Distances::Run(
      no_seed.size(), memory,
      [&](int v, int32_t* row) {
        const uint8_t* const seeds = no_seed[v];
        for (int u = 0; u < width; ++u) row[u] = seeds[u] != 0 ? kFar : 0;
        std::fill_n(row + width, kBeside, kFar);
      },
      [&](int v, int u, V distances) HWY_ATTR {
        constexpr float kUnit = 1.0F / (1 << 16);
        const auto px = hn::Mul(hn::ConvertTo(df, distances), hn::Set(df, kUnit));
        const auto spacings = hn::Div(px, hn::Set(df, spacing_px));
        const auto hole = hn::Min(
            hn::Max(hn::Sub(spacings, hn::Set(df, kUsualSpacings)), hn::Zero(df)), hn::Set(df, 1));
        const V penalty = hn::ConvertTo(d, hn::Mul(hn::Set(df, kHoleWeight), hole));
        StoreInside(d_unsigned, penalty, u, width, penalties[v]);
      });
}

// Where a window looks for what lies beyond an image: mirrored, as OpenCV's box filters do.
inline int Mirrored(int at, int size) {
  return cv::borderInterpolate(at, size, cv::BORDER_REFLECT_101);
}

// The windows of a band's rows, one row after the other: sums over columns move down a pixel at a
// time.
class WindowSums {
 public:
  WindowSums(const ConfidenceInput& input, int first_row)
      : input_(input),
        width_(input.left.cols),
        height_(input.left.rows),
        left_(RowSize()),
        warped_(RowSize()),
        right_(2 * kReach + RowSize()),
        counts_(RowSize(), DisparityImage::kInvalid),
        energies_(kPhotoWindow * RowSize()),
        differences_(kPhotoWindow * RowSize()),
        energy_(RowSize()),
        difference_(RowSize()),
        gaps_(RowSize()) {
    for (int v = first_row - kPhotoRadius; v < first_row + kPhotoRadius; ++v) AddPhoto(v);
    for (int v = first_row - kGapRadius; v < first_row + kGapRadius; ++v) AddGaps(v, 1);
  }

  // To the windows of row v; called for one row after the other.
  void MoveTo(int v) {
    AddPhoto(v + kPhotoRadius);
    AddGaps(v + kGapRadius, 1);
    MirrorEnds(energy_, kPhotoRadius);
    MirrorEnds(difference_, kPhotoRadius);
    MirrorEnds(gaps_, kGapRadius);
  }
  void LeaveRow(int v) { AddGaps(v - kGapRadius, -1); }

  // Σ (wL² + wR²), Σ (wL − wR)² and gaps over the windows of the pixels from u on.
  HWY_INLINE V Energy(int u) const { return SumOfFive(energy_.data() + kBeside + u); }
  HWY_INLINE V Difference(int u) const { return SumOfFive(difference_.data() + kBeside + u); }
  HWY_INLINE V Gaps(int u) const {
    const D8 d;
    auto sum = hn::LoadU(d, gaps_.data() + kBeside + u - kGapRadius);
    HWY_UNROLL(8)
    for (int i = 1; i < kGapWindow; ++i) {
      sum = hn::Add(sum, hn::LoadU(d, gaps_.data() + kBeside + u - kGapRadius + i));
    }
    return hn::PromoteTo(D(), sum);
  }

 private:
  static constexpr int kPhotoRadius = kPhotoWindow / 2;
  static constexpr int kGapRadius = kGapWindow / 2;
  static constexpr int kReach = 1024 + kBeside;  // as far as a disparity leads, and a run of lanes

  size_t RowSize() const { return static_cast<size_t>(kBeside + width_ + kBeside); }

  static HWY_INLINE V SumOfFive(const int32_t* middle) {
    const D d;
    const V outer = hn::Add(hn::LoadU(d, middle - 2), hn::LoadU(d, middle + 2));
    const V inner = hn::Add(hn::LoadU(d, middle - 1), hn::LoadU(d, middle + 1));
    return hn::Add(hn::Add(outer, inner), hn::LoadU(d, middle));
  }

  // A row with its photo terms takes the place of that five rows above.
  void AddPhoto(int v) {
    const D d;
    const D8 d8;
    const int row = Mirrored(v, height_);
    Warp(row);
    std::copy_n(input_.left[row], width_, left_.data());
    const size_t place = static_cast<size_t>((v + kPhotoWindow) % kPhotoWindow) * RowSize();
    int32_t* const energies = energies_.data() + place;
    int32_t* const differences = differences_.data() + place;
    for (int u = 0; u < width_; u += kLanes) {
      const auto replace = [&](V value, int32_t* values, int32_t* sums) HWY_ATTR {
        const V change = hn::Sub(value, hn::LoadU(d, values + u));
        hn::StoreU(value, d, values + u);
        hn::StoreU(hn::Add(hn::LoadU(d, sums + u), change), d, sums + u);
      };
      const V left = hn::PromoteTo(d, hn::LoadU(d8, left_.data() + u));
      const V warped = hn::PromoteTo(d, hn::LoadU(d8, warped_.data() + u));
      const V off = hn::Sub(left, warped);
      replace(hn::Add(hn::Mul(left, left), hn::Mul(warped, warped)), energies,
              energy_.data() + kBeside);
      replace(hn::Mul(off, off), differences, difference_.data() + kBeside);
    }
  }

  // The left image's row as the disparities make it from the right one; black where they leave it.
  void Warp(int v) {
    using DWide = hn::CappedTag<int16_t, 32>;
    constexpr int kWide = static_cast<int>(hn::MaxLanes(DWide()));
    const DWide d;
    const hn::Rebind<uint8_t, DWide> d8;
    std::copy_n(input_.right[v], width_, right_.data() + kReach);
    std::copy_n(input_.filled.counts()[v], width_, counts_.data());
    for (int u = 0; u < width_; u += kWide) {
      const auto counts = hn::LoadU(d, counts_.data() + u);
      // Rounded to whole pixels; half a pixel below zero and less towards zero.
      constexpr int kHalf = DisparityImage::kCountsPerPixel / 2;
      static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
      const auto negative = hn::VecFromMask(d, hn::Lt(counts, hn::Set(d, -kHalf)));
      const auto more = hn::Add(hn::And(negative, hn::Set(d, 31)), hn::Set(d, kHalf));
      const auto whole = hn::ShiftRight<5>(hn::SaturatedAdd(counts, more));
      int16_t disparities[kWide];
      hn::StoreU(whole, d, disparities);
      auto rest = hn::Ne(counts, hn::Set(d, DisparityImage::kInvalid));
      auto values = hn::Zero(d);
      for (intptr_t lane = hn::FindFirstTrue(d, rest); lane >= 0;
           lane = hn::FindFirstTrue(d, rest)) {
        const auto mask = hn::And(rest, hn::Eq(whole, hn::Set(d, disparities[lane])));
        const auto right =
            hn::PromoteTo(d, hn::LoadU(d8, right_.data() + kReach + u - disparities[lane]));
        values = hn::IfThenElse(mask, right, values);
        rest = hn::AndNot(mask, rest);
      }
      hn::StoreU(hn::DemoteTo(d8, values), d8, warped_.data() + u);
    }
  }

  // The compiler makes vectors of it.
  void AddGaps(int v, int sign) {
    const int16_t* const grown = input_.grown.counts()[Mirrored(v, height_)];
    uint8_t* const gaps = gaps_.data() + kBeside;
    const auto one = static_cast<uint8_t>(sign);
    for (int u = 0; u < width_; ++u) {
      gaps[u] = static_cast<uint8_t>(gaps[u] + (grown[u] == DisparityImage::kInvalid ? one : 0));
    }
  }

  template <typename T>
  void MirrorEnds(std::vector<T>& row, int radius) const {
    T* const first = row.data() + kBeside;
    for (int i = 1; i <= radius; ++i) {
      first[-i] = first[Mirrored(-i, width_)];
      first[width_ - 1 + i] = first[Mirrored(width_ - 1 + i, width_)];
    }
  }

  const ConfidenceInput& input_;
  const int width_, height_;
  std::vector<uint8_t> left_, warped_;  // rows
  std::vector<uint8_t> right_;          // with kReach black pixels on either side
  std::vector<int16_t> counts_;
  std::vector<int32_t> energies_, differences_;  // of the rows of a window
  std::vector<int32_t> energy_, difference_;     // sums over columns of a window
  std::vector<uint8_t> gaps_;
};

void RateRowsOnTarget(const ConfidenceInput& input, const cv::Range& rows, cv::Mat1b& confidence) {
  const D d;
  const hn::RebindToFloat<D> df;
  const D8 d8;
  const D16 d16;
  const hn::Rebind<uint16_t, D> d_unsigned;
  const int width = input.left.cols;
  WindowSums sums(input, rows.start);
  const auto row_size = static_cast<size_t>(width + kLanes);
  std::vector<int16_t> counts(row_size, DisparityImage::kInvalid);
  std::vector<uint16_t> edges(row_size), holes(row_size);
  for (int v = rows.start; v < rows.end; ++v) {
    sums.MoveTo(v);
    std::copy_n(input.filled.counts()[v], width, counts.data());
    std::copy_n(input.edge_penalties[v], width, edges.data());
    std::copy_n(input.hole_penalties[v], width, holes.data());
    for (int u = 0; u < width; u += kLanes) {
      const auto energy = hn::ConvertTo(df, hn::Max(sums.Energy(u), hn::Set(d, 1)));
      const auto difference = hn::ConvertTo(df, sums.Difference(u));
      const auto exponent = PhotoCost(difference, energy, hn::Set(df, input.photo_scale));
      static_assert(kPhotoWeight % kLargestExponent == 0);
      const auto photo = hn::Min(hn::Mul(exponent, hn::Set(df, kPhotoWeight / kLargestExponent)),
                                 hn::Set(df, kPhotoWeight));
      // kGapWeight · gaps / 81, rounded down.
      const V gaps = hn::ShiftRight<16>(hn::Mul(sums.Gaps(u), hn::Set(d, kGapFactor)));
      const V edge = hn::PromoteTo(d, hn::LoadU(d_unsigned, edges.data() + u));
      const V hole = hn::PromoteTo(d, hn::LoadU(d_unsigned, holes.data() + u));
      const V penalty = hn::Add(hn::Add(edge, hole), hn::Add(gaps, hn::ConvertTo(d, photo)));
      const V share = hn::Sub(hn::Set(d, kFullPenalty), penalty);
      const V scaled = hn::Add(hn::Mul(share, hn::Set(d, 255)), hn::Set(d, kFullPenalty / 2));
      static_assert(kFullPenalty == 1 << 16);
      const V here = hn::PromoteTo(d, hn::LoadU(d16, counts.data() + u));
      const auto empty = hn::Eq(here, hn::Set(d, DisparityImage::kInvalid));
      StoreInside(d8, hn::IfThenZeroElse(empty, hn::ShiftRight<16>(scaled)), u, width,
                  confidence[v]);
    }
    sums.LeaveRow(v);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::grow {

HWY_EXPORT(PenaliseEdgesOnTarget);
HWY_EXPORT(PenaliseHolesOnTarget);
HWY_EXPORT(RateRowsOnTarget);

void PenaliseEdges(const DisparityImage& filled, const EdgePenalties& by_distance,
                   DistanceMemory& memory, cv::Mat1w& penalties) {
  penalties.create(filled.size());
  HWY_DYNAMIC_DISPATCH(PenaliseEdgesOnTarget)(filled, by_distance, memory, penalties);
}

void PenaliseHoles(const cv::Mat1b& no_seed, float spacing_px, DistanceMemory& memory,
                   cv::Mat1w& penalties) {
  penalties.create(no_seed.size());
  HWY_DYNAMIC_DISPATCH(PenaliseHolesOnTarget)(no_seed, spacing_px, memory, penalties);
}

void RateRows(const ConfidenceInput& input, const cv::Range& rows, cv::Mat1b& confidence) {
  HWY_DYNAMIC_DISPATCH(RateRowsOnTarget)(input, rows, confidence);
}

}  // namespace sprout::grow
#endif  // HWY_ONCE
