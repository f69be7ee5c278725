#include "services/temporal/photometric_doubt.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/core/parallel.h"

namespace sprout::temporal {
namespace {

constexpr float kUnknown = -1;
constexpr int kRowsPerPart = 16;
constexpr int kBinsPerGrey = 8;

// Share of a window's contrast that sampling between pixels explains.
constexpr float kSpreadShare = 0.15F;

// Sums over the three rows of a window, of one column.
struct ColumnSums {
  float difference = 0;
  int known = 0;
  int grey = 0;
  int squares = 0;
};

// Means of the differences that are known, and standard deviations of the grey values, over 3×3
// cells: 5×5 pixels. At the border the window is smaller.
void MeasureRow(const cv::Mat1b& grey, const cv::Mat1f& differences, int v,
                std::vector<ColumnSums>& columns, float* means, float* spreads) {
  const int width = differences.cols;
  const int top = std::max(v - 1, 0);
  const int bottom = std::min(v + 1, differences.rows - 1);
  std::fill(columns.begin(), columns.end(), ColumnSums());
  for (int y = top; y <= bottom; ++y) {
    const float* const row = differences[y];
    const uint8_t* const values = grey[2 * y];
    for (int u = 0; u < width; ++u) {
      ColumnSums& sums = columns[static_cast<size_t>(u) + 1];
      const bool known = row[u] >= 0;
      sums.difference += known ? row[u] : 0;
      sums.known += known ? 1 : 0;
      sums.grey += values[2 * u];
      sums.squares += values[2 * u] * values[2 * u];
    }
  }
  for (int u = 0; u < width; ++u) {
    const ColumnSums* const at = &columns[static_cast<size_t>(u)];  // one to the left
    const int known = at[0].known + at[1].known + at[2].known;
    const float difference = at[0].difference + at[1].difference + at[2].difference;
    means[u] = known > 0 ? difference / static_cast<float>(known) : kUnknown;
    const int cells = (bottom - top + 1) * (std::min(u + 1, width - 1) - std::max(u - 1, 0) + 1);
    const auto count = static_cast<float>(cells);
    const auto sum = static_cast<float>(at[0].grey + at[1].grey + at[2].grey);
    const auto squares = static_cast<float>(at[0].squares + at[1].squares + at[2].squares);
    spreads[u] = std::sqrt(std::max(0.0F, squares - sum * sum / count) / count);
  }
}

// The median of the means that are known, or of none 0.
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
  // By products, since exp() differs between machines.
  constexpr double kStep = 1.0644944589178593;  // exp(1 / kSteps)
  double growth = 1;
  for (float& value : growth_) {
    value = static_cast<float>(growth);
    growth *= kStep;
  }
}

float PhotometricDoubt::Growth(float excess_grey) const {
  const float steps = std::min(excess_grey / doubt_grey_, float{kMostFolds}) * kSteps;
  return growth_[static_cast<size_t>(std::max(steps, 0.0F))];
}

void PhotometricDoubt::Compute(const cv::Mat1b& grey, const cv::Mat1f& differences,
                               cv::Mat1f& growth) {
  const cv::Size size = differences.size();
  Renew(means_, size);
  Renew(spreads_, size);
  Renew(growth, size);
  const int parts = size.height / kRowsPerPart + 1;
  ForRangesParallel(size.height, parts, [&](const cv::Range& rows) {
    std::vector<ColumnSums> columns(static_cast<size_t>(size.width) + 2);
    for (int v = rows.start; v < rows.end; ++v) {
      MeasureRow(grey, differences, v, columns, means_[v], spreads_[v]);
    }
  });
  // What all of the image shares is noise, or light that changed.
  const float usual = std::max(1.0F, MedianOf(means_));
  ForRangesParallel(size.height, parts, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const float mean = means_(v, u);
        const bool drop = mean < 0 || mean > drop_grey_;
        growth(v, u) = drop ? 0 : Growth(mean - usual - kSpreadShare * spreads_(v, u));
      }
    }
  });
}

}  // namespace sprout::temporal
