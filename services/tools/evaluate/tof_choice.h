#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_TOF_CHOICE_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_TOF_CHOICE_H_

#include <optional>
#include <string>
#include <string_view>

#include "common/config/config.h"
#include "common/scenes/source_options.h"

namespace sprout::evaluate {

/// Which ToF camera is simulated, as --tof names it.
///   grid:auto    every round(rows / 111)th pixel of the ground truth: 10 at full size, as in the
///                paper, 5 at half and 3 at third
///   grid:auto*K  K times that spacing, rounded
///   grid:N       every Nth pixel
///   sr4000       a camera of its own with the faults of a real one (Sr4000Config); behind it
///                ?blind=P, ?wrapped=P, ?calibration=PX, ?every=K, as in capture's sources
///                behind either ?range=MM and other RangeErrorsConfig, as in capture's sources
///   zones:CxR    a multi-zone sensor (ZonesConfig); behind it ?mode=nearest, &targets=N
///   none         no ToF camera
/// For a scene with a recorded scan (kitti), instead: scan         that none         leave it out
class TofChoice {
 public:
  static constexpr char kNone[] = "none";
  static constexpr char kScan[] = "scan";

  /// @throws ConfigError naming the flag, the value and what is allowed.
  explicit TofChoice(const std::string& text);

  const std::string& text() const { return text_; }

  /// Applies the choice to capture's configuration.
  /// @param rows  of the images, px.
  void Apply(int rows, CaptureConfig& config) const;

 private:
  // @param grid  what stands before the '?'.
  void ReadSpacing(std::string_view grid);
  // @returns whether the sensor has such an option.
  bool ApplyOption(const scenes::SourceOption& option);

  std::string text_;
  RangeErrorsConfig range_errors_;
  std::optional<Sr4000Config> sr4000_;
  std::optional<ZonesConfig> zones_;
  std::optional<int> spacing_px_;  // nothing: from the rows
  double factor_ = 1;              // on the spacing from the rows
};

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_TOF_CHOICE_H_
