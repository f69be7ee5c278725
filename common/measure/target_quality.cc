#include "common/measure/target_quality.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

namespace sprout {
namespace {

using Q = TargetQuality;

constexpr std::array kFigures = std::to_array<TargetFigure>({
    {"fill_rate_percent", "fill rate", "%", "pixels with a depth, of all pixels and frames", 2,
     &Q::fill_rate_percent},
    {"distance_m", "distance", "m", "depth of the plane in the middle of the region", 4,
     &Q::distance_m},
    {"plane_distance_m", "distance, square to the plane", "m",
     "of the left camera's centre from the plane", 4, &Q::plane_distance_m},
    {"tilt_horizontal_deg", "tilt, left to right", "°", "> 0: the right side is farther", 2,
     &Q::tilt_horizontal_deg},
    {"tilt_vertical_deg", "tilt, top to bottom", "°", "> 0: the lower side is farther", 2,
     &Q::tilt_vertical_deg},
    {"z_accuracy_percent", "Z-accuracy", "%",
     "error of the distance, of the true one; > 0: measured too far", 3, &Q::z_accuracy_percent},
    {"plane_rms_mm", "plane-fit RMS", "mm", "depth minus that of the plane, without outliers", 3,
     &Q::plane_rms_mm},
    {"plane_rms_percent", "plane-fit RMS", "%", "the same, of the distance", 3,
     &Q::plane_rms_percent},
    {"subpixel_rms_px", "sub-pixel RMS", "px", "disparity minus that of the plane", 4,
     &Q::subpixel_rms_px},
    {"outliers_percent", "outliers", "%", "pixels with a depth that is not the plane's", 3,
     &Q::outliers_percent},
    {"temporal_noise_mm", "temporal noise", "mm",
     "standard deviation of a pixel over the frames, median of the pixels", 3,
     &Q::temporal_noise_mm},
    {"temporal_noise_percent", "temporal noise", "%", "the same, of the distance", 3,
     &Q::temporal_noise_percent},
    {"temporal_noise_95_mm", "temporal noise, 95 %", "mm", "95 % of the pixels have less", 3,
     &Q::temporal_noise_95_mm},
    {"blinking_percent", "blinking pixels", "%",
     "pixels with a depth in some of the frames; not in the temporal noise", 3,
     &Q::blinking_percent},
    {"blinking_noise_mm", "temporal noise of those", "mm", "median", 3, &Q::blinking_noise_mm},
    {"never_valid_percent", "holes", "%", "pixels without a depth in any frame", 3,
     &Q::never_valid_percent},
    {"edge_width_px", "edge width", "px", "from 10 to 90 % of a depth edge, median of its lines", 2,
     &Q::edge_width_px},
    {"sigma_claimed_px", "sigma claimed", "px", "RMS of the standard deviations of the map", 4,
     &Q::sigma_claimed_px},
    {"sigma_ratio", "sigma claimed / seen", "", "1: the map is honest; below: it boasts", 3,
     &Q::sigma_ratio},
    {"within_1_sigma_percent", "within 1 sigma", "%", "68 % for normal noise", 1,
     &Q::within_1_sigma_percent},
    {"within_2_sigma_percent", "within 2 sigma", "%", "95 % for normal noise", 1,
     &Q::within_2_sigma_percent},
});

}  // namespace

std::span<const TargetFigure> TargetFigures() { return kFigures; }

const TargetFigure* FindTargetFigure(std::string_view name) {
  const auto* const found = std::ranges::find(kFigures, name, &TargetFigure::name);
  return found == kFigures.end() ? nullptr : found;
}

std::string TargetText(const TargetFigure& figure, const TargetQuality& quality) {
  const std::optional<double>& value = quality.*figure.value;
  if (!value) return "-";
  return fmt::format("{:.{}f}{}{}", *value, figure.decimals, figure.unit.empty() ? "" : " ",
                     figure.unit);
}

std::string TargetComplaint(const TargetQuality& quality) {
  if (!quality.distance_m) return "no plane: too few pixels of the region have a disparity";
  constexpr double kMaxRmsPx = 1;
  if (!(quality.subpixel_rms_px > kMaxRmsPx)) return "";
  return fmt::format(
      "no plane: pixels lie {:.1f} px beside it (RMS): is the region flat, and its map right?",
      *quality.subpixel_rms_px);
}

}  // namespace sprout
