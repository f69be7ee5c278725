#include "common/measure/frame_quality.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/core/image.h"
#include "common/core/tof_coverage.h"

namespace sprout {
namespace {

constexpr int kWindow = 5;    // side, px
constexpr int kBandRows = 8;  // of a sample
constexpr double kNoise = 2;  // s of (Q1), grey levels

// The right image as the left camera would see it, and where that is known.
struct Warped {
  cv::Mat1b right;
  cv::Mat1f known;  // 1 or 0
};

Warped Warp(const cv::Mat1b& right, const DisparityImage& disparity) {
  cv::Mat1f columns(disparity.size(), -1.0F);
  cv::Mat1f rows(disparity.size());
  Warped warped{.right = {}, .known = cv::Mat1f(disparity.size(), 0.0F)};
  for (int v = 0; v < columns.rows; ++v) {
    for (int u = 0; u < columns.cols; ++u) {
      rows(v, u) = static_cast<float>(v);
      const float column = static_cast<float>(u) - disparity.Px(u, v);  // NaN without a disparity
      if (!(column >= 0 && column <= static_cast<float>(right.cols - 1))) continue;
      columns(v, u) = column;
      warped.known(v, u) = 1;
    }
  }
  cv::remap(right, warped.right, columns, rows, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return warped;
}

// Sums over a window of the products of two pictures.
cv::Mat1f WindowSum(const cv::Mat1f& one, const cv::Mat1f& other) {
  cv::Mat1f sum;
  cv::boxFilter(one.mul(other), sum, CV_32F, {kWindow, kWindow}, {-1, -1}, /*normalize=*/false,
                cv::BORDER_CONSTANT);
  return sum;
}

// Covariance times the square of the count, from sums over a window.
double Moment(double count, double product, double one, double other) {
  return count * product - one * other;
}

// One of `one_in` bands of rows, one below the other. No window sees two of them, since the rows
// between have no disparity.
std::optional<double> SampledMisfit(const Frame& frame, int one_in) {
  const int rows = frame.disparity->height();
  const int step = kBandRows * one_in;
  if (one_in == 1 || rows < step) {
    return Misfit(ToGrey(frame.left), ToGrey(frame.right), *frame.disparity);
  }
  std::array<std::vector<cv::Mat>, 3> stacks;
  const std::array<cv::Mat, 3> maps = {frame.left, frame.right, frame.disparity->counts()};
  const cv::Mat no_disparity(kWindow / 2, frame.disparity->width(), CV_16SC1,
                             cv::Scalar(DisparityImage::kInvalid));
  for (int v = step / 2; v + kBandRows <= rows; v += step) {
    for (size_t i = 0; i < maps.size(); ++i) {
      stacks[i].push_back(maps[i].rowRange(v, v + kBandRows));
      stacks[i].push_back(i == 2 ? no_disparity : maps[i].rowRange(0, kWindow / 2));
    }
  }
  std::array<cv::Mat, 3> bands;
  for (size_t i = 0; i < maps.size(); ++i) cv::vconcat(stacks[i], bands[i]);
  return Misfit(ToGrey(bands[0]), ToGrey(bands[1]), DisparityImage(cv::Mat1s(bands[2])));
}

std::optional<double> MeanConfidence(const cv::Mat1b& confidence, const DisparityImage& disparity) {
  const cv::Mat valid = disparity.counts() != DisparityImage::kInvalid;
  if (cv::countNonZero(valid) == 0) return std::nullopt;
  return cv::mean(confidence, valid)[0] / 255;
}

void AddMap(const Frame& frame, int misfit_one_in, FrameQuality& quality) {
  const DisparityImage& disparity = *frame.disparity;
  quality.valid_share =
      static_cast<double>(disparity.CountValid()) / static_cast<double>(disparity.counts().total());
  if (frame.confidence.type() == CV_8UC1 && frame.confidence.size() == disparity.size()) {
    quality.confidence = MeanConfidence(frame.confidence, disparity);
  }
  if (frame.left.size() == disparity.size() && frame.right.size() == disparity.size()) {
    quality.misfit = SampledMisfit(frame, misfit_one_in);
  }
}

void AddSeeds(const Frame& frame, FrameQuality& quality) {
  const SeedSet& seeds = *frame.seeds;
  quality.seeds = std::ssize(seeds.seeds);
  if (seeds.raw > 0)
    quality.seeds_kept = CountTofSeeds(seeds.seeds) / static_cast<double>(seeds.raw);
  if (const auto size = ImageSize(frame)) {
    quality.tof_coverage = TofCoverage(seeds.seeds, *size);
  }
}

constexpr auto kColumns = std::to_array<QualityColumn>({
    {"score", "valid_share * confidence * (1 - misfit), 1 is best", true, 3,
     [](const FrameQuality& quality) { return quality.score(); }},
    {"valid_share", "share of the pixels with a disparity", true, 3,
     [](const FrameQuality& quality) { return quality.valid_share; }},
    {"confidence", "mean confidence of the pixels with a disparity, 1 is certain", true, 3,
     [](const FrameQuality& quality) { return quality.confidence; }},
    {"misfit", "how badly the images match with the disparities: 0 perfectly, 0.5 not at all",
     false, 3, [](const FrameQuality& quality) { return quality.misfit; }},
    {"seeds", "seeds of the ToF camera and of stereo", true, 0,
     [](const FrameQuality& quality) {
       return quality.seeds ? std::optional(static_cast<double>(*quality.seeds)) : std::nullopt;
     }},
    {"seeds_kept", "share of the ToF points that refinement kept", true, 3,
     [](const FrameQuality& quality) { return quality.seeds_kept; }},
    {"tof_coverage", "share of the left image that ToF seeds cover", true, 3,
     [](const FrameQuality& quality) { return quality.tof_coverage; }},
});

}  // namespace

std::optional<double> FrameQuality::score() const {
  if (!valid_share) return std::nullopt;
  return *valid_share * confidence.value_or(1) * (1 - misfit.value_or(0));  // (Q2)
}

FrameQuality QualityOf(const Frame& frame, int misfit_one_in) {
  FrameQuality quality;
  if (frame.disparity && !frame.disparity->empty()) AddMap(frame, misfit_one_in, quality);
  if (frame.seeds) AddSeeds(frame, quality);
  return quality;
}

std::optional<double> Misfit(const cv::Mat1b& left, const cv::Mat1b& right,
                             const DisparityImage& disparity) {
  const Warped warped = Warp(right, disparity);
  // All sums are whole numbers below 2^24, so floats are exact.
  const cv::Mat1f& known = warped.known;
  cv::Mat1f grey_left;
  cv::Mat1f grey_right;
  cv::multiply(left, known, grey_left, 1, CV_32F);
  cv::multiply(warped.right, known, grey_right, 1, CV_32F);
  const cv::Mat1f count = WindowSum(known, known);
  const cv::Mat1f sum_left = WindowSum(grey_left, known);
  const cv::Mat1f sum_right = WindowSum(grey_right, known);
  const cv::Mat1f sum_left_left = WindowSum(grey_left, grey_left);
  const cv::Mat1f sum_right_right = WindowSum(grey_right, grey_right);
  const cv::Mat1f sum_left_right = WindowSum(grey_left, grey_right);

  double sum = 0;
  int64_t pixels = 0;
  for (int v = 0; v < count.rows; ++v) {
    for (int u = 0; u < count.cols; ++u) {
      if (known(v, u) == 0) continue;
      const double n = count(v, u);
      const double l = sum_left(v, u);
      const double r = sum_right(v, u);
      const double contrast =
          std::sqrt(Moment(n, sum_left_left(v, u), l, l) * Moment(n, sum_right_right(v, u), r, r));
      const double covariance = Moment(n, sum_left_right(v, u), l, r);
      sum += 0.5 * (contrast - covariance) / (contrast + kNoise * kNoise * n * n);  // (Q1)
      ++pixels;
    }
  }
  if (pixels == 0) return std::nullopt;
  return sum / static_cast<double>(pixels);
}

std::span<const QualityColumn> QualityColumns() { return kColumns; }

const QualityColumn* FindQualityColumn(std::string_view name) {
  const auto column = std::ranges::find(kColumns, name, &QualityColumn::name);
  return column == kColumns.end() ? nullptr : &*column;
}

std::string QualityText(const QualityColumn& column, const FrameQuality& quality) {
  const std::optional<double> value = column.value(quality);
  return value ? fmt::format("{:.{}f}", *value, column.decimals) : "-";
}

std::string QualityCsvHead() {
  std::string cells;
  for (const QualityColumn& column : kColumns) cells += fmt::format(",{}", column.name);
  return cells;
}

std::string QualityCsvCells(const FrameQuality& quality) {
  std::string cells;
  for (const QualityColumn& column : kColumns) {
    const std::optional<double> value = column.value(quality);
    cells += value ? fmt::format(",{}", *value) : ",";
  }
  return cells;
}

size_t CountKnown(const FrameQuality& quality) {
  return static_cast<size_t>(std::ranges::count_if(
      kColumns, [&](const QualityColumn& column) { return column.value(quality).has_value(); }));
}

}  // namespace sprout
