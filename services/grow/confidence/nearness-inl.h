// Chamfer distances along rows and across them, for each instruction set: Highway compiles this
// file once for each, so it has no usual include guard.
#if defined(SPROUT_SERVICES_GROW_NEARNESS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_NEARNESS_INL_H_
#undef SPROUT_SERVICES_GROW_NEARNESS_INL_H_
#else
#define SPROUT_SERVICES_GROW_NEARNESS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

using Bytes = std::vector<uint8_t>;

// A byte less, at least 0.
inline uint8_t Less(uint8_t nearness, uint8_t by) {
  return static_cast<uint8_t>(std::max(nearness, by) - by);
}

inline constexpr int kMaxCells = 64;   // of one pass along a row; all passes: 127 > 255 / 3
inline constexpr uint8_t kBeside = 3;  // the mask of Borgefors
inline constexpr uint8_t kAcross = 4;

// From both sides along a row: passes of 1, 2, 4 ... cells.
// @param from, to  with kMaxCells zeros on either side.
inline void SpreadAlongRow(uint8_t* row, int width, uint8_t* from, uint8_t* to) {
  std::copy_n(row, width, from);
  for (int cells = 1; cells <= kMaxCells; cells *= 2) {
    const auto loss = static_cast<uint8_t>(kBeside * cells);
    const uint8_t* HWY_RESTRICT old = from;
    uint8_t* HWY_RESTRICT spread = to;
    for (int x = 0; x < width; ++x) {
      spread[x] = std::max(old[x], Less(std::max(old[x - cells], old[x + cells]), loss));
    }
    std::swap(from, to);
  }
  std::copy_n(from, width, row);
}

// Spreads distances from one row to the next one.
inline void SpreadToRow(const uint8_t* HWY_RESTRICT from, int width, uint8_t* HWY_RESTRICT to) {
  const auto spread = [&](int x, uint8_t beside) HWY_ATTR {
    to[x] = std::max(to[x], std::max(Less(from[x], kBeside), Less(beside, kAcross)));
  };
  for (int x = 1; x < width - 1; ++x) {
    const uint8_t beside = std::max(from[x - 1], from[x + 1]);
    to[x] = std::max(to[x], std::max(Less(from[x], kBeside), Less(beside, kAcross)));
  }
  if (width == 1) return spread(0, 0);
  spread(0, from[1]);
  spread(width - 1, from[width - 2]);
}

// First along the rows, then down and up: a shortest way of the mask can be walked in this order.
inline void SpreadNearnessOnTarget(cv::Mat1b& marks, Bytes& memory) {
  const auto size = static_cast<size_t>(marks.cols + 2 * kMaxCells);
  memory.assign(2 * size, 0);
  uint8_t* const one = memory.data() + kMaxCells;
  for (int y = 0; y < marks.rows; ++y) SpreadAlongRow(marks[y], marks.cols, one, one + size);
  for (int y = 1; y < marks.rows; ++y) SpreadToRow(marks[y - 1], marks.cols, marks[y]);
  for (int y = marks.rows - 1; y-- > 0;) SpreadToRow(marks[y + 1], marks.cols, marks[y]);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
