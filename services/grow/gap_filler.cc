#include "services/grow/gap_filler.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace sprout {
namespace {

constexpr int kRadius = 2;
constexpr int kWindow = 2 * kRadius + 1;

cv::Rect WindowAt(cv::Point pixel, cv::Size size) {
  return cv::Rect(pixel.x - kRadius, pixel.y - kRadius, kWindow, kWindow) & cv::Rect({}, size);
}

// Median of the valid counts around a pixel; kInvalid when there are none.
int16_t MedianAround(const DisparityImage& map, cv::Point pixel) {
  std::array<int16_t, kWindow * kWindow> counts;
  const cv::Rect window = WindowAt(pixel, map.size());
  auto end = counts.begin();
  for (int v = window.y; v < window.br().y; ++v) {
    const int16_t* row = map.counts()[v];
    for (int u = window.x; u < window.br().x; ++u) {
      if (row[u] != DisparityImage::kInvalid) *end++ = row[u];
    }
  }
  if (end == counts.begin()) return DisparityImage::kInvalid;
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

DisparityImage FillFromPrior(const DisparityImage& map, const DisparityImage& prior) {
  cv::Mat1s filled = map.counts().clone();
  if (prior.size() == map.size()) prior.counts().copyTo(filled, filled == DisparityImage::kInvalid);
  cv::Mat1s smooth;
  cv::medianBlur(filled, smooth, kWindow);
  return DisparityImage(smooth);
}

}  // namespace

DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  if (fill == GrowConfig::PRIOR) return FillFromPrior(map, prior);
  DisparityImage filled{map.counts().clone()};
  std::vector<cv::Point> gaps = FillableGaps(map);
  FillPass(gaps, filled);
  if (fill == GrowConfig::ONE_PASS) return filled;
  cv::Mat1b listed(map.size(), uint8_t{0});
  while (!gaps.empty()) {
    gaps = GapsAround(gaps, filled, listed);
    FillPass(gaps, filled);
  }
  return filled;
}

}  // namespace sprout
