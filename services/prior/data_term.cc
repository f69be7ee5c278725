// The data term of the two labels of a pixel beside a depth edge, and the decision between them.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "common/core/parallel.h"
#include "services/prior/edge_surfaces.h"

namespace sprout::prior {
namespace {

constexpr int kRadius = 1;        // of the window of grey differences, px: sharp at edges
constexpr int kCensusRadius = 3;  // of that of the census; a row of it fits into 64 bits
constexpr int kWindow = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr int kCensusSide = 2 * kCensusRadius + 1;
constexpr int kCensusWindow = kCensusSide * kCensusSide;
constexpr int kUnlikeBits =
    4;  // codes of pixels that have nothing in common differ in half their 8

// Counts to whole pixels.
int Rounded(int counts) {
  constexpr int kOne = DisparityImage::kCountsPerPixel;
  return (counts + kOne / 2) / kOne;
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

// The build asks the compiler to make vectors of this loop: 1 ms for a pair of 2 MP instead of 9.
void TransformRow(const uint8_t* above, const uint8_t* row, const uint8_t* below, int columns,
                  uint8_t* codes) {
  for (int u = 1; u < columns - 1; ++u) {
    const uint8_t centre = row[u];
    const auto bit = [centre](uint8_t other, uint8_t value) -> uint8_t {
      return other < centre ? value : 0;
    };
    codes[u] = static_cast<uint8_t>(
        bit(above[u - 1], 128) | bit(above[u], 64) | bit(above[u + 1], 32) | bit(row[u - 1], 16) |
        bit(row[u + 1], 8) | bit(below[u - 1], 4) | bit(below[u], 2) | bit(below[u + 1], 1));
  }
}

}  // namespace

void CensusTransform(const cv::Mat1b& image, cv::Mat1b& codes) {
  codes.create(image.size());
  const int last = image.rows - 1;
  ForRangesParallel(image.rows, 4 * cv::getNumThreads(), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      std::fill_n(codes[v], image.cols, uint8_t{0});
      if (v == 0 || v == last) continue;
      TransformRow(image[v - 1], image[v], image[v + 1], image.cols, codes[v]);
    }
  });
}

DataTerm::DataTerm(const EdgeImages& images, std::span<const EdgeTriangle> edges,
                   std::span<const Plane> planes, const PriorConfig& config)
    : images_(images), config_(config), nearby_(edges.size()) {
  ForEachParallel(edges.size(), [&](size_t i) { nearby_[i] = Gather(edges[i].nearby(), planes); });
}

ColourSeeds DataTerm::Gather(std::span<const int> seeds, std::span<const Plane> planes) const {
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  constexpr float kNoColour = 1e6;  // of lanes without a seed: nothing is like it
  const auto padded = [&](size_t to) { return (seeds.size() + to - 1) / to * to; };
  ColourSeeds nearby;
  nearby.count = padded(4);
  for (size_t i = 0; i < padded(ColourSeeds::kAtOnce); ++i) {
    const Plane& plane = planes[static_cast<size_t>(seeds[std::min(i, seeds.size() - 1)])];
    nearby.u[i] = plane.u;
    nearby.v[i] = plane.v;
    nearby.counts[i] = kOne * plane.disparity;
    nearby.per_column[i] = kOne * plane.per_column;
    nearby.per_row[i] = kOne * plane.per_row;
    const cv::Mat3b& image = images_.left_bgr;
    const int u = cvRound(std::clamp(plane.u, 0.F, static_cast<float>(image.cols - 1)));
    const int v = cvRound(std::clamp(plane.v, 0.F, static_cast<float>(image.rows - 1)));
    const cv::Vec3b& bgr = image(v, u);
    nearby.blue[i] = i < seeds.size() ? bgr[0] : kNoColour;
    nearby.green[i] = bgr[1];
    nearby.red[i] = bgr[2];
  }
  return nearby;
}

double DataTerm::FarMinusNear(int u, int v, int triangle, int near, int far) const {
  return Images(u, v, near, far) +
         config_.colour_weight() * Colours(u, v, nearby_[static_cast<size_t>(triangle)], near, far);
}

