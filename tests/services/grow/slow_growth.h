#ifndef SPROUT_TESTS_SERVICES_GROW_SLOW_GROWTH_H_
#define SPROUT_TESTS_SERVICES_GROW_SLOW_GROWTH_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "common/config/config.h"
#include "common/core/prior_map.h"
#include "common/core/seed.h"

namespace sprout {

/// Similarities as the paper prints them, straight from the two 5×5 windows.
double SlowMncc(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d);
double SlowExpssd(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d,
                  double sigma_s_squared);
double SlowPrior(double d, double prior, double sigma_p_px);

/// Alg. 1 in the slowest, most obvious way: every similarity from scratch, in the order and with
/// the costs that Grower promises, whole pixels only. The judge of the fast implementation.
DisparityImage SlowGrow(const GrowConfig& config, const cv::Mat1b& left, const cv::Mat1b& right,
                        std::span<const Seed> seeds, const PriorMap& prior);

}  // namespace sprout

#endif  // SPROUT_TESTS_SERVICES_GROW_SLOW_GROWTH_H_
