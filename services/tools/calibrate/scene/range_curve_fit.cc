#include "services/tools/calibrate/scene/range_curve_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "services/tools/calibrate/robust_solver.h"

namespace sprout::calibrate {
namespace {

constexpr size_t kMinAtKnot = 40;
constexpr size_t kMaxKnots = 24;
constexpr double kMinStep = 0.05;  // between knots, a share of the range
constexpr double kFarStep = 0.25;  // a straight line tells nothing between knots as far apart
constexpr double kExpectedM = kExpectedRangeErrorM;  // τ
constexpr double kCurveLossSigmas = 2;               // as AdjustScene()'s
constexpr double kCurveSharing = 4;                  // matches that share an error, as there
constexpr double kSureSigmas = 4;                    // standard deviations
constexpr double kMinCorrectionM = 0.002;
constexpr int kCurveRounds = 10;

// Knots at equal shares of the samples, except where they would be too close.
std::vector<double> KnotRanges(const std::vector<RangeSample>& by_range) {
  const size_t count = std::min(kMaxKnots, by_range.size() / kMinAtKnot);
  std::vector<double> ranges;
  for (size_t k = 0; k < count; ++k) {
    const size_t middle = (2 * k + 1) * by_range.size() / (2 * count);
    const double range_m = by_range[middle].range_m;
    if (ranges.empty() || range_m > (1 + kMinStep) * ranges.back()) ranges.push_back(range_m);
  }
  return ranges;
}

// Weights of the knots at a range, of which at most two are not 0, and of the light.
Eigen::VectorXd WeightsOf(const std::vector<double>& knots, const RangeSample& sample) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(knots.size()) + 1);
  weights[weights.size() - 1] = sample.brightness;
  const double range_m = sample.range_m;
  const auto above = std::ranges::upper_bound(knots, range_m) - knots.begin();
  if (above == 0) {
    weights[0] = 1;
  } else if (above == std::ssize(knots)) {
    weights[above - 1] = 1;
  } else {
    const double below_m = knots[static_cast<size_t>(above - 1)];
    const double share = (range_m - below_m) / (knots[static_cast<size_t>(above)] - below_m);
    weights[above - 1] = 1 - share;
    weights[above] = share;
  }
  return weights;
}

// Whether a range lies before the first knot, behind the last, or between knots so far apart that
// the curve may take any way there, and is not near one. A sample there would turn the line about
// the nearer knot and so move the other, or move a knot to what ranges far from it are off by.
bool IsFarFromKnots(const std::vector<double>& knots, double range_m) {
  const auto above = std::ranges::upper_bound(knots, range_m);
  if (above == knots.begin()) return *above > (1 + kMinStep) * range_m;
  if (above == knots.end()) return range_m > (1 + kMinStep) * knots.back();
  const double below_m = *(above - 1);
  return *above > (1 + kFarStep) * below_m && range_m > (1 + kMinStep) * below_m &&
         *above > (1 + kMinStep) * range_m;
}

// Sums over samples, from which the curve and its variances follow.
struct Sums {
  explicit Sums(Eigen::Index count)
      : squares(Eigen::MatrixXd::Zero(count, count)),
        curvature(squares),
        slope(Eigen::VectorXd::Zero(count)),
        right(slope) {}

  Sums& operator+=(const Sums& other) {
    squares += other.squares;
    curvature += other.curvature;
    slope += other.slope;
    right += other.right;
    return *this;
  }

  Eigen::MatrixXd squares;    // for the next step
  Eigen::MatrixXd curvature;  // second derivatives of the loss, below 0 where samples are far out
  Eigen::VectorXd slope;      // first ones
  Eigen::VectorXd right;
};

// Variances as an M-estimate's: how far the curve moves when each part of the image is left out
// (jackknife). Where samples disagree the loss hardly curves, and the curve may lie anywhere. At
// least as if their weights were those of a Gaussian.
Eigen::VectorXd Variances(const Sums& all, const std::map<size_t, Sums>& parts) {
  const auto count = static_cast<double>(parts.size());
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(all.slope.size());
  for (const auto& [part, sums] : parts) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(all.curvature - sums.curvature);
    const Eigen::VectorXd inverse =
        solver.eigenvalues().cwiseMax(1 / (kExpectedM * kExpectedM)).cwiseInverse();
    const Eigen::VectorXd moved =
        solver.eigenvectors() *
        inverse.cwiseProduct(solver.eigenvectors().transpose() * sums.slope);
    variances += (count - 1) / count * moved.cwiseAbs2();
  }
  return variances.cwiseMax(all.squares.inverse().diagonal());
}

// The curve at its knots, and the light, with their variances.
struct Fitted {
  Eigen::VectorXd values;
  Eigen::VectorXd variances;

  double light_sigma() const { return std::sqrt(variances[variances.size() - 1]); }
  double light() const { return values[values.size() - 1]; }
};

