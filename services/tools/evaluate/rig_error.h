#pragma once

#include <string>

#include "services/tools/calibrate/scene/rig_change.h"
#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {

/// A right camera that was knocked since the rig was calibrated, as --rig-error names it.
///   rows=N     its image lies N px lower
///   roll=N     it is rolled by N degrees
///   yaw=N      it looks N degrees to the side
/// behind it, what is known of that: nothing; ?refined: what sprout-calibrate refine finds in the
/// frame; ?known: the error itself.
class RigError {
 public:
  /// @throws ConfigError naming the flag, the value and what is allowed.
  explicit RigError(const std::string& text);

  /// Knocks the right camera of a scene, and rectifies its image again with what is known. The left
  /// view stays, and so does the truth.
  /// @throws ConfigError when a refinement refuses the scene.
  void Apply(Scene& scene) const;

 private:
  enum class Known { kNothing, kRefined, kAll };

  calibrate::RigNumbers error_{};
  Known known_ = Known::kNothing;
};

}  // namespace sprout::evaluate
