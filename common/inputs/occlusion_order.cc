#include "common/inputs/occlusion_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "common/core/image.h"

namespace sprout::inputs {
namespace {

struct OrderRules {
  static constexpr double kMaxPixels = 200e3;  ///< of the level that is matched
  static constexpr int kMarginPx = 8;          ///< searched beyond the disparities that are known
  static constexpr float kMinStepPx = 3;       ///< of disparity at an edge
  static constexpr float kSteadyPx = 2;        ///< spread of disparity beside it
  static constexpr int kSteadyColumns = 6;
  static constexpr int kAround = 4;        ///< columns on either side of a strip
  static constexpr double kContrast = 6;   ///< grey levels between its two sides
  static constexpr int kRowsOfAnEdge = 8;  ///< rows that count as one observation
};

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// Disparities of `left`, NaN where there is none.
cv::Mat1f Disparities(const cv::Mat1b& left, const cv::Mat1b& right, int least, int count) {
  const int border = std::max(std::abs(least), std::abs(least + count)) + 8;
  const auto widened = [&](const cv::Mat1b& image) {
    cv::Mat1b wide;
    cv::copyMakeBorder(image, wide, 0, 0, border, border, cv::BORDER_REPLICATE);
    return wide;
  };
  constexpr int kBlock = 5;
  const auto matcher =
      cv::StereoSGBM::create(least, count, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock, 0, 0,
                             10, 0, 0, cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat1s sixteenths;
  matcher->compute(widened(left), widened(right), sixteenths);
  cv::Mat1f disparities;
  sixteenths.colRange(border, border + left.cols).convertTo(disparities, CV_32F, 1.0 / 16);
  disparities.setTo(kNone, disparities < least);
  return disparities;
}

// The image with the brightness and contrast of the other one, since matches compare grey values.
cv::Mat1b Alike(const cv::Mat1b& image, const cv::Mat1b& other) {
  cv::Scalar mean, sigma, other_mean, other_sigma;
  cv::meanStdDev(image, mean, sigma);
  cv::meanStdDev(other, other_mean, other_sigma);
  const double gain = other_sigma[0] / std::max(1.0, sigma[0]);
  cv::Mat1b alike;
  image.convertTo(alike, CV_8U, gain, other_mean[0] - gain * mean[0]);
  return alike;
}

cv::Mat1b Mirrored(const cv::Mat1b& image) {
  cv::Mat1b mirrored;
  cv::flip(image, mirrored, 1);
  return mirrored;
}

struct View {
  cv::Mat1b image;
  cv::Mat1f disparity;  // where both images agree to a pixel; else NaN
};

View Agreed(const cv::Mat1b& image, const cv::Mat1f& own, const cv::Mat1f& of_other) {
  View view = {image, own.clone()};
  for (int v = 0; v < own.rows; ++v) {
    for (int u = 0; u < own.cols; ++u) {
      float& d = view.disparity(v, u);
      if (std::isnan(d)) continue;
      // The other map is mirrored.
      const int other = own.cols - 1 - static_cast<int>(std::lround(static_cast<float>(u) - d));
      if (other < 0 || other >= own.cols || !(std::abs(of_other(v, other) - d) <= 1)) d = kNone;
    }
  }
  return view;
}

bool IsSteady(const float* begin) {
  int known = 0;
  float least = std::numeric_limits<float>::max(), most = std::numeric_limits<float>::lowest();
  for (int i = 0; i < OrderRules::kSteadyColumns; ++i) {
    if (std::isnan(begin[i])) continue;
    ++known;
    least = std::min(least, begin[i]);
    most = std::max(most, begin[i]);
  }
  return known >= OrderRules::kSteadyColumns - 1 && most - least <= OrderRules::kSteadyPx;
}

// Where brightness changes most between two columns: the two parts with the least variance in
// themselves (Otsu's criterion). Nothing where they are too alike.
std::optional<double> ChangeIn(const std::vector<double>& row, int begin, int end) {
  const int count = end - begin;
  double all = 0;
  for (int u = begin; u < end; ++u) all += row[static_cast<size_t>(u)];
  double before = 0, best = 0;
  std::optional<double> place;
  for (int k = 1; k < count - 2; ++k) {
    before += row[static_cast<size_t>(begin + k - 1)];
    if (k < 3) continue;
    const double step = before / k - (all - before) / (count - k);
    const double between = step * step * k * (count - k) / count;
    if (between > best) {
      best = between;
      place = begin + k - 0.5;
    }
  }
  const bool clear = best >= OrderRules::kContrast * OrderRules::kContrast * count / 6;
  return clear ? place : std::nullopt;
}

struct Votes {
  int count = 0;
  double sum = 0;
  double squares = 0;  // of the sums of kRowsOfAnEdge rows
};

// Where disparity rises from one column to the next, a strip of as many columns of this image is
// hidden in the other one.
void AddRow(const View& view, int v, double& sum, int& count) {
  const float* d = view.disparity[v];
  const int width = view.disparity.cols;
  std::vector<double> row(static_cast<size_t>(width));
  for (int u = 0; u < width; ++u) {
    row[static_cast<size_t>(u)] =
        (view.image(v - 1, u) + view.image(v, u) + view.image(v + 1, u)) / 3.0;
  }
  int last = -1;
  for (int u = 0; u < width; ++u) {
    if (std::isnan(d[u])) continue;
    const int before = last;
    last = u;
    if (before < OrderRules::kSteadyColumns || u > width - 1 - OrderRules::kSteadyColumns) continue;
    const float step = d[u] - d[before];
    if (step < OrderRules::kMinStepPx ||
        std::abs(static_cast<float>(u - before - 1) - step) > step / 2 + 2 ||
        !IsSteady(d + before + 1 - OrderRules::kSteadyColumns) || !IsSteady(d + u)) {
      continue;
    }
    const auto change = ChangeIn(row, before - OrderRules::kAround, u + OrderRules::kAround + 1);
    if (!change) continue;
    const double half = std::max(1.0, (u - before) / 2.0);
    sum += std::clamp((*change - (u + before) / 2.0) / half, -1.0, 1.0);
    ++count;
  }
}

void AddView(const View& view, Votes& votes) {
  double sum = 0;
  for (int v = 1; v + 1 < view.image.rows; ++v) {
    AddRow(view, v, sum, votes.count);
    if (v % OrderRules::kRowsOfAnEdge != 0 && v + 2 < view.image.rows) continue;
    votes.sum += sum;
    votes.squares += sum * sum;
    sum = 0;
  }
}

}  // namespace

OcclusionOrder FindOcclusionOrder(const cv::Mat1b& left, const cv::Mat1b& right, double least_px,
                                  double most_px) {
  cv::Mat1b small_left = left, small_right = right;
  double shrink = 1;
  while (static_cast<double>(small_left.total()) > OrderRules::kMaxPixels) {
    small_left = Halved(small_left);
    small_right = Halved(small_right);
    shrink *= 2;
  }
  small_right = Alike(small_right, small_left);
  const int least = static_cast<int>(std::floor(least_px / shrink)) - OrderRules::kMarginPx;
  const int most = static_cast<int>(std::ceil(most_px / shrink)) + OrderRules::kMarginPx;
  const int count = (most - least + 15) / 16 * 16;  // StereoSGBM takes multiples of 16
  // In a mirror the right image is the left one of the pair.
  const cv::Mat1b mirrored_left = Mirrored(small_left);
  const cv::Mat1b mirrored_right = Mirrored(small_right);
  const cv::Mat1f of_left = Disparities(small_left, small_right, least, count);
  const cv::Mat1f of_right = Disparities(mirrored_right, mirrored_left, least, count);
  Votes votes;
  AddView(Agreed(small_left, of_left, of_right), votes);
  AddView(Agreed(mirrored_right, of_right, of_left), votes);
  OcclusionOrder order = {.edges = votes.count};
  if (votes.count == 0) return order;
  order.share = votes.sum / votes.count;
  order.sigmas = votes.squares > 0 ? votes.sum / std::sqrt(votes.squares) : 0;
  return order;
}

}  // namespace sprout::inputs
