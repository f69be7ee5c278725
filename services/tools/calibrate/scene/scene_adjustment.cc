#include "services/tools/calibrate/scene/scene_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/tools/calibrate/robust_solver.h"
#include "services/tools/calibrate/scene/scene_deviations.h"
#include "services/tools/calibrate/scene/scene_residuals.h"

namespace sprout::calibrate {
namespace {

// The prior that a number hardly changes: (number − 0) / σ.
template <int kSize>
struct SmallChange {
  std::array<double, static_cast<size_t>(kSize)> sigma;

  template <typename T>
  bool operator()(const T* numbers, T* residual) const {
    for (size_t i = 0; i < sigma.size(); ++i) residual[i] = numbers[i] / T(sigma[i]);
    return true;
  }
};

// Solutions until the sigmas stand still, to a percent: the first starts from pixels, those with
// fewer numbers from the last one.
constexpr int kFirstRounds = 5;
constexpr int kLaterRounds = 2;
// No match is better; keeps an artificial input without noise from a division by 0.
constexpr double kMinScatterPx = 0.01;
// A number is seen when it is known to this share of what is expected of it.
constexpr double kSeen = 1.0 / 3;
// Numbers first to first + size − 1 are one block.
struct NumberBlock {
  RigNumber first;
  int size;
};
constexpr NumberBlock kTurn{kPitch, 3};
constexpr NumberBlock kPlace{kPlaceY, 2};
constexpr NumberBlock kLenses{kFocal, 3};
constexpr NumberBlock kTofTurn{kTofPitch, 3};
constexpr NumberBlock kOffset{kRangeOffset, 1};
constexpr std::array kNumberBlocks = {kTurn, kPlace, kLenses, kTofTurn, kOffset};

class Adjustment {
 public:
  Adjustment(const RawRig& rig, const std::vector<SceneMatch>& matches,
             const std::optional<EdgeShift>& edges, const Wanted& wanted)
      : rig_(rig), matches_(matches), edges_(edges), wanted_(wanted), free_(wanted), seen_(wanted) {
    Restart();
  }

  Result<AdjustedScene> Run(bool only_sure) {
    Result<void> solved = Solutions(kFirstRounds);
    while (solved && TakeOutUnseen()) {
      // A number that was not seen may have moved all depths to wrong places.
      Restart();
      solved = Solutions(kFirstRounds);
    }
    while (solved && only_sure && TakeOutInsignificant()) solved = Solutions(kLaterRounds);
    if (!solved) return tl::unexpected(solved.error());
    return AdjustedScene{.change = numbers_,
                         .sigma = totals_,
                         .frames_sigma = deviations_,
                         .seen = seen_,
                         .inverse_depths = depths_,
                         .match_sigma_px = sigma_px_};
  }

 private:
  Result<void> Solutions(int rounds) {
    for (int round = 0; round < rounds; ++round) {
      ceres::Problem problem;
      Build(problem);
      if (!FindMinimum(problem)) return Fail("the matches lead to no calibration");
      FindSigmas();
      if (round + 1 == rounds && !FindDeviations()) {
        return Fail("the matches do not determine the calibration");
      }
    }
    return {};
  }

  void Restart() {
    numbers_.fill(0);
    depths_.clear();
    for (const SceneMatch& match : matches_) depths_.push_back(match.inverse_depth);
    along_sigmas_ = 1;
    FindSigmas();
  }

  double* At(NumberBlock block) { return numbers_.data() + block.first; }