// Eq. (P6): C_grey and C_census. Both are equal for near and far where a window leaves an image.
double DataTerm::Images(int u, int v, int near, int far) const {
  const int near_px = Rounded(near);
  const int far_px = Rounded(far);
  const cv::Mat1b &left_grey = images_.left_grey, &right_grey = images_.right_grey;
  if (u - near_px < kCensusRadius || u + kCensusRadius >= left_grey.cols || v < kCensusRadius ||
      v + kCensusRadius >= left_grey.rows) {
    return 0;
  }
  const int truncation = config_.grey_truncation();
  int grey = 0;
  for (int y = v - kRadius; y <= v + kRadius; ++y) {
    const uint8_t* const left = left_grey[y] + u;
    const uint8_t* const at_near = right_grey[y] + u - near_px;
    const uint8_t* const at_far = right_grey[y] + u - far_px;
    for (int x = -kRadius; x <= kRadius; ++x) {
      grey += std::min(std::abs(left[x] - at_far[x]), truncation) -
              std::min(std::abs(left[x] - at_near[x]), truncation);
    }
  }
  const CensusWindow left = ReadCensus(images_.left_census, u, v);
  const int bits = HammingDistance(left, ReadCensus(images_.right_census, u - far_px, v)) -
                   HammingDistance(left, ReadCensus(images_.right_census, u - near_px, v));
  return static_cast<double>(grey) / (kWindow * truncation) +
         config_.census_weight() * bits / (kCensusWindow * kUnlikeBits);
}

// Eq. (P7).
double DataTerm::Colours(int u, int v, const ColourSeeds& seeds, int near, int far) const {
  const cv::Vec3f bgr = images_.left_bgr(v, u);
  return ColourTerm(
      seeds,
      {.u = static_cast<float>(u),
       .v = static_cast<float>(v),
       .blue = bgr[0],
       .green = bgr[1],
       .red = bgr[2],
       .middle = 0.5F * static_cast<float>(near + far),
       .half_gap = 0.5F * static_cast<float>(near - far),
       .per_miss = static_cast<float>(1 / (DisparityImage::kCountsPerPixel * config_.edge_px())),
       .per_range = static_cast<float>(1 / config_.colour_range())});
}

namespace {

// Decides every other pixel of every other row; then, in a second pass, the others.
class Decision {
 public:
  Decision(const EdgeLabels& labels, const DataTerm& data_term, cv::Mat1s& prior)
      : labels_(labels), data_term_(data_term), prior_(prior) {}

  void DecideRow(int v, bool second_pass) {
    const bool even_row = v % 2 == 0;
    const int first = second_pass && even_row ? 1 : 0;
    const int16_t* const labels = labels_.near[v];
    for (int u = first; u < prior_.cols; u += even_row ? 2 : 1) {
      while (u + 8 <= prior_.cols && NoneOfEight(labels + u)) u += 8;
      if (u >= prior_.cols) break;
      const int16_t near = labels[u];
      if (near == DisparityImage::kInvalid) continue;
      const int16_t far = labels_.far(v, u);
      const std::optional<bool> as_neighbours =
          second_pass ? AreNear(u, v, near + far) : std::nullopt;
      const bool is_near =
          as_neighbours.value_or(false) ||
          (!as_neighbours && data_term_.FarMinusNear(u, v, labels_.triangle(v, u), near, far) > 0);
      prior_(v, u) = is_near ? near : far;
    }
  }

 private:
  // Whether eight columns have no labels, as most have none.
  static bool NoneOfEight(const int16_t* labels) {
    constexpr uint64_t kFourInvalid = 0x8000'8000'8000'8000;
    static_assert(DisparityImage::kInvalid == INT16_MIN);
    std::array<uint64_t, 2> columns;
    std::memcpy(columns.data(), labels, sizeof(columns));
    return columns[0] == kFourInvalid && columns[1] == kFourInvalid;
  }

  // Whether the decided pixels around are all closer to the near surface, or all to the far one:
  // two in an even row or column, otherwise four. Nothing when they do not agree, or when one is
  // not in the image.
  std::optional<bool> AreNear(int u, int v, int near_plus_far) const {
    const int left = u - u % 2;
    const int right = u + u % 2;
    const int above = v - v % 2;
    const int below = v + v % 2;
    if (right >= prior_.cols || below >= prior_.rows) return std::nullopt;
    const auto is_near = [&](int y, int x) { return 2 * prior_(y, x) > near_plus_far; };
    const bool near = is_near(above, left);
    if (is_near(above, right) != near || is_near(below, left) != near ||
        is_near(below, right) != near) {
      return std::nullopt;
    }
    return near;
  }

  const EdgeLabels& labels_;
  const DataTerm& data_term_;
  cv::Mat1s& prior_;
};

}  // namespace

void DecideLabels(const EdgeLabels& labels, const DataTerm& data_term, DisparityImage& prior) {
  Decision decision(labels, data_term, prior.counts());
  const auto decide = [&](int rows, int step, bool second_pass) {
    // Reads only what the first pass has decided: the order of the rows does not matter.
    ForRangesParallel(rows, rows, [&](const cv::Range& part) {
      for (int i = part.start; i < part.end; ++i) decision.DecideRow(i * step, second_pass);
    });
  };
  decide((prior.height() + 1) / 2, 2, false);
  decide(prior.height(), 1, true);
}

}  // namespace sprout::prior
