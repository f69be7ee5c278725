#include "services/refine/semi_global.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstring>

#include "common/core/parallel.h"

namespace sprout {
namespace {

constexpr int kBits = 24;  // of a census transform
constexpr int kCensusRadius = 2;
// Costs are census bits. Of the penalties and the cost of leaving the image those are taken that
// measured best; none is sensitive.
constexpr int kSmallStep = 5;      // a change by 1 px
constexpr int kLargeStep = 50;     // a larger one, over equal grey values
constexpr int kLeastLarge = 7;     // and at most over an edge of the image
constexpr int kHalfLargeAt = 20;   // difference of grey values that halves it
constexpr int kOutside = 12;       // a match outside the right image: as bad as one by chance
constexpr int kKnownPerPx = 6;     // what a pixel of difference from a known disparity costs
constexpr int kMostKnown = kBits;  // at most: the images can outvote it

// Sixteen numbers at once; compilers make of it what the processor has.
using Bytes = uint8_t __attribute__((vector_size(16)));
using Words = uint16_t __attribute__((vector_size(16)));
constexpr int kLanes = 16;
constexpr int kWords = 8;
constexpr Words kWord = {0, 1, 2, 3, 4, 5, 6, 7};
constexpr uint16_t kNoSum = UINT16_MAX;

// Entries on either side of a pixel's path costs that stand for disparities it has not.
constexpr int kPadding = 24;
constexpr uint8_t kNever = 200;  // greater than any path cost, and + kSmallStep still 8 bits
static_assert(kBits + kMostKnown + kLargeStep < kNever && kNever + kSmallStep <= UINT8_MAX);
static_assert(2 * (kBits + kMostKnown + kLargeStep) <= UINT8_MAX);

Bytes Load(const uint8_t* from) {
  Bytes bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  return bytes;
}

void Store(Bytes bytes, uint8_t* to) { std::memcpy(to, &bytes, sizeof bytes); }

Bytes Least(Bytes a, Bytes b) { return a < b ? a : b; }

// The lanes from 8 · kHalf on.
template <int kHalf>
Words Widened(Bytes x) {
  using Half = uint8_t __attribute__((vector_size(8)));
  constexpr int kFrom = 8 * kHalf;
  const Half half = __builtin_shufflevector(x, x, kFrom, kFrom + 1, kFrom + 2, kFrom + 3, kFrom + 4,
                                            kFrom + 5, kFrom + 6, kFrom + 7);
  return __builtin_convertvector(half, Words);
}

Words LoadWords(const uint16_t* from) {
  Words words;
  std::memcpy(&words, from, sizeof words);
  return words;
}

void StoreWords(Words words, uint16_t* to) { std::memcpy(to, &words, sizeof words); }

Words Least(Words a, Words b) { return a < b ? a : b; }

uint16_t LeastLane(Words x) {
  x = Least(x, __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3));
  x = Least(x, __builtin_shufflevector(x, x, 2, 3, 0, 1, 2, 3, 0, 1));
  return std::min(x[0], x[1]);
}

uint8_t LeastLane(Bytes x) {
  x = Least(x, __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7));
  x = Least(x, __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3));
  x = Least(x, __builtin_shufflevector(x, x, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1));
  return std::min(x[0], x[1]);
}

// Number of ones in every lane, by adding neighbouring fields.
Bytes CountOnes(Bytes bits) {
  bits -= bits >> 1 & uint8_t{0x55};
  bits = (bits & uint8_t{0x33}) + (bits >> 2 & uint8_t{0x33});
  return (bits + (bits >> 4)) & uint8_t{0x0f};
}

// The penalty of a large change, by the difference of grey values that it goes with.
constexpr auto kLargeSteps = [] {
  std::array<uint8_t, UINT8_MAX + 1> steps{};
  for (int difference = 0; difference <= UINT8_MAX; ++difference) {
    steps[static_cast<size_t>(difference)] = static_cast<uint8_t>(
        std::max(kLeastLarge, kLargeStep * kHalfLargeAt / (kHalfLargeAt + difference)));
  }
  return steps;
}();

uint8_t LargeStep(int grey_difference) { return kLargeSteps[static_cast<size_t>(grey_difference)]; }

}  // namespace

