// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "common/rig/bilinear_remap.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/rig/bilinear_remap.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef SPROUT_COMMON_RIG_REMAP_ROW_
#define SPROUT_COMMON_RIG_REMAP_ROW_
namespace sprout {

// What a row of the result is made of: the members of BilinearRemap.
struct RemapRow {
  const uint8_t* image;
  ptrdiff_t width;  // of the image, px
  const int32_t* windows;
  const uint8_t* places;
  const uint16_t* weights;
  const std::array<int32_t, BilinearRemap::kGroup>* apart;
};

}  // namespace sprout
#endif

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<int32_t>;
using V = hn::Vec<D>;
using Bytes = hn::Rebind<uint8_t, D>;

constexpr size_t kGroup = BilinearRemap::kGroup;
constexpr size_t kBlock = 64;  // pixels, which the cache holds; a multiple of all numbers of lanes

template <typename Number>
HWY_INLINE Number Read(const uint8_t* from) {
  Number number;
  std::memcpy(&number, from, sizeof number);
  return number;
}

// First ones of the four pixels of each of a group, from the first one of the image.
HWY_INLINE void OffsetsOf(const RemapRow& row, size_t group, int32_t* offsets) {
  const int32_t window = row.windows[group];
  if (window < 0) {
    std::copy_n(row.apart[-1 - window].data(), kGroup, offsets);
    return;
  }
  const hn::CappedTag<int32_t, kGroup> d;
  const auto next_row = hn::Set(d, static_cast<int32_t>(row.width));
  for (size_t i = 0; i < kGroup; i += hn::Lanes(d)) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const auto place = hn::PromoteTo(d, hn::LoadU(bytes, row.places + group * kGroup + i));
    const auto column = hn::Add(hn::Set(d, window), hn::And(place, hn::Set(d, 15)));
    const auto is_lower = hn::TestBit(place, hn::Set(d, 16));
    hn::StoreU(hn::Add(column, hn::IfThenElseZero(is_lower, next_row)), d, offsets + i);
  }
}

// Collects the two pixels above and the two below of each pixel of a grey group. Three loads hold
// them all; a table lookup picks them out of 16 bytes.
HWY_INLINE void CollectGrey(const RemapRow& row, size_t group, uint16_t* above, uint16_t* below) {
#if HWY_TARGET != HWY_SCALAR
  if (row.windows[group] >= 0) {
    const hn::FixedTag<uint8_t, 16> d;
    const hn::FixedTag<uint16_t, 8> d16;
    const auto word = Read<uint64_t>(row.places + group * kGroup);
    const auto left = hn::BitCast(d, hn::Set(hn::FixedTag<uint64_t, 2>(), word));
    const auto places = hn::InterleaveLower(d, left, hn::Add(left, hn::Set(d, 1)));
    const auto columns = hn::And(places, hn::Set(d, 15));
    const auto is_lower = hn::TestBit(places, hn::Set(d, 16));
    const auto pairs = [&](int v) {
      const uint8_t* const at = row.image + row.windows[group] + v * row.width;
      return hn::TableLookupBytes(hn::LoadU(d, at), columns);
    };
    const auto middle = pairs(1);
    hn::Store(hn::BitCast(d16, hn::IfThenElse(is_lower, middle, pairs(0))), d16, above);
    hn::Store(hn::BitCast(d16, hn::IfThenElse(is_lower, pairs(2), middle)), d16, below);
    return;
  }
#endif
  int32_t offsets[kGroup];
  OffsetsOf(row, group, offsets);
  for (size_t i = 0; i < kGroup; ++i) {
    above[i] = Read<uint16_t>(row.image + offsets[i]);
    below[i] = Read<uint16_t>(row.image + offsets[i] + row.width);
  }
}

template <int kShift>
HWY_INLINE V ByteAt(V bits) {
  return hn::And(hn::ShiftRight<kShift>(bits), hn::Set(D(), 255));
}

