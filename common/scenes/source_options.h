#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/config/config_error.h"

namespace sprout::scenes {

/// A source that cannot be used: "capture.source = log:FILE?a=1: no such option a=1; allowed: ...".
ConfigError BadSource(const std::string& source, const std::string& reason,
                      const std::string& allowed);

/// One "name=value" after the '?' of a source.
struct SourceOption {
  std::string_view text;  ///< all of it
  std::string_view name;
  std::string_view value;  ///< empty when there is no '='
};

/// The options of "a=1&b=2", as views of the text.
/// @throws ConfigError when one is given twice.
std::vector<SourceOption> SourceOptions(std::string_view text);

/// A source, split into its name and its options.
struct SplitSourceText {
  std::string place;                  ///< "log:FILE"
  std::vector<SourceOption> options;  ///< views of the source's text
};

/// Splits at the last '?', since a file's name may contain one, too.
/// @throws ConfigError as SourceOptions().
SplitSourceText SplitSource(std::string_view source);

/// The simulated multi-zone sensor, as CaptureConfig.tof names it once its size is in
/// CaptureConfig.zones.
inline constexpr std::string_view kZones = "zones";

/// Reads "zones:CxR" (or "zones", which leaves the size as it is) into tof and zones.
/// @returns whether the text begins like that.
/// @throws ConfigError when the size is none or out of range.
bool ApplyZones(std::string_view tof, CaptureConfig& config);

/// The options allowed after "zones:CxR", for messages to people.
inline constexpr std::string_view kZonesOptions = "&mode=mean or nearest, &targets=N";

/// The options allowed after "sr4000", for messages to people.
inline constexpr std::string_view kSr4000Options =
    "&blind=P (%), &wrapped=P (%), &calibration=PX, &every=K, &amplitude=MM, &multipath=SHARE, "
    "&scatter=SHARE, &motion=SHARE";

/// The options of any range image, for messages to people.
inline constexpr std::string_view kRangeErrorOptions =
    "&range=MM, &wiggle=MM, &period=M, &bumps=PX, &unit=F, &mirrored";

/// The options of a recorded scan, for messages to people.
inline constexpr std::string_view kScanOptions =
    "&range=M, &yaw=DEGREES, &pitch=DEGREES, &bumps=PX, &unit=F, &mirrored";

/// Applies an option of the ToF camera that config.tof() names: one of those above.
/// @param is_scan  the ranges are a recorded scan.
/// @returns whether the camera has such an option.
/// @throws ConfigError when the value is not allowed, no number or out of range.
bool ApplyTofOption(const SourceOption& option, bool is_scan, CaptureConfig& config);

}  // namespace sprout::scenes
