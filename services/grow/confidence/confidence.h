#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "common/core/seed.h"
#include "services/grow/confidence/confidence_kernel.h"
#include "services/grow/confidence/confidence_model.h"

namespace sprout::grow {

/// What the chain knows of a frame when its map is judged.
struct JudgedFrame {
  const cv::Mat1b& left;  ///< rectified pair, grey, of the map's size
  const cv::Mat1b& right;
  std::span<const Seed> seeds;   ///< that growth started from
  const cv::Mat1b& sigma_prior;  ///< PriorMap::sigma, of the map's size; empty: not known
  const DisparityImage& grown;   ///< the map before gap filling
  const DisparityImage& filled;  ///< the map after it, which is judged
};

/// How wrong a map's disparities are. At each pixel the error is a mixture,
///
///   d − d_true ~ (1 − p) · N(0, σ²) + p · wide.                                           (C1)
///
/// p, the probability of an error > 1 px, is logistic, and σ, which 68 % of the errors do not
/// exceed, log-linear in curves of ten features (README, C2 and C3), whose numbers
/// scripts/tune_confidence fits to scenes with ground truth.
class ConfidenceEstimator {
 public:
  explicit ConfidenceEstimator(const ConfidenceTables& tables = DefaultConfidenceTables())
      : tables_(tables) {}

  struct Judgement {
    cv::Mat1b confidence;  ///< 255 · (1 − p); 0 where there is no disparity
    cv::Mat1b sigma;       ///< counts of 1/16 px; kMaxSigmaCounts where there is no disparity
  };

  /// @returns both for each pixel of the left image: one value for each cell of 2×2 pixels.
  ///          O(pixels), 3 ns each on one core; on OpenCV's threads with the same bytes for any
  ///          number. Keeps 4 bytes a pixel from frame to frame, so one object serves one caller at
  ///          a time.
  Judgement Compute(const JudgedFrame& frame);

  /// The features of the frame of the last Compute(), for scripts/tune_confidence.
  const ConfidenceFeatures& features() const { return features_; }

 private:
  void Prepare(cv::Size size);
  void SpreadSeeds(std::span<const Seed> seeds);
  void AverageBends();

  const ConfidenceTables& tables_;
  ConfidenceFeatures features_;
  std::vector<uint8_t> edge_memory_, seed_memory_;
  std::vector<int32_t> column_sums_;  // of bends
  Judgement judgement_;
};

/// Removes the disparities whose confidence is below a bound. Pixels without a disparity stay so.
/// @param least  0 (all stay) to 255. O(pixels).
void DropUnsure(const cv::Mat1b& confidence, int least, DisparityImage& disparity);

}  // namespace sprout::grow
