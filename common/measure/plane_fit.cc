#include "common/measure/plane_fit.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "common/core/quantile.h"

namespace sprout {
namespace {

constexpr int kBlocks = 6;  // a side
constexpr int kMaxRounds = 10;
constexpr double kDeviationOfMedian = 1.4826;  // of normal noise: 1 / (its upper quartile)
constexpr double kOutlierDeviations = 4;
constexpr double kMinLimitPx = 1.0 / 16;

struct Sample {
  float u;
  float v;
  float d;
};

std::vector<Sample> SamplesOf(const cv::Mat1f& disparity_px, const cv::Rect& block) {
  std::vector<Sample> samples;
  samples.reserve(static_cast<size_t>(block.area()));
  for (int v = block.y; v < block.br().y; ++v) {
    for (int u = block.x; u < block.br().x; ++u) {
      const float d = disparity_px(v, u);
      if (std::isfinite(d)) samples.push_back({static_cast<float>(u), static_cast<float>(v), d});
    }
  }
  return samples;
}

Sample MedianOf(std::span<const Sample> samples) {
  const auto median = [&](float Sample::*member) {
    std::vector<float> values;
    values.reserve(samples.size());
    for (const Sample& sample : samples) values.push_back(sample.*member);
    return Median(values);
  };
  return {median(&Sample::u), median(&Sample::v), median(&Sample::d)};
}

std::vector<Sample> BlockMedians(const cv::Mat1f& disparity_px) {
  std::vector<Sample> medians;
  const int columns = std::min(kBlocks, disparity_px.cols);
  const int rows = std::min(kBlocks, disparity_px.rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const cv::Point from(disparity_px.cols * column / columns, disparity_px.rows * row / rows);
      const cv::Point to(disparity_px.cols * (column + 1) / columns,
                         disparity_px.rows * (row + 1) / rows);
      const std::vector<Sample> samples = SamplesOf(disparity_px, {from, to});
      if (!samples.empty()) medians.push_back(MedianOf(samples));
    }
  }
  return medians;
}

// Nothing when the three lie on a line.
std::optional<DisparityPlane> PlaneThrough(const Sample& a, const Sample& b, const Sample& c) {
  const double ub = b.u - a.u, vb = b.v - a.v, db = b.d - a.d;
  const double uc = c.u - a.u, vc = c.v - a.v, dc = c.d - a.d;
  const double area = ub * vc - uc * vb;
  if (std::abs(area) < 0.5) return std::nullopt;
  DisparityPlane plane{.du = (db * vc - dc * vb) / area, .dv = (ub * dc - uc * db) / area, .d0 = 0};
  plane.d0 = a.d - plane.At(a.u, a.v);
  return plane;
}

double MedianDistance(const DisparityPlane& plane, std::span<const Sample> samples,
                      std::vector<double>& memory) {
  memory.clear();
  for (const Sample& s : samples) memory.push_back(std::abs(s.d - plane.At(s.u, s.v)));
  return Median(memory);
}

// Step 1.
std::optional<DisparityPlane> LeastMedianPlane(std::span<const Sample> blocks) {
  std::optional<DisparityPlane> best;
  double best_distance = std::numeric_limits<double>::infinity();
  std::vector<double> memory;
  for (size_t i = 0; i < blocks.size(); ++i) {
    for (size_t j = i + 1; j < blocks.size(); ++j) {
      for (size_t k = j + 1; k < blocks.size(); ++k) {
        const auto plane = PlaneThrough(blocks[i], blocks[j], blocks[k]);
        if (!plane) continue;
        const double distance = MedianDistance(*plane, blocks, memory);
        if (distance >= best_distance) continue;
        best_distance = distance;
        best = plane;
      }
    }
  }
  return best;
}

// Step 3, over the samples within the limit of the plane before. Coordinates are taken around
// `middle`, which keeps the sums apart from each other.
std::optional<PlaneFit> LeastSquares(std::span<const Sample> samples, const DisparityPlane& before,
                                     double limit_px, cv::Point2d middle) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  PlaneFit fit{.plane = {}, .limit_px = limit_px, .inliers = 0, .outliers = 0};
  for (const Sample& s : samples) {
    if (std::abs(s.d - before.At(s.u, s.v)) > limit_px) {
      ++fit.outliers;
      continue;
    }
    ++fit.inliers;
    const Eigen::Vector3d row(s.u - middle.x, s.v - middle.y, 1);
    normal += row * row.transpose();
    right += row * double{s.d};
  }
  if (fit.inliers < kMinPlanePixels) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
  // Pixels on a line: a pivot of rounding errors.
  constexpr double kMinPivot = 1e-9;
  if (solver.vectorD().minCoeff() <= kMinPivot * solver.vectorD().maxCoeff()) return std::nullopt;
  const Eigen::Vector3d solution = solver.solve(right);
  fit.plane = {.du = solution[0],
               .dv = solution[1],
               .d0 = solution[2] - solution[0] * middle.x - solution[1] * middle.y};
  return fit;
}

}  // namespace

std::optional<Eigen::Hyperplane<double, 3>> PlaneInSpace(const DisparityPlane& plane,
                                                         const RectifiedPair& pair) {
  // f·b / z = d + cx_right − cx with u = f·x/z + cx and v = f·y/z + cy, times z.
  const Eigen::Vector3d normal(
      plane.du * pair.focal_px, plane.dv * pair.focal_px,
      plane.du * pair.cx + plane.dv * pair.cy + plane.d0 + pair.cx_right - pair.cx);
  const double length = normal.norm();
  if (!(normal.z() > 0) || !std::isfinite(length)) return std::nullopt;
  return Eigen::Hyperplane<double, 3>(normal / length, -pair.focal_px * pair.baseline_m / length);
}

std::optional<PlaneFit> FitPlane(const cv::Mat1f& disparity_px, cv::Point corner) {
  const std::vector<Sample> samples =
      SamplesOf(disparity_px, {0, 0, disparity_px.cols, disparity_px.rows});
  if (static_cast<int64_t>(samples.size()) < kMinPlanePixels) return std::nullopt;
  const auto start = LeastMedianPlane(BlockMedians(disparity_px));
  if (!start) return std::nullopt;
  const cv::Point2d middle((disparity_px.cols - 1) / 2.0, (disparity_px.rows - 1) / 2.0);
  PlaneFit fit{.plane = *start};
  std::vector<double> memory;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double deviation_px = kDeviationOfMedian * MedianDistance(fit.plane, samples, memory);
    const double limit_px = std::max(kOutlierDeviations * deviation_px, kMinLimitPx);
    const auto next = LeastSquares(samples, fit.plane, limit_px, middle);
    if (!next) return std::nullopt;
    const bool settled = next->inliers == fit.inliers;
    fit = *next;
    if (settled) break;
  }
  fit.plane.d0 -= fit.plane.du * corner.x + fit.plane.dv * corner.y;
  return fit;
}

}  // namespace sprout