// The paths that come from the rows above (or below, when it goes up) and from the pixel before.
class SemiGlobalMatcher::Sweep {
 public:
  Sweep(const cv::Mat1b& left, const StereoSearch& search, const std::vector<uint8_t>& costs,
        std::vector<uint16_t>& sums)
      : left_(left),
        first_(search.first),
        labels_(search.labels),
        slot_(static_cast<size_t>(labels_ + 2 * kPadding)),
        costs_(costs),
        sums_(sums),
        start_(slot_, 0) {
    for (auto& row : rows_) {
      row.assign(kDirections * static_cast<size_t>(left.cols) * slot_, kNever);
    }
  }

  // @param step  1 or −1: the order of rows, and of the pixels in them.
  void Run(int step) {
    const int rows = left_.rows;
    for (int i = 0, v = step > 0 ? 0 : rows - 1; i < rows; ++i, v += step) {
      if (labels_ == kLanes) {
        Row<true>(v, step);
      } else {
        Row<false>(v, step);
      }
      std::swap(rows_[0], rows_[1]);
    }
  }

 private:
  static constexpr size_t kDirections = 4;

  // The pixel before on a path.
  struct Before {
    const uint8_t* costs;  // less their minimum, from the disparity on that comes first here
    uint8_t large_step;
  };

  uint8_t* Slot(std::vector<uint8_t>& row, int u, size_t direction) const {
    return row.data() + (kDirections * static_cast<size_t>(u) + direction) * slot_ + kPadding;
  }

  template <bool kTube>
  void Row(int v, int step) {
    const int width = left_.cols;
    const int16_t* first = first_[v];
    for (int i = 0, u = step > 0 ? 0 : width - 1; i < width; ++i, u += step) {
      if (first[u] == StereoSearch::kNowhere) continue;
      const Before before[kDirections] = {
          Find(v, u, v, u - step, 0), Find(v, u, v - step, u - step, 1), Find(v, u, v - step, u, 2),
          Find(v, u, v - step, u + step, 3)};
      Pixel<kTube>(before,
                   static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u),
                   Slot(rows_[1], u, 0));
    }
  }

  // The start of a path when that pixel was not looked at.
  Before Find(int v, int u, int before_v, int before_u, size_t direction) {
    if (before_u < 0 || before_u >= left_.cols || before_v < 0 || before_v >= left_.rows ||
        first_(before_v, before_u) == StereoSearch::kNowhere) {
      return {start_.data() + kPadding, 0};
    }
    // Ranges that are farther apart have no disparity in common, either.
    const int shift =
        std::clamp(first_(v, u) - first_(before_v, before_u), -labels_ - 1, labels_ + 1);
    return {Slot(rows_[before_v == v ? 1 : 0], before_u, direction) + shift,
            LargeStep(std::abs(left_(v, u) - left_(before_v, before_u)))};
  }

  // One step of the four paths.
  // @param to  slots of the directions, one behind the other.
  template <bool kTube>
  void Pixel(const Before* before, size_t pixel, uint8_t* to) {
    const int labels = kTube ? kLanes : labels_;
    const size_t slot = kTube ? kLanes + 2 * kPadding : slot_;
    const uint8_t* costs = costs_.data() + pixel * static_cast<size_t>(labels);
    uint16_t* sums = sums_.data() + pixel * static_cast<size_t>(labels);
    Bytes least[kDirections];
    for (Bytes& lanes : least) lanes = Bytes{} + uint8_t{UINT8_MAX};
    for (int i = 0; i < labels; i += kLanes) {
      const Bytes cost = Load(costs + i);
      Bytes path[kDirections];
      for (size_t k = 0; k < kDirections; ++k) {
        const uint8_t* from = before[k].costs + i;
        const Bytes beside = Least(Load(from - 1), Load(from + 1)) + uint8_t{kSmallStep};
        const Bytes jump = Bytes{} + before[k].large_step;
        path[k] = Least(Least(Load(from), beside), jump) + cost;
        Store(path[k], to + k * slot + i);
        least[k] = Least(least[k], path[k]);
      }
      // Two path costs are still 8 bits.
      const Bytes one = path[0] + path[1];
      const Bytes other = path[2] + path[3];
      StoreWords(Widened<0>(one) + Widened<0>(other), sums + i);
      StoreWords(Widened<1>(one) + Widened<1>(other), sums + i + kWords);
    }
    for (size_t k = 0; k < kDirections; ++k) {
      const Bytes off = Bytes{} + LeastLane(least[k]);
      for (int i = 0; i < labels; i += kLanes) {
        uint8_t* costs_of = to + k * slot + i;
        Store(Load(costs_of) - off, costs_of);
      }
    }
  }

  const cv::Mat1b& left_;
  const cv::Mat1s& first_;
  int labels_;
  size_t slot_;
  const std::vector<uint8_t>& costs_;
  std::vector<uint16_t>& sums_;
  std::vector<uint8_t> start_;                // of a path: nothing is known
  std::array<std::vector<uint8_t>, 2> rows_;  // path costs of the row before and of this one
};

