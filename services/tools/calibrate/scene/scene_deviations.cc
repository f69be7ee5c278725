#include "services/tools/calibrate/scene/scene_deviations.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/quantile.h"
#include "services/tools/calibrate/scene/scene_residuals.h"

namespace sprout::calibrate {
namespace {

// Parts of the left image that err each by itself: surfaces, and a dozen ToF pixels each way.
constexpr int kPartColumns = 8;
constexpr int kPartRows = 6;
// As in AddRobust().
constexpr double kLossSigmas = 2;
// What a knock moves the ToF camera by along each axis: its turn of a degree, on a mount of 30 cm.
// Forward, also what a rig drives at 0.25 m/s in the 20 ms by which parts of a frame may differ.
constexpr double kTofPlaceM = 0.005;
// Ranges that differ by more have errors of their own: a quarter of what an SR4000's error repeats
// after (1.25 m), at 1.3 m. From the nearest to the farthest range that counts.
constexpr double kRangeStep = 1.25;
constexpr double kNearestM = 0.1;
constexpr int kRanges = 40;  // up to 600 m

constexpr int kNumbers = kRigNumbers;

using NumberRow = Eigen::Matrix<double, 1, kNumbers>;
using NumberSquare = Eigen::Matrix<double, kNumbers, kNumbers>;
using NumberVector = Eigen::Matrix<double, kNumbers, 1>;

// A sum over matches, whose depths are eliminated: half the second derivatives of (K4), and half
// the first ones, by the numbers.
struct Normal {
  NumberSquare squares = NumberSquare::Zero();
  NumberVector slope = NumberVector::Zero();

  Normal& operator+=(const Normal& other) {
    squares += other.squares;
    slope += other.slope;
    return *this;
  }
};

// The part of all residuals that one match has, linear about the end.
class MatchTerm {
 public:
  MatchTerm(const AdjustmentEnd& end, size_t i) : end_(end), match_(end.matches[i]) {
    const double* numbers = end.change.data();
    const double* depth = &end.inverse_depths[i];
    const MatchError error{end.rig, match_, end.column_sigma_px, end.row_sigma_px};
    is_usable_ = Add<MatchError, 2, 3, 2, 3>(error, {kPitch, kPlaceY, kFocal}, numbers, depth);
    if (!is_usable_ || !match_.tof) return;
    const PatchError patch{end.rig, match_, PatchSigma()};
    is_usable_ =
        Add<PatchError, 1, 3, 3, 1>(patch, {kFocal, kTofPitch, kRangeOffset}, numbers, depth);
  }

  bool is_usable() const { return is_usable_ && curvature_ > 0; }

  Normal normal() const {
    return {.squares = squares_ - mixed_ * mixed_.transpose() / curvature_,
            .slope = slope_ - mixed_ * (depth_slope_ / curvature_)};
  }

  // Of the slope by what the plane of the ToF camera is off, m; 0 without one.
  NumberVector slope_per_m() const {
    if (!match_.tof) return NumberVector::Zero();
    const NumberVector patch =
        last_weight_ * (last_row_.transpose() - mixed_ * (last_depth_ / curvature_));
    return patch / PatchSigma();
  }

 private:
  double PatchSigma() const { return end_.patch_sigmas * match_.tof->sigma_m; }

  // Adds kSize residuals by three blocks of numbers, which begin at `firsts`, and the depth.
  template <typename Error, int kSize, int... kBlockSizes>
  bool Add(const Error& error, const RigNumber (&firsts)[3], const double* numbers,
           const double* depth) {
    constexpr int kSizes[] = {kBlockSizes...};
    double residuals[kSize];
    double by_block[3][kSize * 3];
    double by_depth[kSize];
    const double* at[] = {numbers + firsts[0], numbers + firsts[1], numbers + firsts[2], depth};
    double* jacobians[] = {by_block[0], by_block[1], by_block[2], by_depth};
    const ceres::AutoDiffCostFunction<Error, kSize, kBlockSizes..., 1> cost(new Error(error));
    if (!cost.Evaluate(at, residuals, jacobians)) return false;
    double square = 0;
    for (const double residual : residuals) square += residual * residual;
    last_weight_ = 1 / (1 + square / (kLossSigmas * kLossSigmas));
    for (int k = 0; k < kSize; ++k) {
      last_row_.setZero();
      for (int b = 0; b < 3; ++b) {
        for (int j = 0; j < kSizes[b]; ++j) {
          last_row_[firsts[b] + j] = by_block[b][k * kSizes[b] + j];
        }
      }
      last_depth_ = by_depth[k];
      squares_ += last_weight_ * last_row_.transpose() * last_row_;
      mixed_ += last_weight_ * last_depth_ * last_row_.transpose();
      slope_ += last_weight_ * residuals[k] * last_row_.transpose();
      depth_slope_ += last_weight_ * residuals[k] * last_depth_;
      curvature_ += last_weight_ * last_depth_ * last_depth_;
    }
    return true;
  }

