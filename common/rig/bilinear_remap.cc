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

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<int32_t>;
using V = hn::Vec<D>;
using Bytes = hn::Rebind<uint8_t, D>;

constexpr size_t kBlock = 64;  // a multiple of all numbers of lanes

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

template <typename Number>
HWY_INLINE uint32_t Read(const uint8_t* from) {
  Number number;
  std::memcpy(&number, from, sizeof number);
  return number;
}

// A row, in blocks that the cache holds. Pixels are collected one by one: instructions that gather
// them are slower on the CPU that this was tried on (services/capture/NOTES.md). A word has of a
// grey image two pixels above and two below, of a colour image the left or right four bytes of six,
// above or below, so that none is read beyond the image.
template <bool kColour>
HWY_INLINE void RemapRow(const uint8_t* image, ptrdiff_t stride, const int32_t* offsets,
                         const uint16_t* weights, size_t width, uint8_t* to) {
  const D d;
  HWY_ALIGN uint32_t words[kColour ? 4 : 1][kBlock] = {};
  HWY_ALIGN uint16_t both[kBlock] = {};
  HWY_ALIGN uint8_t means[(kColour ? 3 : 1) * kBlock];
  for (size_t u = 0; u < width; u += kBlock) {
    const size_t count = std::min(kBlock, width - u);
    for (size_t i = 0; i < count; ++i) {
      const uint8_t* const at = image + ptrdiff_t{offsets[u + i]} * (kColour ? 3 : 1);
      if constexpr (kColour) {
        words[0][i] = Read<uint32_t>(at);      // B G R B
        words[1][i] = Read<uint32_t>(at + 2);  // R B G R
        words[2][i] = Read<uint32_t>(at + stride);
        words[3][i] = Read<uint32_t>(at + stride + 2);
      } else {
        words[0][i] = Read<uint16_t>(at) | Read<uint16_t>(at + stride) << 16;
      }
    }
    std::copy_n(weights + u, count, both);
    const auto load = [&](size_t word, size_t i) {
      return hn::BitCast(d, hn::Load(hn::RebindToUnsigned<D>(), words[word] + i));
    };
    for (size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
      const V weight = hn::PromoteTo(d, hn::Load(hn::Rebind<uint16_t, D>(), both + i));
      const V first = load(0, i);
      if constexpr (kColour) {
        const V second = load(1, i), third = load(2, i), fourth = load(3, i);
        hn::StoreInterleaved3(
            Mean(ByteAt<0>(first), ByteAt<24>(first), ByteAt<0>(third), ByteAt<24>(third), weight),
            Mean(ByteAt<8>(first), ByteAt<16>(second), ByteAt<8>(third), ByteAt<16>(fourth),
                 weight),
            Mean(ByteAt<16>(first), ByteAt<24>(second), ByteAt<16>(third), ByteAt<24>(fourth),
                 weight),
            Bytes(), means + 3 * i);
      } else {
        hn::Store(
            Mean(ByteAt<0>(first), ByteAt<8>(first), ByteAt<16>(first), ByteAt<24>(first), weight),
            Bytes(), means + i);
      }
    }
    constexpr size_t kChannels = kColour ? 3 : 1;
    std::copy_n(means, count * kChannels, to + u * kChannels);
  }
}

void RemapRowOnTarget(const uint8_t* image, ptrdiff_t stride, int channels, const int32_t* offsets,
                      const uint16_t* weights, size_t width, uint8_t* to) {
  channels == 1 ? RemapRow<false>(image, stride, offsets, weights, width, to)
                : RemapRow<true>(image, stride, offsets, weights, width, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout {

HWY_EXPORT(RemapRowOnTarget);

BilinearRemap::BilinearRemap(const cv::Mat2f& places, cv::Size source)
    : source_(source), offsets_(places.size()), weights_(places.size()) {
  assert(source.width >= 2 && source.height >= 2);
  constexpr int kParts = 32;  // of a pixel
  // The upper or left one of two pixels, and the other one's weight; the last pixel has no other.
  const auto split = [](float place, int length) {
    const int parts = std::clamp(cvRound(place * kParts), 0, (length - 1) * kParts);
    const int first = std::min(parts / kParts, length - 2);
    return std::pair(first, parts - first * kParts);
  };
  for (int v = 0; v < places.rows; ++v) {
    for (int u = 0; u < places.cols; ++u) {
      const auto [column, right] = split(places(v, u)[0], source.width);
      const auto [row, below] = split(places(v, u)[1], source.height);
      offsets_(v, u) = row * source.width + column;
      weights_(v, u) = static_cast<uint16_t>(right + 256 * below);
    }
  }
}

cv::Mat BilinearRemap::Apply(const cv::Mat& source) const {
  assert(source.size() == source_);
  const cv::Mat image = source.isContinuous() ? source : source.clone();
  const int channels = image.channels();
  const ptrdiff_t stride = ptrdiff_t{image.cols} * channels;
  cv::Mat result(offsets_.size(), image.type());
  cv::parallel_for_({0, result.rows}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      HWY_DYNAMIC_DISPATCH(RemapRowOnTarget)
      (image.data, stride, channels, offsets_[v], weights_[v], static_cast<size_t>(result.cols),
       result.ptr(v));
    }
  });
  return result;
}

}  // namespace sprout
#endif  // HWY_ONCE
