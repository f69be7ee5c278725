#include "common/inputs/pair_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "common/core/quantile.h"

namespace sprout::inputs {
namespace {

struct ModelRules {
  static constexpr int kSamples = 200;
  static constexpr double kEnoughSupport = 0.85;  ///< of the matches: no sample will be better
  static constexpr double kToleranceSteps = 1.5;  ///< of a match from the model, see step_px
  static constexpr double kMaxSlope = 0.05;       ///< roll of 3°, or 5 % of the focal length
  static constexpr int kIterations = 6;
  static constexpr double kTukey = 4.685;
  static constexpr double kMinScaleSteps = 0.1;  ///< of residuals: what a position is good for
  static constexpr size_t kFewest = 12;          ///< matches that five numbers are fitted to
  static constexpr int kColumns = 4;             ///< of cells
  static constexpr int kRows = 3;
};

using Vector = Eigen::Matrix<double, 5, 1>;
using Matrix = Eigen::Matrix<double, 5, 5>;

// Coefficients of a, b, c, e, g for a match; the last two 0 without parallax.
class Terms {
 public:
  Terms(cv::Size size, double disparity_unit) : size_(size), unit_(disparity_unit) {}

  Vector At(double x_px, double y_px, double disparity_px) const {
    const double x = x_px / size_.width - 0.5;
    const double y = y_px / size_.height - 0.5;
    const double d = disparity_px / unit_;
    return {1, x, y, d, d * y};
  }
  Vector Of(const Match& match) const { return At(match.left.x, match.left.y, match.disparity()); }

