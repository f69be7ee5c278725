#include "services/grow/gap_filler.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "services/grow/parallel.h"

namespace sprout {
namespace {

constexpr int kRadius = 2;
constexpr int kWindow = 2 * kRadius + 1;

cv::Rect WindowAt(cv::Point pixel, cv::Size size) {
  return cv::Rect(pixel.x - kRadius, pixel.y - kRadius, kWindow, kWindow) & cv::Rect({}, size);
}

// Median of the valid counts around a pixel; kInvalid when there are none.
int16_t MedianAround(const DisparityImage& map, cv::Point pixel) {
  std::array<int16_t, kWindow * kWindow + 1> counts;  // one behind the last may be written
  const cv::Rect window = WindowAt(pixel, map.size());
  auto end = counts.begin();
  for (int v = window.y; v < window.br().y; ++v) {
    const int16_t* row = map.counts()[v];
    for (int u = window.x; u < window.br().x; ++u) {
      *end = row[u];  // no branch: whether a neighbour is valid cannot be predicted
      end += row[u] != DisparityImage::kInvalid ? 1 : 0;
    }
  }
  if (end == counts.begin()) return DisparityImage::kInvalid;
  const auto [lowest, highest] = std::minmax_element(counts.begin(), end);
  if (*lowest == *highest) return *lowest;
  const auto median = counts.begin() + (end - counts.begin() - 1) / 2;
  std::nth_element(counts.begin(), median, end);
  return *median;
}

// Gaps that have a valid pixel in their window.
std::vector<cv::Point> FillableGaps(const DisparityImage& map) {
  cv::Mat1b valid;
  cv::compare(map.counts(), DisparityImage::kInvalid, valid, cv::CMP_NE);
  cv::Mat1b near_valid;
  cv::dilate(valid, near_valid, cv::Mat1b::ones(kWindow, kWindow));
  std::vector<cv::Point> gaps;
  for (int v = 0; v < map.height(); ++v) {
    for (int u = 0; u < map.width(); ++u) {
      if (!valid(v, u) && near_valid(v, u)) gaps.emplace_back(u, v);
    }
  }
  return gaps;
}

// Gaps that the pixels filled last have made fillable, each once.
std::vector<cv::Point> GapsAround(const std::vector<cv::Point>& filled, const DisparityImage& map,
                                  cv::Mat1b& listed) {
  std::vector<cv::Point> gaps;
  for (const cv::Point& pixel : filled) {
    const cv::Rect window = WindowAt(pixel, map.size());
    for (int v = window.y; v < window.br().y; ++v) {
      for (int u = window.x; u < window.br().x; ++u) {
        if (map.IsValid(u, v) || listed(v, u)) continue;
        listed(v, u) = 1;
        gaps.emplace_back(u, v);
      }
    }
  }
  return gaps;
}

// One pass: every gap in the list looks at the map as it was before.
void FillPass(const std::vector<cv::Point>& gaps, DisparityImage& map) {
  std::vector<int16_t> medians;
  medians.reserve(gaps.size());
  for (const cv::Point& gap : gaps) medians.push_back(MedianAround(map, gap));
  for (size_t i = 0; i < gaps.size(); ++i) map.counts()(gaps[i]) = medians[i];
}

// Further passes, until nothing changes.
void FillOn(DisparityImage& map) {
  cv::Mat1b listed(map.size(), uint8_t{0});
  for (std::vector<cv::Point> gaps = FillableGaps(map); !gaps.empty();
       gaps = GapsAround(gaps, map, listed)) {
    FillPass(gaps, map);
  }
}

// Rows of a map, gaps with the prior's disparity where it has the map's size.
void CopyFilled(const DisparityImage& map, const DisparityImage& prior, cv::Range rows,
                cv::Mat1s& filled) {
  filled.create(rows.size(), map.width());
  for (int v = rows.start; v < rows.end; ++v) {
    const int16_t* from = map.counts()[v];
    const int16_t* instead = prior.size() == map.size() ? prior.counts()[v] : from;
    int16_t* to = filled[v - rows.start];
    for (int u = 0; u < map.width(); ++u) {
      to[u] = from[u] != DisparityImage::kInvalid ? from[u] : instead[u];
    }
  }
}

}  // namespace

DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior) {
  return GapFiller().Fill(map, fill, prior);
}

DisparityImage GapFiller::Fill(const DisparityImage& map, GrowConfig::Fill fill,
                               const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  Renew(result_, map.size());
  switch (fill) {
    case GrowConfig::PRIOR:
      FillFromPrior(map, prior);
      break;
    case GrowConfig::ONE_PASS:
      FillOnce(map);
      break;
    default:
      FillOnce(map);
      FillOn(result_);
  }
  return result_;
}

void GapFiller::FillOnce(const DisparityImage& map) {
  ForEachParallel(static_cast<size_t>(map.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    const int16_t* from = map.counts()[v];
    int16_t* to = result_.counts()[v];
    for (int u = 0; u < map.width(); ++u) {
      to[u] = from[u] != DisparityImage::kInvalid ? from[u] : MedianAround(map, {u, v});
    }
  });
}

// Bands of rows with the window's margin, so that each can be filled and smoothed for itself.
void GapFiller::FillFromPrior(const DisparityImage& map, const DisparityImage& prior) {
  constexpr int kRows = 64;
  const int height = map.height();
  bands_.resize(static_cast<size_t>((height + kRows - 1) / kRows));
  ForEachParallel(bands_.size(), [&](size_t i) {
    Band& band = bands_[i];
    const int first = static_cast<int>(i) * kRows;
    const int end = std::min(first + kRows, height);
    const cv::Range with_margin(std::max(first - kRadius, 0), std::min(end + kRadius, height));
    CopyFilled(map, prior, with_margin, band.filled);
    cv::medianBlur(band.filled, band.smooth, kWindow);
    for (int v = first; v < end; ++v) {
      const int16_t* from = band.smooth[v - with_margin.start];
      std::copy(from, from + map.width(), result_.counts()[v]);
    }
  });
}

}  // namespace sprout
