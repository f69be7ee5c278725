// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
// Loops over a row are plain: the compiler makes vectors of them.
#include "services/grow/confidence/confidence_kernel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "common/core/census.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/confidence/confidence_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "services/grow/confidence/nearness-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

using Ints = std::vector<int32_t>;

inline uint8_t ToByte(int value) { return static_cast<uint8_t>(std::clamp(value, 0, 255)); }

// The largest and the smallest of 3 rows in each column; the ends are repeated, so that a window of
// 3 always fits.
void FindRangeOfRows(const DisparityImage& map, int v, int16_t* HWY_RESTRICT most,
                     int16_t* HWY_RESTRICT least) {
  const int width = map.width();
  const auto row = [&](int at) { return map.counts()[std::clamp(at, 0, map.height() - 1)]; };
  const int16_t* HWY_RESTRICT a = row(v - 1);
  const int16_t* HWY_RESTRICT b = row(v);
  const int16_t* HWY_RESTRICT c = row(v + 1);
  for (int u = 0; u < width; ++u) {
    most[u + 1] = std::max(a[u], std::max(b[u], c[u]));
    least[u + 1] = std::min(a[u], std::min(b[u], c[u]));
  }
  for (int16_t* ends : {most, least}) {
    ends[0] = ends[1];
    ends[width + 1] = ends[width];
  }
}

// |d(x − 2) + d(x + 2) − 2·d(x)|, and the same over the rows.
void WriteBends(const DisparityImage& map, int y, int cells, uint8_t* HWY_RESTRICT bends) {
  const int last = (map.height() - 1) / kCellPx;
  const int16_t* HWY_RESTRICT row = map.counts()[kCellPx * y];
  const int16_t* HWY_RESTRICT above = map.counts()[kCellPx * std::max(y - 2, 0)];
  const int16_t* HWY_RESTRICT below = map.counts()[kCellPx * std::min(y + 2, last)];
  const auto bend = [&](int x, int before, int behind) HWY_ATTR {
    const int twice = 2 * row[2 * x];
    const int along = std::abs(row[2 * before] + row[2 * behind] - twice);
    const int across = std::abs(above[2 * x] + below[2 * x] - twice);
    return ToByte(LevelOf(along + across + 1));
  };
  for (int x = 0; x < std::min(2, cells); ++x) bends[x] = bend(x, 0, std::min(x + 2, cells - 1));
  for (int x = 2; x < cells - 2; ++x) bends[x] = bend(x, x - 2, x + 2);
  for (int x = std::max(2, cells - 2); x < cells; ++x) bends[x] = bend(x, x - 2, cells - 1);
}

void FindStepsOnTarget(const DisparityImage& filled, const cv::Range& rows,
                       ConfidenceFeatures& features) {
  const int width = filled.width();
  const int cells = features.step.cols;
  const auto size = static_cast<size_t>(width + 2);
  std::vector<int16_t> memory(3 * size);
  int16_t* HWY_RESTRICT most = memory.data();
  int16_t* HWY_RESTRICT least = most + size;
  int16_t* HWY_RESTRICT range = least + size;
  for (int y = rows.start; y < rows.end; ++y) {
    FindRangeOfRows(filled, kCellPx * y, most, least);
    for (int u = 0; u < width; ++u) {
      const int high = std::max(most[u], std::max(most[u + 1], most[u + 2]));
      const int low = std::min(least[u], std::min(least[u + 1], least[u + 2]));
      range[u] = static_cast<int16_t>(std::min(high - low, 32767));
    }
    uint8_t* HWY_RESTRICT steps = features.step[y];
    uint8_t* HWY_RESTRICT edges = features.edge[y];
    for (int x = 0; x < cells; ++x) {
      steps[x] = ToByte(LevelOf(range[kCellPx * x] + 1));
      edges[x] = steps[x] >= kEdgeLevel ? 255 : 0;
    }
    WriteBends(filled, y, cells, features.bend[y]);
  }
}

// Sums over the windows around cells, from above to below.
class CellMatcher {
 public:
  CellMatcher(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& grown,
              const DisparityImage& filled)
      : left_(left),
        right_(right),
        grown_(grown),
        map_(filled),
        cells_(CellsOf(filled.size())),
        left_census_(static_cast<size_t>(left.cols)),
        right_census_(static_cast<size_t>(right.cols + 2 * kReach)),
        words_(static_cast<size_t>(cells_.width)) {
    const auto size = static_cast<size_t>(cells_.width + 2 * kRadius);
    for (Rows* rows : {&margins_, &counts_}) {
      for (Ints& row : *rows) row.resize(size);
    }
    margin_.resize(size);
    count_.resize(size);
  }

  void Begin(int y) {
    for (int near = y - kRadius; near < y + kRadius; ++near) Match(near);
  }

