#pragma once

#include <Eigen/Core>
#include <complex>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout::scenes {

/// What every pixel of a ToF camera sees.
struct LitView {
  cv::Mat1d depth_m;  ///< z along the axis; NaN = nothing
  cv::Mat1d light;    ///< that comes straight back: albedo / z²
  double focal_px;    ///< of the camera
  /// Viewing direction (x, y, 1) of each pixel, by rows.
  const std::vector<Eigen::Vector3d>& directions;
};

/// Light that does not come straight back.
struct StrayLight {
  double multipath = 0;            ///< mean albedo of the second bounce
  double scatter = 0;              ///< share of the mean signal that is added to every pixel
  double unambiguous_range_m = 5;  ///< range whose phase is a whole turn
};

/// By how much a camera that measures the phase of modulated light takes ranges for too long, m
/// along the ray. Signals add up as phasors (Dorrington et al., "Separating true range measurements
/// from multi-path and scattering interference in commercial range cameras", SPIE 7864, 2011):
///
///     P_p = A_p e^(i 2π r_p / R) + Σ_q A_pq e^(i 2π (r_q + |x_p − x_q| + r_p) / 2R)
///     P'_p = (1 − s) P_p + s · mean P
///
/// with A_p the light of pixel p, r its range, R the unambiguous range, s scatter. A_pq is what the
/// camera's light sends to p by way of the patch q (8 × 8 pixels): of a matt surface with the form
/// factor of a disc, cos α_p cos α_q S_q / (π |x_p − x_q|² + S_q), S_q its area. Nothing hides
/// patches from each other, only what the camera sees lights up, and there is no third bounce.
///
/// @returns of the size of the view; 0 where it sees nothing.
/// O(pixels · patches) with multi-path: some 10⁷ for an SR4000; rows in parallel.
cv::Mat1d StrayLightErrorM(const LitView& view, const StrayLight& stray);

/// Amplitude and phase of modulated light.
using Phasor = std::complex<double>;

/// The phasor of amplitude 1 with that phase, turns (1 = 2π): cosine and sine, to 1e-11. Made of
/// sums and products, so that simulated frames have the same bytes on every machine.
Phasor UnitPhasor(double turns);

/// Its phase, turns, −1/2 to 1/2, to 1e-11; 0 for no signal. The inverse of UnitPhasor().
double TurnsOf(const Phasor& phasor);

}  // namespace sprout::scenes
