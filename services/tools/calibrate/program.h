#pragma once

namespace sprout::calibrate {

/// The main of sprout-calibrate.
/// @returns exit code: 0; 1 when a calibration is not good enough or impossible, and for any other
///          failure; 2 for flags and files that cannot be used, with one line on stderr.
int CalibrateMain(int argc, const char* const* argv);

}  // namespace sprout::calibrate