  void Build(ceres::Problem& problem) {
    for (size_t i = 0; i < matches_.size(); ++i) {
      AddRobust<2, 3, 2, 3, 1>(problem,
                               MatchError{rig_, matches_[i], along_sigmas_ * sigma_px_, sigma_px_},
                               At(kTurn), At(kPlace), At(kLenses), &depths_[i]);
      if (!matches_[i].tof) continue;
      AddRobust<1, 3, 3, 1, 1>(
          problem, PatchError{rig_, matches_[i], along_sigmas_ * matches_[i].tof->sigma_m},
          At(kLenses), At(kTofTurn), At(kOffset), &depths_[i]);
    }
    if (edges_) AddPlain<2, 3>(problem, EdgeError{*edges_}, At(kTofTurn));
    AddPrior<3>(problem, kTurn);
    AddPrior<2>(problem, kPlace);
    AddPrior<3>(problem, kLenses);
    AddPrior<3>(problem, kTofTurn);
    AddPrior<1>(problem, kOffset);
    for (const NumberBlock& block : kNumberBlocks) Hold(problem, block);
  }

  template <int kSize>
  void AddPrior(ceres::Problem& problem, NumberBlock block) {
    SmallChange<kSize> prior;
    for (int i = 0; i < kSize; ++i) {
      prior.sigma[static_cast<size_t>(i)] = RowOf(static_cast<RigNumber>(block.first + i)).expected;
    }
    AddPlain<kSize, kSize>(problem, prior, At(block));
  }

  // Keeps the numbers of a block constant that may not change.
  void Hold(ceres::Problem& problem, NumberBlock block) {
    std::vector<int> held;
    for (int i = 0; i < block.size; ++i) {
      if (!free_[static_cast<size_t>(block.first + i)]) held.push_back(i);
    }
    if (static_cast<int>(held.size()) == block.size) {
      problem.SetParameterBlockConstant(At(block));
    } else if (!held.empty()) {
      problem.SetManifold(At(block), new ceres::SubsetManifold(block.size, held));
    }
  }

  bool FindMinimum(ceres::Problem& problem) {
    std::vector<double*> depths;
    for (double& depth : depths_) depths.push_back(&depth);
    std::vector<double*> numbers;
    for (const NumberBlock& block : kNumberBlocks) numbers.push_back(At(block));
    return Solve(problem, depths, numbers, {});
  }

  void FindSigmas() {
    const std::vector<MatchResidual> residuals = ResidualsOf(rig_, matches_, depths_, numbers_);
    std::vector<double> rows;
    std::vector<double> ranges;
    for (const MatchResidual& residual : residuals) rows.push_back(residual.rows_px);
    sigma_px_ = std::max(kMinScatterPx, RobustSigma(std::move(rows)));
    // The difference of ToF and stereo has the errors of both. On slanted surfaces columns are less
    // exact than rows, and ToF points less than their planes show: both by the same factor.
    for (size_t i = 0; i < matches_.size(); ++i) {
      if (!residuals[i].tof_m) continue;
      const double m_per_px = std::abs(*residuals[i].tof_m / *residuals[i].tof_px);
      if (!std::isfinite(m_per_px)) continue;
      const double expected =
          along_sigmas_ * std::hypot(matches_[i].tof->sigma_m, sigma_px_ * m_per_px);
      ranges.push_back(*residuals[i].tof_m / expected);
    }
    if (ranges.empty()) return;
    along_sigmas_ = std::max(1.0, along_sigmas_ * RobustSigma(std::move(ranges)));
  }

  bool FindDeviations() {
    const std::optional<Deviations> found = DeviationsOf(
        {rig_, matches_, depths_, numbers_, along_sigmas_ * sigma_px_, sigma_px_, along_sigmas_},
        edges_, free_, wanted_);
    if (!found) return false;
    for (size_t number = 0; number < kRigNumbers; ++number) {
      if (free_[number]) deviations_[number] = found->if_others_stay[number];
      if (seen_[number]) totals_[number] = found->all[number];
    }
    return true;
  }

  // Takes out the number that is known least, if it is not seen. @returns whether there was one.
  bool TakeOutUnseen() {
    const auto share = [&](size_t number) {
      return deviations_[number] / RowOf(static_cast<RigNumber>(number)).expected;
    };
    const std::optional<size_t> worst = LargestFree(share);
    if (!worst || share(*worst) <= kSeen) return false;
    TakeOut(*worst);
    seen_[*worst] = false;
    deviations_[*worst] = totals_[*worst] = RowOf(static_cast<RigNumber>(*worst)).expected;
    return true;
  }