  const AdjustmentEnd& end_;
  const SceneMatch& match_;
  bool is_usable_ = false;
  NumberSquare squares_ = NumberSquare::Zero();
  NumberVector mixed_ = NumberVector::Zero();  // by the numbers and the depth
  NumberVector slope_ = NumberVector::Zero();
  double curvature_ = 0;  // by the depth twice
  double depth_slope_ = 0;
  double last_weight_ = 0;  // of the residual that was added last: the plane's
  double last_depth_ = 0;
  NumberRow last_row_ = NumberRow::Zero();
};

// Of both turns that depth edges show, in standard deviations, by the turn of the ToF camera.
Eigen::Matrix<double, 2, 3> EdgesByTurn(const EdgeShift& edges) {
  return edges.sigma.cwiseInverse().asDiagonal() * edges.rectified_from_left.topRows<2>();
}

// Terms of the priors, and of the turns that depth edges show.
Normal Known(const RigNumbers& change, const std::optional<EdgeShift>& edges) {
  Normal known;
  for (int i = 0; i < kNumbers; ++i) {
    const auto number = static_cast<RigNumber>(i);
    known.squares(i, i) = std::pow(RowOf(number).expected, -2);
    known.slope[i] = known.squares(i, i) * change[number];
  }
  if (!edges) return known;
  const Eigen::Matrix<double, 2, 3> by_turn = EdgesByTurn(*edges);
  const Eigen::Vector3d turn(change[kTofPitch], change[kTofYaw], change[kTofRoll]);
  const Eigen::Vector2d off =
      by_turn * (turn - edges->applied) - edges->turn.cwiseQuotient(edges->sigma);
  known.squares.block<3, 3>(kTofPitch, kTofPitch) += by_turn.transpose() * by_turn;
  known.slope.segment<3>(kTofPitch) += by_turn.transpose() * off;
  return known;
}

class DeviationSums {
 public:
  DeviationSums(const AdjustmentEnd& end, const std::optional<EdgeShift>& edges)
      : known_(Known(end.change, edges)), parts_(kPartColumns * kPartRows) {
    const Eigen::Matrix3d left_from_tof =
        TurnedBy(end.rig.left_from_tof,
                 {end.change[kTofPitch], end.change[kTofYaw], end.change[kTofRoll]})
            .rotation.toRotationMatrix();
    for (size_t i = 0; i < end.matches.size(); ++i) {
      const SceneMatch& match = end.matches[i];
      const MatchTerm term(end, i);
      if (!term.is_usable()) continue;
      const Normal normal = term.normal();
      parts_[PartOf(match.left, end.rig.left)] += normal;
      frames_.resize(std::max(frames_.size(), match.view + 1));
      frames_[match.view] += normal;
      whole_ += normal;
      if (match.tof) AddSystematic(*match.tof, left_from_tof, term.slope_per_m());
    }
    // All rows, or columns, off alike; for the roll at either side of the image.
    floor_[kPitch] = floor_[kYaw] = kSharedMatchPx / end.rig.left.fx;
    floor_[kRoll] = 2 * kSharedMatchPx / end.rig.left.width;
    if (edges) AddPlaceOfEdges(*edges, Median(std::vector(end.inverse_depths)));
  }

  // Standard deviations of numbers, if the others are right.
  // @param place_m  by which the ToF camera may stand aside, along each axis.
  std::optional<RigNumbers> Find(const Wanted& numbers, double place_m) const {
    std::vector<int> of;
    for (int i = 0; i < kNumbers; ++i) {
      if (numbers[static_cast<size_t>(i)]) of.push_back(i);
    }
    Normal all = whole_;
    all += known_;
    const Eigen::MatrixXd squares = all.squares(of, of);
    const Eigen::LLT<Eigen::MatrixXd> solver(squares);
    if (solver.info() != Eigen::Success) return std::nullopt;
    const Eigen::MatrixXd inverse =
        solver.solve(Eigen::MatrixXd::Identity(squares.rows(), squares.cols()));
    const Eigen::MatrixXd place = inverse * by_place_(of, Eigen::all);
    Eigen::MatrixXd ranges = inverse * by_range_(of, Eigen::all);
    const Eigen::RowVectorXd weights = by_range_.row(kRangeOffset);
    if (numbers[kRangeOffset] && weights.sum() != 0) {
      // The offset is the mean error of all ranges: errors at each range are those besides it.
      ranges -= ranges.rowwise().sum() * (weights / weights.sum());
    }
    const Eigen::VectorXd variances = (inverse * known_.squares(of, of) * inverse).diagonal() +
                                      LeftOut(parts_, all, of) + LeftOut(frames_, all, of) +
                                      kRangeErrorM * kRangeErrorM * ranges.rowwise().squaredNorm() +
                                      place_m * place_m * place.rowwise().squaredNorm();
    RigNumbers sigma{};
    for (size_t k = 0; k < of.size(); ++k) {
      const auto number = static_cast<size_t>(of[k]);
      sigma[number] =
          std::hypot(std::sqrt(variances[static_cast<Eigen::Index>(k)]), floor_[number]);
    }
    return sigma;
  }