// A bit for each pixel of the 5×5 window but its centre: whether it is darker. Beyond the image its
// border goes on.
// @param mirrored  columns from right to left, so that the matches u − d of a pixel follow one
//                  another for increasing d.
// @param spare     more columns behind those, undefined.
void SemiGlobalMatcher::Census(const cv::Mat1b& image, bool mirrored, int spare,
                               CensusPlanes& planes) {
  constexpr int kWindow = 2 * kCensusRadius + 1;
  cv::copyMakeBorder(image, bordered_, kCensusRadius, kCensusRadius, kCensusRadius,
                     kCensusRadius + kLanes, cv::BORDER_REPLICATE);
  for (cv::Mat1b& plane : planes) plane.create(image.rows, image.cols + kLanes + spare);
  ForRangesParallel(image.rows, image.rows, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < image.cols; u += kLanes) {
        const Bytes centre = Load(bordered_[v + kCensusRadius] + u + kCensusRadius);
        Bytes bits[kPlanes] = {};
        for (int i = 0, plane_bit = 0; i < kWindow * kWindow; ++i) {
          if (i == kWindow * kWindow / 2) continue;
          const Bytes other = Load(bordered_[v + i / kWindow] + u + i % kWindow);
          Bytes& plane = bits[plane_bit++ / CHAR_BIT];
          plane = plane + plane + (other < centre ? Bytes{} + uint8_t{1} : Bytes{});
        }
        for (size_t k = 0; k < kPlanes; ++k) Store(bits[k], planes[k][v] + u);
      }
      if (!mirrored) continue;
      for (cv::Mat1b& plane : planes) std::reverse(plane[v], plane[v] + image.cols);
    }
  });
}

void SemiGlobalMatcher::FillCosts(const cv::Mat1b& left, const cv::Mat1b& right,
                                  const StereoSearch& search) {
  double largest_first = 0;
  cv::minMaxLoc(search.first, nullptr, &largest_first);
  const int labels = search.labels;
  Census(left, /*mirrored=*/false, 0, left_census_);
  Census(right, /*mirrored=*/true, static_cast<int>(largest_first) + labels, right_census_);
  costs_.resize(left.total() * static_cast<size_t>(labels));
  ForRangesParallel(left.rows, left.rows, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      uint8_t* costs = costs_.data() + static_cast<size_t>(v) * static_cast<size_t>(left.cols) *
                                           static_cast<size_t>(labels);
      for (int u = 0; u < left.cols; ++u, costs += labels) {
        if (search.first(v, u) != StereoSearch::kNowhere) FillPixel(search, v, u, costs);
      }
    }
  });
}

void SemiGlobalMatcher::FillPixel(const StereoSearch& search, int v, int u, uint8_t* costs) const {
  const int first = search.first(v, u);
  const int match = search.first.cols - 1 - u + first;
  for (int i = 0; i < search.labels; i += kLanes) {
    Bytes bits{};
    for (size_t k = 0; k < kPlanes; ++k) {
      const Bytes own = Bytes{} + left_census_[k](v, u);
      bits += CountOnes(own ^ Load(right_census_[k][v] + match + i));
    }
    Store(bits, costs + i);
  }
  const int inside = std::clamp(u - first + 1, 0, search.labels);
  std::fill(costs + inside, costs + search.labels, uint8_t{kOutside});
  const int known = search.known(v, u);
  if (known == StereoSearch::kNowhere) return;
  for (int i = 0; i < search.labels; ++i) {
    const int off = std::min(kMostKnown, kKnownPerPx * std::abs(first + i - known));
    costs[i] = static_cast<uint8_t>(costs[i] + off);
  }
}

// The best match of every pixel of a row, and whether it is unique and confirmed.
class SemiGlobalMatcher::RowChoice {
 public:
  RowChoice(const StereoSearch& search, int v)
      : first_(search.first[v]), width_(search.first.cols), labels_(search.labels) {
    const int most = *std::max_element(first_, first_ + width_) + labels_;
    const auto right_pixels = static_cast<size_t>(width_ + most);
    right_costs_.assign(right_pixels, kNoSum);
    right_best_.assign(right_pixels, 0);
    sums_.resize(static_cast<size_t>(labels_));
  }