// a, b above, c, d below; with the weights of the right ones and, from the ninth bit on, of the
// lower ones, in 1/32.
HWY_INLINE hn::Vec<Bytes> Mean(V a, V b, V c, V d, V weight) {
  const V right = ByteAt<0>(weight);
  const V below = ByteAt<8>(weight);
  const auto blend = [](V first, V second, V of_second) {
    return hn::Add(hn::ShiftLeft<5>(first), hn::Mul(of_second, hn::Sub(second, first)));
  };
  const V sum = blend(blend(a, b, right), blend(c, d, right), below);
  return hn::DemoteTo(Bytes(), hn::ShiftRight<10>(hn::Add(sum, hn::Set(D(), 512))));
}

HWY_INLINE V Load16(const uint16_t* from) {
  return hn::PromoteTo(D(), hn::Load(hn::Rebind<uint16_t, D>(), from));
}

// Rows are made in blocks; the last one is filled up with whatever was there before.
void RemapGreyRow(const RemapRow& row, size_t width, uint8_t* to) {
  HWY_ALIGN uint16_t above[kBlock] = {};
  HWY_ALIGN uint16_t below[kBlock] = {};
  HWY_ALIGN uint16_t weights[kBlock] = {};
  HWY_ALIGN uint8_t means[kBlock];
  for (size_t u = 0; u < width; u += kBlock) {
    const size_t count = std::min(kBlock, width - u);
    for (size_t i = 0; i < count; i += kGroup) {
      CollectGrey(row, (u + i) / kGroup, above + i, below + i);
    }
    std::copy_n(row.weights + u, count, weights);
    for (size_t i = 0; i < kBlock; i += hn::Lanes(D())) {
      const V first = Load16(above + i);
      const V second = Load16(below + i);
      hn::Store(Mean(ByteAt<0>(first), ByteAt<8>(first), ByteAt<0>(second), ByteAt<8>(second),
                     Load16(weights + i)),
                Bytes(), means + i);
    }
    std::copy_n(means, count, to + u);
  }
}

// Words have the left or right four bytes of six, above or below, so that none is read beyond the
// image.
void RemapColourRow(const RemapRow& row, size_t width, uint8_t* to) {
  HWY_ALIGN int32_t words[4][kBlock] = {};
  HWY_ALIGN uint16_t weights[kBlock] = {};
  HWY_ALIGN uint8_t means[3 * kBlock];
  int32_t offsets[kBlock];
  for (size_t u = 0; u < width; u += kBlock) {
    const size_t count = std::min(kBlock, width - u);
    for (size_t i = 0; i < count; i += kGroup) OffsetsOf(row, (u + i) / kGroup, offsets + i);
    for (size_t i = 0; i < count; ++i) {
      const uint8_t* const at = row.image + 3 * ptrdiff_t{offsets[i]};
      words[0][i] = Read<int32_t>(at);      // B G R B
      words[1][i] = Read<int32_t>(at + 2);  // R B G R
      words[2][i] = Read<int32_t>(at + 3 * row.width);
      words[3][i] = Read<int32_t>(at + 3 * row.width + 2);
    }
    std::copy_n(row.weights + u, count, weights);
    for (size_t i = 0; i < kBlock; i += hn::Lanes(D())) {
      const V weight = Load16(weights + i);
      const auto load = [&](size_t word) { return hn::Load(D(), words[word] + i); };
      const V first = load(0), second = load(1), third = load(2), fourth = load(3);
      hn::StoreInterleaved3(
          Mean(ByteAt<0>(first), ByteAt<24>(first), ByteAt<0>(third), ByteAt<24>(third), weight),
          Mean(ByteAt<8>(first), ByteAt<16>(second), ByteAt<8>(third), ByteAt<16>(fourth), weight),
          Mean(ByteAt<16>(first), ByteAt<24>(second), ByteAt<16>(third), ByteAt<24>(fourth),
               weight),
          Bytes(), means + 3 * i);
    }
    std::copy_n(means, 3 * count, to + 3 * u);
  }
}