 private:
  void AddSystematic(const TofPatch& patch, const Eigen::Matrix3d& left_from_tof,
                     const NumberVector& slope_per_m) {
    const Eigen::Vector3d normal = left_from_tof * patch.normal;
    by_place_ += slope_per_m * normal.transpose();
    const double range_m = patch.distance_m / patch.per_range;
    const double step = std::log(std::max(range_m / kNearestM, 1.0)) / std::log(kRangeStep);
    const int below = std::min(static_cast<int>(step), kRanges - 2);
    const double share = std::min(step - below, 1.0);
    for (const auto& [knot, part] : {std::pair(below, 1 - share), std::pair(below + 1, share)}) {
      by_range_.col(knot) += part * patch.per_range * slope_per_m;
    }
  }

  // Jackknife: how far the numbers move when each group is left out, one Newton step each.
  static Eigen::VectorXd LeftOut(const std::vector<Normal>& groups, const Normal& all,
                                 const std::vector<int>& of) {
    const auto step = [&](const Normal& without) {
      const Eigen::MatrixXd squares = (all.squares - without.squares)(of, of);
      return Eigen::VectorXd(
          squares.ldlt().solve(Eigen::VectorXd((all.slope - without.slope)(of))));
    };
    const Eigen::VectorXd with_all = step({});
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(with_all.size());
    double count = 0;
    for (const Normal& group : groups) {
      if (group.squares.isZero()) continue;
      ++count;
      sum += (step(group) - with_all).cwiseAbs2();
    }
    return count > 1 ? Eigen::VectorXd(sum * ((count - 1) / count)) : 0 * sum;
  }

  // A ToF camera that stands further right sees an edge further left, like one that is turned.
  void AddPlaceOfEdges(const EdgeShift& edges, double inverse_depth) {
    Eigen::Matrix<double, 2, 3> turn_by_place;
    turn_by_place << 0, inverse_depth, 0, -inverse_depth, 0, 0;
    by_place_.middleRows<3>(kTofPitch) +=
        EdgesByTurn(edges).transpose() * edges.sigma.cwiseInverse().asDiagonal() * turn_by_place;
  }

  Normal known_;
  RigNumbers floor_{};  // standard deviations of what all matches share
  std::vector<Normal> parts_;
  std::vector<Normal> frames_;
  Normal whole_;
  // The slope by what is not adjusted: the ToF camera's place along each axis, and its ranges'
  // errors, both in m.
  Eigen::Matrix<double, kNumbers, 3> by_place_ = Eigen::Matrix<double, kNumbers, 3>::Zero();
  Eigen::Matrix<double, kNumbers, kRanges> by_range_ =
      Eigen::Matrix<double, kNumbers, kRanges>::Zero();
};

}  // namespace

size_t PartOf(const cv::Point2d& left, const Lens& lens) {
  const auto cell = [](double at, int size, int cells) {
    return std::clamp(static_cast<int>(at * cells / size), 0, cells - 1);
  };
  return static_cast<size_t>(cell(left.y, lens.height, kPartRows) * kPartColumns +
                             cell(left.x, lens.width, kPartColumns));
}

std::optional<Deviations> DeviationsOf(const AdjustmentEnd& end,
                                       const std::optional<EdgeShift>& edges, const Wanted& free,
                                       const Wanted& wanted) {
  const DeviationSums sums(end, edges);
  const std::optional<RigNumbers> of_free = sums.Find(free, 0);
  const std::optional<RigNumbers> of_all = sums.Find(wanted, kTofPlaceM);
  if (!of_free || !of_all) return std::nullopt;
  return Deviations{.if_others_stay = *of_free, .all = *of_all};
}

}  // namespace sprout::calibrate