Fitted FitAt(const std::vector<double>& knots, const std::vector<RangeSample>& samples) {
  const auto count = static_cast<Eigen::Index>(knots.size()) + 1;
  Eigen::VectorXd fit = Eigen::VectorXd::Zero(count);
  Sums all(count);
  std::map<size_t, Sums> parts;
  for (int round = 0; round < kCurveRounds; ++round) {
    std::vector<double> off;
    for (const RangeSample& sample : samples) {
      const double left_m = WeightsOf(knots, sample).dot(fit) + sample.error_m;
      off.push_back(left_m / sample.sigma_m);
    }
    const double scatter = std::max(1.0, RobustSigma(off));
    parts.clear();
    for (size_t i = 0; i < samples.size(); ++i) {
      const Eigen::VectorXd weights = WeightsOf(knots, samples[i]);
      const Eigen::MatrixXd product = weights * weights.transpose();
      const double far = off[i] / (scatter * kCurveLossSigmas);
      const double sigma_m = scatter * samples[i].sigma_m;
      const double tail = 1 + far * far;
      const double weight = 1 / (tail * sigma_m * sigma_m * kCurveSharing);
      Sums& part = parts.try_emplace(samples[i].part, count).first->second;
      part.squares += weight * product;
      part.curvature += weight * (1 - far * far) / tail * product;
      part.slope += weight * off[i] * samples[i].sigma_m * weights;
      part.right -= weight * samples[i].error_m * weights;
    }
    all = Sums(count);
    all.squares.diagonal().array() = 1 / (kExpectedM * kExpectedM);
    all.curvature = all.squares;
    for (const auto& [number, part] : parts) all += part;
    fit = all.squares.ldlt().solve(all.right);
  }
  return {.values = fit, .variances = Variances(all, parts)};
}

// The sample nearest to a range.
const RangeSample& SampleAt(const std::vector<RangeSample>& by_range, double range_m) {
  const auto at = std::ranges::lower_bound(by_range, range_m, {}, &RangeSample::range_m);
  return at == by_range.end() ? by_range.back() : *at;
}

// The curve, if it is more than a yaw of the pair explains. By that it may be off as a whole.
RangeCorrection CurveOf(const std::vector<double>& knots, const std::vector<RangeSample>& samples,
                        const Fitted& fit) {
  const auto count = static_cast<Eigen::Index>(knots.size());
  Eigen::VectorXd sigma_m(count);
  Eigen::VectorXd yaw_m(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const RangeSample& sample = SampleAt(samples, knots[static_cast<size_t>(k)]);
    sigma_m[k] = std::hypot(std::sqrt(fit.variances[k]), sample.shared_m);
    yaw_m[k] = sample.yaw_m;
  }
  const Eigen::VectorXd values = fit.values.head(count);
  const Eigen::VectorXd yaw_sigmas = yaw_m.cwiseQuotient(sigma_m);
  const double yaw = yaw_sigmas.dot(values.cwiseQuotient(sigma_m)) / (1 + yaw_sigmas.squaredNorm());
  bool is_significant = false;
  RangeCorrection curve;
  for (Eigen::Index k = 0; k < count; ++k) {
    is_significant |= IsSignificantCorrection(values[k] - yaw * yaw_m[k], sigma_m[k]);
    curve.push_back({knots[static_cast<size_t>(k)], values[k], std::hypot(sigma_m[k], yaw_m[k])});
  }
  return is_significant ? curve : RangeCorrection();
}

}  // namespace

bool IsSignificantCorrection(double offset_m, double sigma_m) {
  return std::abs(offset_m) > std::max(kSureSigmas * sigma_m, kMinCorrectionM);
}

RangeFit FitRangeCurve(std::vector<RangeSample> samples) {
  std::ranges::stable_sort(samples, {}, &RangeSample::range_m);
  const std::vector<double> knots = KnotRanges(samples);
  if (knots.empty()) return {};
  std::erase_if(samples, [&](const RangeSample& s) { return IsFarFromKnots(knots, s.range_m); });
  Fitted fit = FitAt(knots, samples);
  if (fit.light() != 0 && !IsSignificantCorrection(fit.light(), fit.light_sigma())) {
    for (RangeSample& sample : samples) sample.brightness = 0;
    fit = FitAt(knots, samples);
  }
  RangeFit found{.curve = {}, .light_m = fit.light(), .light_sigma_m = fit.light_sigma()};
  found.curve = CurveOf(knots, samples, fit);
  return found;
}

RangeCorrection Chained(const RangeCorrection& first, const RangeCorrection& then) {
  if (first.empty()) return then;
  if (then.empty()) return first;
  std::vector<double> ranges;
  for (const CorrectionKnot& knot : first) ranges.push_back(knot.range_m);
  for (const CorrectionKnot& knot : then) {
    // The range as it was measured: the one that `first` takes to the knot's range. Its offset
    // hardly changes on the way.
    ranges.push_back(knot.range_m - CorrectionAt(first, knot.range_m).offset_m);
  }
  std::ranges::sort(ranges);
  const auto too_close = [](double a, double b) { return b <= (1 + kMinStep / 2) * a; };
  ranges.erase(std::unique(ranges.begin(), ranges.end(), too_close), ranges.end());
  RangeCorrection chained;
  const size_t step = (ranges.size() + kMaxCorrectionKnots - 1) / kMaxCorrectionKnots;
  for (size_t i = 0; i < ranges.size(); i += step) {
    const CorrectionKnot before = CorrectionAt(first, ranges[i]);
    const CorrectionKnot after = CorrectionAt(then, ranges[i] + before.offset_m);
    chained.push_back({ranges[i], before.offset_m + after.offset_m, after.sigma_m});
  }
  return chained;
}

}  // namespace sprout::calibrate
