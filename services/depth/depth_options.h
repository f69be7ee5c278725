#ifndef SPROUT_SERVICES_DEPTH_DEPTH_OPTIONS_H_
#define SPROUT_SERVICES_DEPTH_DEPTH_OPTIONS_H_

#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/rig/rig_file.h"
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

/// Reads the rig file if there is one.
/// @throws ConfigError for a value out of range, for what does not go together, for a rig file that
/// cannot be used, and when nothing is to be published.
DepthOptions OptionsOf(const DepthConfig& config);

/// Why a frame's calibration is not the rig file's, so that what depends on both would be wrong;
/// empty when it is.
std::string RigComplaint(const DepthOptions& options, const RectifiedPair& pair);

}  // namespace sprout::depth

#endif  // SPROUT_SERVICES_DEPTH_DEPTH_OPTIONS_H_
