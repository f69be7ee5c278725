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
  static constexpr size_t kMinMatches = 12;      ///< matches that five numbers are fitted to
  /// The same for (3), whose ends are free: of fewer, blurred pairs seem to be bent.
  static constexpr size_t kMinBentMatches = 80;
  static constexpr int kColumns = 4;  ///< of cells
  static constexpr int kRows = 3;
};

using Vector = Eigen::Matrix<double, 6, 1>;
using Matrix = Eigen::Matrix<double, 6, 6>;

enum class Form { kPlane, kParallax, kBent };  // (1), (2), (3)

// Coefficients of a, b, c and of what else a form has for a match, 0 behind them.
class Terms {
 public:
  Terms(Form form, cv::Size size, double disparity_unit = 1)
      : form_(form), size_(size), unit_(disparity_unit) {}

  Vector At(double x_px, double y_px, double disparity_px) const {
    const double x = x_px / size_.width - 0.5;
    const double y = y_px / size_.height - 0.5;
    if (form_ == Form::kBent) {
      const double high = y * size_.height / size_.width;
      return Vector{1, x, y, x * y, y * y, y * (x * x + high * high)};
    }
    const double d = form_ == Form::kParallax ? disparity_px / unit_ : 0;
    return Vector{1, x, y, d, d * y, 0};
  }
  Vector Of(const Match& match) const { return At(match.left.x, match.left.y, match.disparity()); }

 private:
  Form form_;
  cv::Size size_;
  double unit_;
};

struct Fit {
  Vector model = Vector::Zero();
  Matrix covariance = Matrix::Zero();
  double scale = 0;  // of the residuals, px
};

// Weighted least squares.
Fit Solve(const std::vector<Match>& matches, const Terms& terms, const Vector& start,
          double least_scale) {
  Fit fit;
  fit.model = start;
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
    const auto solver = normal.ldlt();
    fit.model = solver.solve(right);
    fit.covariance = fit.scale * fit.scale * solver.solve(Matrix::Identity());
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

// How far rows are off at a place, by a fit.
Estimate RowsAt(const Fit& fit, const Terms& terms, double x_px, double y_px) {
  const Vector row = terms.At(x_px, y_px, 0);
  return {row.dot(fit.model), std::sqrt(row.dot(fit.covariance * row))};
}

Estimate WorstRows(const Fit& fit, const Terms& terms, cv::Size size) {
  Estimate worst;
  for (int row = 0; row < ModelRules::kRows; ++row) {
    for (int column = 0; column < ModelRules::kColumns; ++column) {
      const Estimate cell = RowsAt(fit, terms, size.width * (column + 0.5) / ModelRules::kColumns,
                                   size.height * (row + 0.5) / ModelRules::kRows);
      if (std::abs(cell.value) >= std::abs(worst.value)) worst = cell;
    }
  }
  return worst;
}

}  // namespace

PairModel FitPair(const Matches& matches, cv::Size size) {
  PairModel result;
  result.tried = static_cast<int>(matches.matches.size());
  const double tolerance = ModelRules::kToleranceSteps * matches.step_px;
  const double p = std::min(1.0, tolerance / matches.most_rows_px);
  const double n = result.tried;
  result.by_chance = {n * p, std::sqrt(n * p * (1 - p))};
  if (matches.matches.size() < ModelRules::kMinMatches) return result;
  std::vector<double> disparities;
  for (const Match& match : matches.matches) disparities.push_back(std::abs(match.disparity()));
  const Terms plane(Form::kPlane, size);
  const Vector start = BestSample(matches.matches, plane, tolerance, size);
  // Near things and bent rows may lie beyond the tolerance.
  std::vector<Match> near_model;
  for (const Match& match : matches.matches) {
    const double off = std::abs(match.rows() - plane.Of(match).dot(start));
    if (off <= tolerance) result.inliers.push_back(match);
    if (off <= 4 * tolerance) near_model.push_back(match);
  }
  if (result.inliers.size() < ModelRules::kMinMatches) return result;
  const double least_scale = ModelRules::kMinScaleSteps * matches.step_px;
  const Fit rows = Solve(result.inliers, plane, start, least_scale);
  result.middle_px = RowsAt(rows, plane, size.width / 2.0, size.height / 2.0);
  result.worst_px = WorstRows(rows, plane, size);
  result.roll_rad = rows.model[1] / size.width;
  result.stretch = {rows.model[2] / size.height, std::sqrt(rows.covariance(2, 2)) / size.height};
  if (near_model.size() >= ModelRules::kMinBentMatches) {
    const Terms bent(Form::kBent, size);
    result.bent_px = WorstRows(Solve(near_model, bent, start, least_scale), bent, size);
  }
  const Terms parallax(Form::kParallax, size, std::max(1.0, Median(disparities)));
  const Fit fit = Solve(near_model, parallax, start, least_scale);
  double square = 0;
  double variance = 0;
  for (const Match& match : result.inliers) {
    Vector row = parallax.Of(match);
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
