#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sprout {

/// How good depth is on a flat target, over the frames of a TargetMeter. What could not be measured
/// is nothing. The formulas, (V1) to (V9), are in services/tools/quality/README.md.
struct TargetQuality {
  int64_t frames = 0;         ///< measured
  int64_t without_plane = 0;  ///< of these: too few disparities for a plane
  std::optional<double> fill_rate_percent = {};
  std::optional<double> distance_m = {};        ///< depth of the plane in the middle of the region
  std::optional<double> plane_distance_m = {};  ///< of the plane from the left camera, square to it
  std::optional<double> tilt_horizontal_deg = {};  ///< > 0: its right side is farther
  std::optional<double> tilt_vertical_deg = {};    ///< > 0: its lower side is farther
  std::optional<double> z_accuracy_percent = {};   ///< > 0: measured too far
  std::optional<double> plane_rms_mm = {};
  std::optional<double> plane_rms_percent = {};
  std::optional<double> subpixel_rms_px = {};
  std::optional<double> outliers_percent = {};
  std::optional<double> temporal_noise_mm = {};
  std::optional<double> temporal_noise_percent = {};
  std::optional<double> temporal_noise_95_mm = {};
  std::optional<double> blinking_percent = {};
  std::optional<double> blinking_noise_mm = {};
  std::optional<double> never_valid_percent = {};
  std::optional<double> edge_width_px = {};
  std::optional<double> sigma_claimed_px = {};
  std::optional<double> sigma_ratio = {};
  std::optional<double> within_1_sigma_percent = {};
  std::optional<double> within_2_sigma_percent = {};
};

/// A figure as tables, files, limits and pages show it.
struct TargetFigure {
  std::string_view name;   ///< "fill_rate_percent": in JSON and limits
  std::string_view title;  ///< "fill rate": for people
  std::string_view unit;
  std::string_view meaning;  ///< for people, one line
  int decimals;              ///< for people; files have all digits
  std::optional<double> TargetQuality::*value;
};

/// All figures, in the order in which they are shown.
std::span<const TargetFigure> TargetFigures();

/// The figure of a name; null when there is none.
const TargetFigure* FindTargetFigure(std::string_view name);

/// A figure for people: with decimals and unit, "-" when it was not measured.
std::string TargetText(const TargetFigure& figure, const TargetQuality& quality);

/// Why these are no figures of a flat target, in one line for people; empty: they are. A target
/// that is flat lies within 1 px RMS of its plane, with any map that is of use.
std::string TargetComplaint(const TargetQuality& quality);

}  // namespace sprout
