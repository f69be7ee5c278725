#pragma once

#include <ceres/ceres.h>

#include <vector>

namespace sprout::calibrate {

// Use of Ceres by both bundle adjustments, with a board and without.

/// Standard deviation of a Gaussian with the same median of |value|; 0 without values.
double RobustSigma(std::vector<double> values);

/// Adds residuals that are divided by their standard deviation; those beyond two of them lose
/// weight (Cauchy's loss): a tenth of the efficiency on Gaussian noise.
/// @tparam kSizes  of the residual and of each block.
template <int... kSizes, typename Error, typename... Blocks>
void AddRobust(ceres::Problem& problem, const Error& error, Blocks*... blocks) {
  constexpr double kLossSigmas = 2;
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Error, kSizes...>(new Error(error)),
                           new ceres::CauchyLoss(kLossSigmas), blocks...);
}

/// The same without a loss: priors.
template <int... kSizes, typename Error, typename... Blocks>
void AddPlain(ceres::Problem& problem, const Error& error, Blocks*... blocks) {
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Error, kSizes...>(new Error(error)),
                           nullptr, blocks...);
}

/// When Solve() ends.
struct SolverEnd {
  int iterations = 50;
  double tolerance = 1e-9;  ///< of the cost, relative
};

/// Minimises on one thread: the same input gives the same bytes.
/// @param many  blocks of one view or point each, which are eliminated first.
/// @param few   all others.
/// @returns whether there is a solution.
bool Solve(ceres::Problem& problem, const std::vector<double*>& many,
           const std::vector<double*>& few, const SolverEnd& end);

/// Covariance of blocks at the solution, on one thread.
ceres::Covariance::Options CovarianceOptions(ceres::SparseLinearAlgebraLibraryType library);

}  // namespace sprout::calibrate