  // @param down, up  sums of the sweeps for the row's pixels.
  void Choose(const uint16_t* down, const uint16_t* up, int16_t* best, float* confirmed_px) {
    for (int u = 0; u < width_; ++u, down += labels_, up += labels_) {
      best[u] = StereoSearch::kNowhere;
      confirmed_px[u] = kNone;
      if (first_[u] == StereoSearch::kNowhere) continue;
      const int label = Add(down, up, u);
      best[u] = static_cast<int16_t>(first_[u] + label);
      // On the end of the range the minimum may lie beyond.
      if (label == 0 || label == labels_ - 1 || best[u] > u || !IsUnique(label)) continue;
      confirmed_px[u] = static_cast<float>(best[u] + SubPixel(label));
    }
    for (int u = 0; u < width_; ++u) {
      if (std::isnan(confirmed_px[u])) continue;
      if (std::abs(right_best_[RightIndex(u, best[u])] - best[u]) > 1) confirmed_px[u] = kNone;
    }
  }

 private:
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  // Of the right pixel u − d: mirrored, so that a pixel's matches follow one another.
  size_t RightIndex(int u, int disparity) const {
    return static_cast<size_t>(width_ - 1 - u + disparity);
  }

  // Adds up a pixel's costs, enters them for the right pixels, and returns the least one's label.
  int Add(const uint16_t* down, const uint16_t* up, int u) {
    constexpr int kLaneBits = 3;  // a sum and its lane in one number
    static_assert((8 * (kBits + kMostKnown + kLargeStep) + 1) << kLaneBits <= UINT16_MAX);
    int least = INT_MAX;
    int label = 0;
    const int first = first_[u];
    for (int i = 0; i < labels_; i += kWords) {
      const Words sum = LoadWords(down + i) + LoadWords(up + i);
      StoreWords(sum, sums_.data() + i);
      const int key = LeastLane(sum << kLaneBits | kWord);
      if (key >> kLaneBits < least) {
        least = key >> kLaneBits;
        label = i + (key & (kWords - 1));
      }
      const size_t right = RightIndex(u, first + i);
      const Words before = LoadWords(right_costs_.data() + right);
      const auto better = sum < before;
      StoreWords(better ? sum : before, right_costs_.data() + right);
      const Words disparity = kWord + static_cast<uint16_t>(first + i);
      StoreWords(better ? disparity : LoadWords(right_best_.data() + right),
                 right_best_.data() + right);
    }
    return label;
  }

  // Whether the best beats all that are not beside it.
  bool IsUnique(int label) const {
    constexpr int kPercent = 15;
    Words least = Words{} + kNoSum;
    for (int i = 0; i < labels_; i += kWords) {
      // 0 to 2 for the best and those beside it.
      const Words from = kWord + static_cast<uint16_t>(i - label + 1);
      const Words sum = LoadWords(sums_.data() + i);
      least = Least(least, from > uint16_t{2} ? sum : Words{} + kNoSum);
    }
    return LeastLane(least) * (100 - kPercent) > sums_[static_cast<size_t>(label)] * 100;
  }

  // From a label to the minimum of the parabola through its cost and those beside it.
  double SubPixel(int label) const {
    const uint16_t* at = sums_.data() + label;
    const int curvature = at[-1] - 2 * at[0] + at[1];
    return curvature > 0 ? (at[-1] - at[1]) / (2.0 * curvature) : 0;
  }

  const int16_t* first_;
  int width_;
  int labels_;
  std::vector<uint16_t> right_costs_, right_best_;
  std::vector<uint16_t> sums_;
};

const StereoMatches& SemiGlobalMatcher::Match(const cv::Mat1b& left, const cv::Mat1b& right,
                                              const StereoSearch& search) {
  FillCosts(left, right, search);
  for (auto& sums : sums_) sums.resize(costs_.size());
  RunBoth([&] { Sweep(left, search, costs_, sums_[0]).Run(1); },
          [&] { Sweep(left, search, costs_, sums_[1]).Run(-1); });
  matches_.best.create(left.size());
  matches_.confirmed_px.create(left.size());
  ForRangesParallel(left.rows, left.rows, [&](const cv::Range& rows) {
    const size_t labels = static_cast<size_t>(left.cols) * static_cast<size_t>(search.labels);
    for (int v = rows.start; v < rows.end; ++v) {
      const size_t begin = static_cast<size_t>(v) * labels;
      RowChoice(search, v).Choose(sums_[0].data() + begin, sums_[1].data() + begin,
                                  matches_.best[v], matches_.confirmed_px[v]);
    }
  });
  return matches_;
}

}  // namespace sprout