void RemapRowOnTarget(const RemapRow& row, int channels, size_t width, uint8_t* to) {
  channels == 1 ? RemapGreyRow(row, width, to) : RemapColourRow(row, width, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout {

HWY_EXPORT(RemapRowOnTarget);

BilinearRemap::BilinearRemap(const cv::Mat2f& places, cv::Size source)
    : source_(source), size_(places.size()) {
  assert(source.width >= 2 && source.height >= 2);
  constexpr int kParts = 32;  // of a pixel
  // The upper or left one of two pixels, and the other one's weight; the last pixel has no other.
  const auto split = [](float place, int length) {
    const int parts = std::clamp(cvRound(place * kParts), 0, (length - 1) * kParts);
    const int first = std::min(parts / kParts, length - 2);
    return std::pair(first, parts - first * kParts);
  };
  const int groups = (size_.width + kGroup - 1) / kGroup;
  windows_.create(size_.height, groups);
  places_.create(size_.height, groups * kGroup);
  weights_.create(size_.height, groups * kGroup);
  for (int v = 0; v < size_.height; ++v) {
    for (int group = 0; group < groups; ++group) {
      std::array<cv::Point, kGroup> pixels;
      for (int i = 0; i < kGroup; ++i) {
        const int u = std::min(group * kGroup + i, size_.width - 1);
        const auto [column, right] = split(places(v, u)[0], source.width);
        const auto [row, below] = split(places(v, u)[1], source.height);
        pixels[static_cast<size_t>(i)] = {column, row};
        weights_(v, group * kGroup + i) = static_cast<uint16_t>(right + 256 * below);
      }
      AddGroup(v, group, pixels);
    }
  }
}

void BilinearRemap::AddGroup(int v, int group, const std::array<cv::Point, kGroup>& pixels) {
  // A window has three rows of so many pixels.
  constexpr int kColumns = 16;
  const auto [left, right] = std::ranges::minmax(pixels, {}, &cv::Point::x);
  const auto [top, bottom] = std::ranges::minmax(pixels, {}, &cv::Point::y);
  const bool fits = right.x - left.x < kColumns - 1 && bottom.y - top.y < 2 &&
                    source_.width >= kColumns && source_.height >= 3;
  // No window goes beyond the end of the image.
  const cv::Point first(std::min(left.x, source_.width - kColumns),
                        std::min(top.y, source_.height - 3));
  const auto offset = [&](cv::Point pixel) { return pixel.y * source_.width + pixel.x; };
  windows_(v, group) = fits ? offset(first) : -1 - static_cast<int>(apart_.size());
  if (!fits) apart_.emplace_back();
  for (int i = 0; i < kGroup; ++i) {
    const cv::Point pixel = pixels[static_cast<size_t>(i)];
    const cv::Point place = pixel - first;
    if (fits) {
      places_(v, group * kGroup + i) = static_cast<uint8_t>(place.x + 16 * place.y);
    } else {
      apart_.back()[static_cast<size_t>(i)] = offset(pixel);
    }
  }
}

cv::Mat BilinearRemap::Apply(const cv::Mat& source) const {
  assert(source.size() == source_);
  const cv::Mat image = source.isContinuous() ? source : source.clone();
  cv::Mat result(size_, image.type());
  cv::parallel_for_({0, result.rows}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      const RemapRow row{image.data, image.cols,  windows_[v],
                         places_[v], weights_[v], apart_.data()};
      HWY_DYNAMIC_DISPATCH(RemapRowOnTarget)
      (row, image.channels(), static_cast<size_t>(result.cols), result.ptr(v));
    }
  });
  return result;
}

}  // namespace sprout
#endif  // HWY_ONCE
