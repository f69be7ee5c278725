#ifndef SPROUT_SERVICES_TOOLS_QUALITY_MEASUREMENT_H_
#define SPROUT_SERVICES_TOOLS_QUALITY_MEASUREMENT_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/rig.h"
#include "common/measure/target_meter.h"

namespace sprout::quality {

/// A disparity map as logs, the bus and files have it.
struct MeasuredMap {
  cv::Mat1f disparity_px;  ///< NaN or infinite = none
  cv::Mat1b sigma;         ///< as PriorMap has it, of the map's size, or empty
  RectifiedPair pair;      ///< of the map's size
};

/// A measurement of one target: the meter, the newest map, and what was left out. All maps have the
/// size and the calibration of the first one.
class Measurement {
 public:
  explicit Measurement(TargetSettings settings) : settings_(std::move(settings)) {}

  /// @throws ConfigError when the region does not lie in the first map.
  void Add(const MeasuredMap& map);

  /// A map that could not be taken since no calibration is known for it.
  void AddWithoutCalibration() { ++without_calibration_; }

  const TargetSettings& settings() const { return settings_; }
  bool empty() const { return !meter_; }
  /// @pre !empty().
  const TargetMeter& meter() const { return *meter_; }
  const cv::Mat1f& newest_px() const { return newest_px_; }

  int64_t other_size() const { return other_size_; }  ///< of another size or calibration
  int64_t without_calibration() const { return without_calibration_; }

  /// What was left out, one line; empty: nothing.
  std::string LeftOutText() const;

 private:
  TargetSettings settings_;
  std::optional<TargetMeter> meter_;
  std::string rig_id_;
  cv::Mat1f newest_px_;
  int64_t other_size_ = 0;
  int64_t without_calibration_ = 0;
};

}  // namespace sprout::quality

#endif  // SPROUT_SERVICES_TOOLS_QUALITY_MEASUREMENT_H_
