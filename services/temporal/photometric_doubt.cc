#include "services/temporal/photometric_doubt.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/core/parallel.h"
#include "services/temporal/image_pyramid.h"

namespace sprout::temporal {
namespace {

constexpr float kUnknown = -1;
constexpr int kBinsPerGrey = 8;

// Share of a window's standard deviation by which interpolated grey values may differ.
constexpr float kSpreadShare = 0.15F;

// Sums over the three rows of a window, of each column; one column more on either side.
struct ColumnSums {
  explicit ColumnSums(int width)
      : difference(size_t(width) + 2), known(difference), grey(difference), squares(difference) {}

  std::vector<float> difference, known, grey, squares;  // whole numbers but the first: exact
};

// Means of the differences that are known, and standard deviations of the grey values, over 3×3
// cells: 5×5 pixels. At the border the window is smaller.
void MeasureRow(const cv::Mat1b& grey, const cv::Mat1f& differences, int v, ColumnSums& columns,
                float* means, float* spreads) {
  const int width = differences.cols;
  const int top = std::max(v - 1, 0);
  const int bottom = std::min(v + 1, differences.rows - 1);
  float* const difference = columns.difference.data() + 1;
  float* const known = columns.known.data() + 1;
  float* const sum = columns.grey.data() + 1;
  float* const squares = columns.squares.data() + 1;
  for (int y = top; y <= bottom; ++y) {
    const float* const row = differences[y];
    const uint8_t* const values = grey[2 * y];
    const float keep = y == top ? 0 : 1;
    for (int u = 0; u < width; ++u) {
      const auto value = static_cast<float>(values[2 * u]);
      difference[u] = difference[u] * keep + std::max(row[u], 0.0F);
      known[u] = known[u] * keep + (row[u] >= 0 ? 1.0F : 0.0F);
      sum[u] = sum[u] * keep + value;
      squares[u] = squares[u] * keep + value * value;
    }
  }
  const auto rows = static_cast<float>(bottom - top + 1);
  for (int u = 0; u < width; ++u) {
    const float count = known[u - 1] + known[u] + known[u + 1];
    const float total = difference[u - 1] + difference[u] + difference[u + 1];
    means[u] = count > 0 ? total / std::max(count, 1.0F) : kUnknown;
    const float left = u > 0 ? 1 : 0;
    const float right = u + 1 < width ? 1 : 0;
    const float cells = rows * (left + 1 + right);
    const float greys = sum[u - 1] + sum[u] + sum[u + 1];
    const float variance = (squares[u - 1] + squares[u] + squares[u + 1] - greys * greys / cells);
    spreads[u] = std::sqrt(std::max(0.0F, variance) / cells);
  }
}

// The median of the means that are known; 0 if none is.
float MedianOf(const cv::Mat1f& means) {
  std::vector<int> bins(256 * kBinsPerGrey);
  int known = 0;
  for (int v = 0; v < means.rows; ++v) {
    const float* const row = means[v];
    for (int u = 0; u < means.cols; ++u) {
      if (row[u] < 0) continue;
      ++bins[static_cast<size_t>(row[u] * kBinsPerGrey)];
      ++known;
    }
  }
  size_t bin = 0;
  for (int below = 0; bin + 1 < bins.size() && below + bins[bin] <= known / 2; ++bin) {
    below += bins[bin];
  }
  return static_cast<float>(bin) / kBinsPerGrey;
}

}  // namespace

PhotometricDoubt::PhotometricDoubt(double doubt_grey, double drop_grey)
    : doubt_grey_(static_cast<float>(doubt_grey)), drop_grey_(static_cast<float>(drop_grey)) {
  // Computed by products, since exp() differs between machines.
  constexpr double kStep = 1.0644944589178593;  // exp(1 / kSteps)
  double growth = 1;
  for (size_t step = 0; step <= kMaxSteps; ++step) {
    growth_[step] = static_cast<float>(growth);
    growth *= kStep;
  }
  growth_.back() = 0;
}

void PhotometricDoubt::Compute(const cv::Mat1b& grey, const cv::Mat1f& differences,
                               cv::Mat1f& growth) {
  const cv::Size size = differences.size();
  Renew(means_, size);
  Renew(spreads_, size);
  Renew(growth, size);
  const int parts = size.height / kRowsPerPart + 1;
  ForRangesParallel(size.height, parts, [&](const cv::Range& rows) {
    ColumnSums columns(size.width);
    for (int v = rows.start; v < rows.end; ++v) {
      MeasureRow(grey, differences, v, columns, means_[v], spreads_[v]);
    }
  });
  // The difference that the whole image shares is noise, or light that changed.
  const float usual = std::max(1.0F, MedianOf(means_));
  const float steps_per_grey = kSteps / doubt_grey_;
  ForRangesParallel(size.height, parts, [&](const cv::Range& rows) {
    std::vector<int32_t> steps(static_cast<size_t>(size.width));
    for (int v = rows.start; v < rows.end; ++v) {
      const float* const means = means_[v];
      const float* const spreads = spreads_[v];
      float* const to = growth[v];
      for (int u = 0; u < size.width; ++u) {
        const float excess = means[u] - usual - kSpreadShare * spreads[u];
        const float of_grey = std::min(std::max(excess * steps_per_grey, 0.0F), float{kMaxSteps});
        const bool drop = (means[u] < 0) | (means[u] > drop_grey_);
        steps[static_cast<size_t>(u)] = drop ? kMaxSteps + 1 : static_cast<int32_t>(of_grey);
      }
      for (int u = 0; u < size.width; ++u) {
        to[u] = growth_[static_cast<size_t>(steps[static_cast<size_t>(u)])];
      }
    }
  });
}

}  // namespace sprout::temporal
