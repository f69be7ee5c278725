#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>

#include "common/config/config.h"
#include "common/scenes/dataset.h"

namespace sprout::scenes {

/// Whether any error is added whose size is in metres, so that a scene has to be metric.
bool HasErrorsInMetres(const CaptureConfig& config);

/// The data set with systematic errors in its range images: offset, wiggling, bumps; then unit and
/// mirroring. Range r is along the ray of the image's pixels. Truth, pair and calibration stay.
///
/// Wiggling is r + a · sin(2π r / p): four samples a period of modulation take its third and fifth
/// harmonic for the first, which changes the phase φ by ±h · sin(4φ) (Lindner and Kolb, "Lateral
/// and depth calibration of PMD-distance sensors", ISVC 2006; Payne et al., "Improved linearity
/// using harmonic error rejection in a full-field range imaging system", SPIE 6805, 2008).
///
/// Points that are moved to no positive depth have no return. Zones are not changed.
/// @param seed  places the bumps.
/// @returns the data set itself when all errors are off.
/// @throws ConfigError when a value is out of range.
std::unique_ptr<Dataset> WithRangeErrors(std::unique_ptr<Dataset> dataset,
                                         const RangeErrorsConfig& config, uint32_t seed);

/// The pose of a scanner (x forward, y left, z up) that is turned by config's yaw and then pitch
/// against what its calibration says.
Eigen::Isometry3d TurnedScanner(const Eigen::Isometry3d& left_from_scanner,
                                const RangeErrorsConfig& config);

}  // namespace sprout::scenes
