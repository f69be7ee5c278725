#include "common/measure/score.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "common/core/image.h"

namespace sprout {
namespace {

constexpr double kMaxDisagreementPx = 1;

/// Right column of a left pixel; −1 when the disparity is unknown or the column outside the image.
int RightColumn(int u, float disparity_px, int width) {
  const double column = std::round(u - double{disparity_px});
  return column >= 0 && column < width ? static_cast<int>(column) : -1;  // NaN is neither
}

bool ViewsAgree(float left_px, float right_px) {
  return std::abs(double{left_px} - double{right_px}) <= kMaxDisagreementPx;  // NaN does not
}

void MarkAgreeing(const cv::Mat1f& left, const cv::Mat1f& right, int v, cv::Mat1b& mask) {
  for (int u = 0; u < left.cols; ++u) {
    const int column = RightColumn(u, left(v, u), left.cols);
    if (column >= 0 && ViewsAgree(left(v, u), right(v, column))) mask(v, u) = 255;
  }
}

void MarkNearest(const cv::Mat1f& left, int v, cv::Mat1b& mask) {
  std::vector<double> nearest_px(static_cast<size_t>(left.cols),
                                 -std::numeric_limits<double>::infinity());
  const auto nearest_at = [&nearest_px](int column) -> double& {
    return nearest_px[static_cast<size_t>(column)];
  };
  for (int u = 0; u < left.cols; ++u) {
    const int column = RightColumn(u, left(v, u), left.cols);
    if (column >= 0) nearest_at(column) = std::max(nearest_at(column), double{left(v, u)});
  }
  for (int u = 0; u < left.cols; ++u) {
    const int column = RightColumn(u, left(v, u), left.cols);
    if (column >= 0 && nearest_at(column) - left(v, u) <= kMaxDisagreementPx) mask(v, u) = 255;
  }
}

}  // namespace

Result<cv::Mat1b> NonOccludedMask(const cv::Mat1f& left_truth, const cv::Mat1f& right_truth) {
  if (!right_truth.empty() && right_truth.size() != left_truth.size()) {
    return Fail("ground truth: left " + SizeText(left_truth.size()) + " and right " +
                SizeText(right_truth.size()) + " differ in size");
  }
  cv::Mat1b mask(left_truth.size(), uchar{0});
  for (int v = 0; v < mask.rows; ++v) {
    if (right_truth.empty()) {
      MarkNearest(left_truth, v, mask);
    } else {
      MarkAgreeing(left_truth, right_truth, v, mask);
    }
  }
  return mask;
}

Result<cv::Mat1b> OccludedMask(const cv::Mat1f& left_truth, const cv::Mat1f& right_truth) {
  const Result<cv::Mat1b> seen = NonOccludedMask(left_truth, right_truth);
  if (!seen) return seen;
  cv::Mat1b mask(left_truth.size(), uchar{0});
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      const int column = RightColumn(u, left_truth(v, u), mask.cols);
      if (column < 0 || (*seen)(v, u) != 0) continue;
      if (right_truth.empty() || std::isfinite(right_truth(v, column))) mask(v, u) = 255;
    }
  }
  return mask;
}

double Accuracy::Percent(int64_t pixels) const {
  if (scored == 0) return std::numeric_limits<double>::quiet_NaN();
  return 100.0 * static_cast<double>(pixels) / static_cast<double>(scored);
}

double Accuracy::mean_abs_px() const {
  if (with_disparity == 0) return std::numeric_limits<double>::quiet_NaN();
  return sum_abs_px / static_cast<double>(with_disparity);
}

double Accuracy::rms_px() const {
  if (with_disparity == 0) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(sum_squares_px2 / static_cast<double>(with_disparity));
}

cv::Mat1f ErrorMap(const cv::Mat1f& disparity_px, const cv::Mat1f& truth, const cv::Mat1b& mask) {
  assert(disparity_px.size() == truth.size() && mask.size() == truth.size());
  cv::Mat1f error_px(truth.size(), std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      if (mask(v, u) == 0 || !std::isfinite(truth(v, u))) continue;
      const float error = std::abs(disparity_px(v, u) - truth(v, u));
      error_px(v, u) = std::isfinite(error) ? error : std::numeric_limits<float>::infinity();
    }
  }
  return error_px;
}

Result<Accuracy> Score(const cv::Mat1f& disparity_px, const cv::Mat1f& truth,
                       const cv::Mat1b& mask) {
  if (truth.size() != disparity_px.size() || mask.size() != disparity_px.size()) {
    return Fail("score: disparity map " + SizeText(disparity_px.size()) + ", ground truth " +
                SizeText(truth.size()) + " and mask " + SizeText(mask.size()) + " differ in size");
  }
  Accuracy accuracy;
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      if (mask(v, u) == 0 || !std::isfinite(truth(v, u))) continue;
      ++accuracy.scored;
      if (!std::isfinite(disparity_px(v, u))) continue;
      ++accuracy.with_disparity;
      // Map and truth are exact in double, and so is their difference near a threshold.
      const double error = std::abs(double{disparity_px(v, u)} - double{truth(v, u)});
      accuracy.within_half += error <= 0.5;
      accuracy.within_1 += error <= 1;
      accuracy.below_1 += error < 1;
      accuracy.within_2 += error <= 2;
      accuracy.within_4 += error <= 4;
      accuracy.within_d1 += error <= 3 || error <= 0.05 * std::abs(double{truth(v, u)});
      accuracy.sum_abs_px += error;
      accuracy.sum_squares_px2 += error * error;
    }
  }
  return accuracy;
}

Result<Accuracy> Score(const DisparityImage& disparity, const cv::Mat1f& truth,
                       const cv::Mat1b& mask) {
  return Score(ToPx(disparity), truth, mask);
}

}  // namespace sprout
