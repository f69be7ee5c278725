#pragma once

#include <optional>

#include "common/config/config.h"
#include "common/core/stage_adapter.h"
#include "services/depth/depth_in_view.h"
#include "services/depth/map_filter.h"
#include "services/depth/scan.h"

namespace sprout::depth {

/// The configuration, checked, with what it takes from the rig file.
struct DepthOptions {
  FilterRules filter;
  std::optional<Pose> base_from_left;  ///< of the rig file
  std::optional<View> target;
  std::optional<ScanBand> scan;
  std::optional<RectifiedPair> pair;  ///< of the rig file's calibration, if it has one
};

/// DISPARITY LEFT RIG → DEPTH, CLOUD, TARGET_DEPTH and others, a preview, a scan, as the
/// configuration says; CONFIDENCE is joined for the clouds and for min_confidence, SIGMA for
/// DEPTH_SIGMA. With input FUSED: FUSED and FUSED_CONFIDENCE instead, and no DEPTH_SIGMA.
class DepthAdapter : public StageAdapter {
 public:
  /// @throws ConfigError for a value out of range, for what does not go together, for a rig file
  /// that cannot be used, and when nothing is to be published.
  explicit DepthAdapter(const DepthConfig& config);

  PartSet Inputs() const override;

  /// Answers nothing for a frame that `every` skips, and for one whose images, map and calibration
  /// differ in size; the result says why. Nothing that needs the rig file for a frame of another
  /// calibration.
  StageResult Process(const Frame& frame) override;

 private:
  // The filtered map, with the other parts of its frame.
  struct Seen {
    DisparityImage disparity;
    const RectifiedPair& pair;
    const cv::Mat& left;
    const cv::Mat& confidence;
    const cv::Mat& sigma;
  };

  CloudThinning Thinning() const { return {config_.cloud_stride(), config_.cloud_voxel_m()}; }
  void AddDepths(const Seen& seen, StageResult& result) const;
  // @param is_placed  whether the rig file is of this calibration.
  void AddClouds(const Seen& seen, bool is_placed, StageResult& result) const;
  // Adds the results that need the rig file's places: those of the target camera, and the scan.
  void AddOfOtherPlaces(const Seen& seen, StageResult& result) const;

  DepthConfig config_;
  DepthOptions options_;
  MapFilter filter_;
};

}  // namespace sprout::depth
