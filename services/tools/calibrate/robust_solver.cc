#include "services/tools/calibrate/robust_solver.h"

#include <cmath>
#include <memory>
#include <utility>

#include "common/core/quantile.h"

namespace sprout::calibrate {

double RobustSigma(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values.empty() ? 0 : 1.4826 * Median(std::move(values));
}

bool Solve(ceres::Problem& problem, const std::vector<double*>& many,
           const std::vector<double*>& few, const SolverEnd& end) {
  ceres::Solver::Options options;
  options.num_threads = 1;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = end.iterations;
  options.function_tolerance = end.tolerance;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (double* block : many) options.linear_solver_ordering->AddElementToGroup(block, 0);
  for (double* block : few) options.linear_solver_ordering->AddElementToGroup(block, 1);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.IsSolutionUsable();
}

ceres::Covariance::Options CovarianceOptions(ceres::SparseLinearAlgebraLibraryType library) {
  ceres::Covariance::Options options;
  options.num_threads = 1;
  options.algorithm_type = ceres::SPARSE_QR;
  options.sparse_linear_algebra_library_type = library;
  return options;
}

}  // namespace sprout::calibrate
