#ifndef SPROUT_TESTS_SERVICES_GROW_PLAIN_CONFIDENCE_H_
#define SPROUT_TESTS_SERVICES_GROW_PLAIN_CONFIDENCE_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/core/disparity_image.h"
#include "common/core/seed.h"

namespace sprout::grow {

/// Formula C1 with OpenCV, one map after the other: what ConfidenceEstimator must give to the byte.
cv::Mat1b PlainConfidence(const cv::Mat1b& left, const cv::Mat1b& right,
                          std::span<const Seed> seeds, const DisparityImage& grown,
                          const DisparityImage& filled, double sigma_s_squared);

}  // namespace sprout::grow

#endif  // SPROUT_TESTS_SERVICES_GROW_PLAIN_CONFIDENCE_H_
