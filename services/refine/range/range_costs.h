#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "common/core/seed.h"
#include "services/refine/range/range_rules.h"
#include "services/refine/stereo/patch_matcher.h"

namespace sprout::refine {

/// How well the images agree with a small piece of surface at each offset of its disparity,
/// RangeRules::OffsetPx(0) to OffsetPx(kLabels − 1): 0, equal windows, to 1, nothing in common.
using OffsetCosts = std::array<float, RangeRules::kLabels>;

/// What the windows around a small piece of surface show at each of those offsets.
struct OffsetMoments {
  float left_variance = 0;  ///< of the left window, grey levels²
  std::array<float, RangeRules::kLabels> right_variance = {};  ///< of the right one
  std::array<float, RangeRules::kLabels> covariance = {};      ///< of both
};

/// Eq. (R4). @param noise  variance of the images' noise, grey levels². O(1).
OffsetCosts CostsOf(const OffsetMoments& moments, double noise);

/// The windows around a range point's surface.
/// @param left, right  rectified pair, grey, of one size.
/// @returns nothing where a window leaves an image, and for slopes above 0.4 px a px. The same on
/// every machine. O(1); thread-safe.
std::optional<OffsetMoments> MomentsOf(const cv::Mat1b& left, const cv::Mat1b& right,
                                       const SlantedPatch& patch);

/// Whether the windows of a match, or of one a px beside it, are as alike as (R10) asks for; where
/// one image is blurred they are not. @param noise  as of CostsOf(). O(1); thread-safe.
bool IsAlike(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& match, double noise);

}  // namespace sprout::refine