  // Takes out the least significant change, if it may be chance. @returns whether there was one.
  bool TakeOutInsignificant() {
    const auto chance = [&](size_t number) {
      return deviations_[number] / std::max(std::abs(numbers_[number]), 1e-300);
    };
    const std::optional<size_t> worst = LargestFree(chance);
    if (!worst || chance(*worst) <= 1 / kSureChangeSigmas) return false;
    TakeOut(*worst);
    return true;
  }

  template <typename Value>
  std::optional<size_t> LargestFree(const Value& value) const {
    std::optional<size_t> largest;
    for (size_t number = 0; number < kRigNumbers; ++number) {
      if (free_[number] && (!largest || value(number) > value(*largest))) largest = number;
    }
    return largest;
  }

  void TakeOut(size_t number) {
    free_[number] = false;
    numbers_[number] = 0;
  }

  const RawRig& rig_;
  const std::vector<SceneMatch>& matches_;
  const std::optional<EdgeShift>& edges_;
  const Wanted& wanted_;
  Wanted free_;
  Wanted seen_;
  RigNumbers numbers_{};
  RigNumbers deviations_{};
  RigNumbers totals_{};  // deviations, also of where the ToF camera stands
  std::vector<double> depths_;
  double sigma_px_ = 1;
  double along_sigmas_ = 1;  // scatter along the rays, in units of what rows and planes show
};

}  // namespace

std::vector<MatchResidual> ResidualsOf(const RawRig& rig, const std::vector<SceneMatch>& matches,
                                       const std::vector<double>& inverse_depths,
                                       const RigNumbers& change) {
  const double* numbers = change.data();
  std::vector<MatchResidual> residuals(matches.size());
  for (size_t i = 0; i < matches.size(); ++i) {
    const MatchError match{rig, matches[i], 1, 1};
    const auto at = [&](double inverse_depth, double* residual) {
      return match(numbers + kPitch, numbers + kPlaceY, numbers + kFocal, &inverse_depth, residual);
    };
    // Along the epipolar line to where only the distance across it is left: one step of Newton's,
    // since pixels are nearly linear in the inverse depth.
    const double step = 1e-4 * std::max(inverse_depths[i], 1e-3);
    double here[2]{};
    double there[2]{};
    if (!at(inverse_depths[i], here) || !at(inverse_depths[i] + step, there)) continue;
    const Eigen::Vector2d along((there[0] - here[0]) / step, (there[1] - here[1]) / step);
    const Eigen::Vector2d off(here[0], here[1]);
    const double moved = -along.dot(off) / along.squaredNorm();
    const Eigen::Vector2d across = off + moved * along;
    residuals[i].rows_px = across.y();
    if (!matches[i].tof) continue;
    const PatchError patch{rig, matches[i], 1};
    const auto tof_at = [&](double inverse_depth, double* off_m) {
      return patch(numbers + kFocal, numbers + kTofPitch, numbers + kRangeOffset, &inverse_depth,
                   off_m);
    };
    const double stereo = inverse_depths[i] + moved;
    double off_m = 0;
    double off_step_m = 0;
    if (!tof_at(stereo, &off_m) || !tof_at(stereo + step, &off_step_m)) continue;
    // d(off)/d(inverse depth), and pixels a unit of inverse depth.
    const double m_per_inverse = (off_step_m - off_m) / step;
    residuals[i].tof_m = -off_m;
    residuals[i].tof_px = -off_m / m_per_inverse * along.norm();
  }
  return residuals;
}

Result<AdjustedScene> AdjustScene(const RawRig& rig, const std::vector<SceneMatch>& matches,
                                  const std::optional<EdgeShift>& edges, const Wanted& wanted,
                                  bool only_sure) {
  return Adjustment(rig, matches, edges, wanted).Run(only_sure);
}

}  // namespace sprout::calibrate