  // @pre called for one row after the other.
  void WriteRow(int y, ConfidenceFeatures& features) {
    Match(y + kRadius);
    AddRows(margins_, margin_);
    AddRows(counts_, count_);
    uint8_t* HWY_RESTRICT margins = features.margin[y];
    uint8_t* HWY_RESTRICT gaps = features.gaps[y];
    uint8_t* HWY_RESTRICT blanks = features.blank[y];
    const int32_t* HWY_RESTRICT margin = margin_.data() + kRadius;
    const int32_t* HWY_RESTRICT count = count_.data() + kRadius;
    const auto all5 = [](const int32_t* row, int x) HWY_ATTR {
      return row[x - 2] + row[x - 1] + row[x] + row[x + 1] + row[x + 2];
    };
    // A loop without a fixed end does not become vectors.
    const int cells = cells_.width;
    for (int x = 0; x < cells; ++x) {
      margins[x] = ToByte(128 - all5(margin, x));
    }
    for (int x = 0; x < cells; ++x) {
      const int counts = kCountUnit * all5(count, x);
      gaps[x] = static_cast<uint8_t>(counts);
      blanks[x] = static_cast<uint8_t>(counts / kBlank);
    }
  }

 private:
  static constexpr int kRadius = 2;        // of the windows
  static constexpr int kCountUnit = 10;    // 255 / number of cells in the window, rounded down
  static constexpr int kBlank = 1 << 16;   // beside a gap, which counts 1
  static constexpr int kReach = 1024 + 8;  // as far as a disparity leads, and a census word
  using Rows = std::array<Ints, 2 * kRadius + 1>;

  // Costs of the cells of a row, in the place of the row five above. Beyond an image: those of its
  // last row, and zeros in the right one.
  void Match(int y) {
    const int v = kCellPx * std::clamp(y, 0, cells_.height - 1);
    CensusOfRow(left_, v, left_census_.data());
    CensusOfRow(right_, v, right_census_.data() + kReach);
    Warp(map_.counts()[v]);
    const auto place = static_cast<size_t>((y + kRadius) % (2 * kRadius + 1));
    int32_t* HWY_RESTRICT margin = margins_[place].data() + kRadius;
    int32_t* HWY_RESTRICT count = counts_[place].data() + kRadius;
    const int16_t* HWY_RESTRICT grown = grown_.counts()[v];
    const uint8_t* HWY_RESTRICT left = left_[v];
    const uint8_t* HWY_RESTRICT census = left_census_.data();
    const uint32_t* HWY_RESTRICT words = words_.data();
    const int cells = cells_.width;
    for (int x = 0; x < cells; ++x) {
      count[x] = grown[2 * x] == DisparityImage::kInvalid ? 1 : 0;
    }
    for (int x = 1; x < cells - 1; ++x) {
      count[x] += left[2 * x + 1] == left[2 * x - 1] ? kBlank : 0;
    }
    for (const auto& [end, beside] : {std::pair(0, 1), {cells - 1, cells - 2}}) {
      count[end] += count[beside] / kBlank * kBlank;
    }
    for (int x = 0; x < cells; ++x) {
      // Numbers of bits of three bytes at once; none of the fourth come into them.
      uint32_t bits = words[x] ^ (census[2 * x] * 0x010101U);
      bits -= bits >> 1 & 0x555555U;
      bits = (bits & 0x333333U) + (bits >> 2 & 0x333333U);
      bits = (bits + (bits >> 4)) & 0x0f0f0fU;
      const auto before = static_cast<int32_t>(bits & 15);
      const auto here = static_cast<int32_t>(bits >> 8 & 15);
      const auto behind = static_cast<int32_t>(bits >> 16 & 15);
      margin[x] = std::min(before, behind) - here;
    }
    for (int32_t* row : {margin, count}) {
      for (int i = 1; i <= kRadius; ++i) {
        row[-i] = row[0];
        row[cells - 1 + i] = row[cells - 1];
      }
    }
  }

  // The right image's census at u − d − 1, u − d and u − d + 1. Where there is no disparity that
  // lies beyond the image.
  void Warp(const int16_t* HWY_RESTRICT counts) {
    const uint8_t* HWY_RESTRICT census = right_census_.data() + kReach;
    uint32_t* HWY_RESTRICT words = words_.data();
    for (int x = 0; x < cells_.width; ++x) {
      constexpr int kCounts = DisparityImage::kCountsPerPixel;
      const int whole = (counts[2 * x] + kCounts / 2) >> 5;
      static_assert(kCounts == 1 << 5);
      static_assert(std::endian::native == std::endian::little);
      // The fourth byte does not count.
      std::memcpy(&words[x], census + 2 * x - whole - 1, sizeof(words[x]));
    }
  }

  static void AddRows(const Rows& rows, Ints& sums) {
    int32_t* HWY_RESTRICT sum = sums.data();
    for (size_t x = 0; x < sums.size(); ++x) {
      sum[x] = rows[0][x] + rows[1][x] + rows[2][x] + rows[3][x] + rows[4][x];
    }
  }

  const cv::Mat1b& left_;
  const cv::Mat1b& right_;
  const DisparityImage& grown_;
  const DisparityImage& map_;
  const cv::Size cells_;
  Bytes left_census_, right_census_;  // rows; the right one with zeros on either side
  std::vector<uint32_t> words_;       // of a row of cells
  Rows margins_, counts_;
  Ints margin_, count_;  // their sums over rows
};

