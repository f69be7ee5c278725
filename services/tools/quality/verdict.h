#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/core/rig.h"
#include "common/measure/target_meter.h"
#include "common/measure/target_quality.h"

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

/// The range in which a figure must lie.
struct Limit {
  const TargetFigure* figure = nullptr;
  std::optional<double> at_least;  ///< in the figure's unit; one of the two or both
  std::optional<double> at_most;

  /// Whether the figure lies in the range, ends included; false when it was not measured.
  bool IsKept(const TargetQuality& quality) const;

  /// ">= 98", "<= 0.5", "-1 to 1".
  std::string Text() const;
};

/// Reads a file of TargetLimits (common/measure/target_limits.proto).
/// @throws ConfigError for a file that cannot be read, an unknown figure, a figure that has two
///         limits, bounds that are missing, no numbers or the wrong way round, and no limit at all.
std::vector<Limit> LoadLimits(const std::filesystem::path& path);

/// Whether a plane was found, see TargetComplaint(), and every limit is kept.
bool IsGood(const TargetQuality& quality, std::span<const Limit> limits);

/// The figures that were measured, a line each, and those that have a limit, with their limits and
/// whether these are kept. Begins with region and frames. @pre !measurement.empty().
std::string TableText(const Measurement& measurement, std::span<const Limit> limits);

/// The same for programs: figures by name, null where not measured. @param input  what was
/// measured.
std::string JsonText(const Measurement& measurement, std::span<const Limit> limits,
                     const std::string& input);

/// Why figures that people expect may be missing, one line each; empty: none is.
std::string MissingText(const TargetQuality& quality, const TargetSettings& settings);

}  // namespace sprout::quality