 private:
  cv::Size size_;
  double unit_;
};

struct Fit {
  Vector model = Vector::Zero();
  Matrix covariance = Matrix::Zero();
  double scale = 0;  // of the residuals, px
};

// Weighted least squares with the first `count` terms.
Fit Solve(const std::vector<Match>& matches, const Terms& terms, int count, const Vector& start,
          double least_scale) {
  Fit fit;
  fit.model = start;
  fit.model.tail(5 - count).setZero();
  std::vector<double> residuals(matches.size());
  for (int iteration = 0; iteration < ModelRules::kIterations; ++iteration) {
    for (size_t i = 0; i < matches.size(); ++i) {
      residuals[i] = matches[i].rows() - terms.Of(matches[i]).dot(fit.model);
    }
    std::vector<double> sizes = residuals;
    for (double& size : sizes) size = std::abs(size);
    fit.scale = std::max(1.4826 * Median(sizes), least_scale);
    Matrix normal = Matrix::Zero();
    Vector right = Vector::Zero();
    for (size_t i = 0; i < matches.size(); ++i) {
      const double share = residuals[i] / (ModelRules::kTukey * fit.scale);
      if (std::abs(share) >= 1) continue;
      const double weight = (1 - share * share) * (1 - share * share);
      const Vector row = terms.Of(matches[i]);
      normal += weight * row * row.transpose();
      right += weight * row * matches[i].rows();
    }
    // A weak prior, so that terms that the matches do not fix stay 0.
    normal.diagonal().array() += 1e-6 * static_cast<double>(matches.size());
    const auto solver = normal.topLeftCorner(count, count).ldlt();
    fit.model.head(count) = solver.solve(right.head(count));
    fit.covariance.setZero();
    fit.covariance.topLeftCorner(count, count) =
        fit.scale * fit.scale * solver.solve(Eigen::MatrixXd::Identity(count, count));
  }
  return fit;
}

// Whole numbers without a pattern: the same on every machine (Knuth's MMIX generator).
using Numbers =
    std::linear_congruential_engine<uint64_t, 6364136223846793005, 1442695040888963407, 0>;

double Support(const std::vector<Match>& matches, const std::vector<Vector>& rows,
               const Vector& model, double tolerance) {
  double support = 0;
  for (size_t i = 0; i < matches.size(); ++i) {
    const double share = (matches[i].rows() - rows[i].dot(model)) / tolerance;
    support += std::max(0.0, 1 - share * share);
  }
  return support;
}

// The model (1) that most matches agree with.
Vector BestSample(const std::vector<Match>& matches, const Terms& terms, double tolerance,
                  cv::Size size) {
  std::vector<Vector> rows;
  for (const Match& match : matches) rows.push_back(terms.Of(match));
  Vector best = Vector::Zero();
  double most = -1;
  const auto offer = [&](const Vector& model) {
    const double support = Support(matches, rows, model, tolerance);
    if (support > most) {
      most = support;
      best = model;
    }
  };
  Numbers numbers;
  for (int sample = 0; sample < ModelRules::kSamples; ++sample) {
    Eigen::Matrix3d three;
    Eigen::Vector3d heights;
    for (int i = 0; i < 3; ++i) {
      const auto chosen = static_cast<size_t>((numbers() >> 33) % matches.size());
      three.row(i) = rows[chosen].head<3>().transpose();
      heights[i] = matches[chosen].rows();
    }
    Vector level = Vector::Zero();
    level[0] = heights[0];
    offer(level);
    if (most >= ModelRules::kEnoughSupport * static_cast<double>(matches.size())) break;
    if (std::abs(three.determinant()) < 0.01) continue;
    Vector model = Vector::Zero();
    model.head<3>() = three.inverse() * heights;
    if (std::abs(model[1]) > ModelRules::kMaxSlope * size.width ||
        std::abs(model[2]) > ModelRules::kMaxSlope * size.height) {
      continue;
    }
    offer(model);
  }
  return best;
}

void FindWorst(const Fit& fit, const Terms& terms, cv::Size size, PairModel& result) {
  const auto at = [&](double x_px, double y_px) {
    const Vector row = terms.At(x_px, y_px, 0);
    return Estimate{row.dot(fit.model), std::sqrt(row.dot(fit.covariance * row))};
  };
  result.middle_px = at(size.width / 2.0, size.height / 2.0);
  result.worst_px = result.middle_px;
  for (int row = 0; row < ModelRules::kRows; ++row) {
    for (int column = 0; column < ModelRules::kColumns; ++column) {
      const Estimate cell = at(size.width * (column + 0.5) / ModelRules::kColumns,
                               size.height * (row + 0.5) / ModelRules::kRows);
      if (std::abs(cell.value) > std::abs(result.worst_px.value)) result.worst_px = cell;
    }
  }
  result.roll_rad = fit.model[1] / size.width;
}

}  // namespace

PairModel FitPair(const Matches& matches, cv::Size size) {
  PairModel result;
  result.tried = static_cast<int>(matches.matches.size());
  const double tolerance = ModelRules::kToleranceSteps * matches.step_px;
  const double p = std::min(1.0, tolerance / matches.most_rows_px);
  const double n = result.tried;
  result.by_chance = {n * p, std::sqrt(n * p * (1 - p))};
  if (matches.matches.size() < ModelRules::kFewest) return result;
  std::vector<double> disparities;
  for (const Match& match : matches.matches) disparities.push_back(std::abs(match.disparity()));
  const Terms terms(size, std::max(1.0, Median(disparities)));
  const Vector start = BestSample(matches.matches, terms, tolerance, size);
  for (const Match& match : matches.matches) {
    if (std::abs(match.rows() - terms.Of(match).dot(start)) > tolerance) continue;
    result.inliers.push_back(match);
  }
  if (result.inliers.size() < ModelRules::kFewest) return result;
  const double least_scale = ModelRules::kMinScaleSteps * matches.step_px;
  FindWorst(Solve(result.inliers, terms, 3, start, least_scale), terms, size, result);

  // What near things do may lead beyond the tolerance.
  std::vector<Match> near_model;
  for (const Match& match : matches.matches) {
    if (std::abs(match.rows() - terms.Of(match).dot(start)) <= 4 * tolerance) {
      near_model.push_back(match);
    }
  }
  const Fit fit = Solve(near_model, terms, 5, start, least_scale);
  double square = 0;
  double variance = 0;
  for (const Match& match : result.inliers) {
    Vector row = terms.Of(match);
    row.head<3>().setZero();
    square += std::pow(row.dot(fit.model), 2);
    variance += row.dot(fit.covariance * row);
  }
  const auto count = static_cast<double>(result.inliers.size());
  result.parallax_px = {std::sqrt(square / count), std::sqrt(variance / count)};
  return result;
}

Estimate MedianOf(std::vector<double> values) {
  if (values.empty()) return {0, 0};
  const double median = Median(values);
  for (double& value : values) value = std::abs(value - median);
  // The standard deviation of a median of normal deviates is 1.2533 times that of their mean.
  return {median, 1.2533 * 1.4826 * Median(values) / std::sqrt(static_cast<double>(values.size()))};
}

}  // namespace sprout::inputs