void MatchCellsOnTarget(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& grown,
                        const DisparityImage& filled, const cv::Range& rows,
                        ConfidenceFeatures& features) {
  CellMatcher matcher(left, right, grown, filled);
  matcher.Begin(rows.start);
  for (int y = rows.start; y < rows.end; ++y) {
    matcher.WriteRow(y, features);
  }
}

// Copies a row of cells to its rows of pixels; `none` where there is no disparity.
void ExpandRow(const Bytes& cells, const DisparityImage& map, int y, uint8_t none, Bytes& twice,
               cv::Mat1b& pixels) {
  const uint8_t* HWY_RESTRICT once = cells.data();
  uint8_t* HWY_RESTRICT wide = twice.data();
  const auto count = static_cast<int>(cells.size());
  const int width = map.width();
  for (int x = 0; x < count; ++x) wide[2 * x] = wide[2 * x + 1] = once[x];
  for (int v = kCellPx * y; v < std::min(kCellPx * (y + 1), map.height()); ++v) {
    const int16_t* HWY_RESTRICT counts = map.counts()[v];
    uint8_t* HWY_RESTRICT row = pixels[v];
    for (int u = 0; u < width; ++u) {
      row[u] = counts[u] == DisparityImage::kInvalid ? none : wide[u];
    }
  }
}

void RateCellsOnTarget(const ConfidenceTables& tables, const ConfidenceFeatures& features,
                       const DisparityImage& filled, const cv::Mat1b& sigma_prior,
                       const cv::Range& rows, cv::Mat1b& confidence, cv::Mat1b& sigma) {
  const int cells = features.step.cols;
  Bytes sure(static_cast<size_t>(cells)), spread(sure.size());
  Bytes twice(2 * sure.size()), unknown(2 * sure.size(), kMaxSigmaCounts);
  std::vector<uint32_t> seeds(static_cast<size_t>(features.seed.cols));  // and roughness: of blocks
  for (int y = rows.start; y < rows.end; ++y) {
    const uint8_t* const tof_seed = features.tof_seed[y / 2];
    const uint8_t* const seed = features.seed[y / 2];
    const uint8_t* const rough = features.rough[y / 2];
    for (size_t i = 0; i < seeds.size(); ++i) {
      seeds[i] = tables.start + tables.tof_seed[tof_seed[i]] + tables.seed[seed[i]] +
                 tables.rough[rough[i]];
    }
    const uint8_t* const step = features.step[y];
    const uint8_t* const bend = features.bend[y];
    const uint8_t* const margin = features.margin[y];
    const uint8_t* const gaps = features.gaps[y];
    const uint8_t* const blank = features.blank[y];
    const uint8_t* const edge = features.edge[y];
    const uint8_t* const prior = sigma_prior.empty() ? unknown.data() : sigma_prior[kCellPx * y];
    for (int x = 0; x < cells; ++x) {
      const uint32_t sum = seeds[static_cast<size_t>(x / 2)] + tables.step[step[x]] +
                           tables.bend[bend[x]] + tables.margin[margin[x]] + tables.gaps[gaps[x]] +
                           tables.blank[blank[x]] + tables.edge[edge[x]] +
                           tables.prior[prior[2 * x]];
      sure[static_cast<size_t>(x)] = tables.ConfidenceOf(sum);
      spread[static_cast<size_t>(x)] = tables.SigmaOf(sum);
    }
    ExpandRow(sure, filled, y, 0, twice, confidence);
    ExpandRow(spread, filled, y, kMaxSigmaCounts, twice, sigma);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::grow {

HWY_EXPORT(FindStepsOnTarget);
HWY_EXPORT(SpreadNearnessOnTarget);
HWY_EXPORT(MatchCellsOnTarget);
HWY_EXPORT(RateCellsOnTarget);

void FindSteps(const DisparityImage& filled, const cv::Range& rows, ConfidenceFeatures& features) {
  HWY_DYNAMIC_DISPATCH(FindStepsOnTarget)(filled, rows, features);
}

void SpreadNearness(cv::Mat1b& marks, std::vector<uint8_t>& memory) {
  HWY_DYNAMIC_DISPATCH(SpreadNearnessOnTarget)(marks, memory);
}

void MatchCells(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& grown,
                const DisparityImage& filled, const cv::Range& rows, ConfidenceFeatures& features) {
  HWY_DYNAMIC_DISPATCH(MatchCellsOnTarget)(left, right, grown, filled, rows, features);
}

void RateCells(const ConfidenceTables& tables, const ConfidenceFeatures& features,
               const DisparityImage& filled, const cv::Mat1b& sigma_prior, const cv::Range& rows,
               cv::Mat1b& confidence, cv::Mat1b& sigma) {
  HWY_DYNAMIC_DISPATCH(RateCellsOnTarget)
  (tables, features, filled, sigma_prior, rows, confidence, sigma);
}

}  // namespace sprout::grow
#endif  // HWY_ONCE
