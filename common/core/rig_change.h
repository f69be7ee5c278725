#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "common/core/frame_id.h"

namespace sprout {

/// Three numbers of a change, and their standard deviations.
struct SeenTurn {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();           ///< rotation vector, rad
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(-1.0);  ///< of each; −1 = not shown

  bool operator==(const SeenTurn&) const = default;
};

/// By how much a rig differs from its calibration; field by field as in lcmtypes/rig_change_t.lcm.
struct RigChange {
  enum class Verdict { kUnseen = 0, kRight = 1, kWrong = 2 };

  FrameId newest_frame = {};  ///< rig_id: the calibration that differs
  std::string reason = {};    ///< of kUnseen
  Verdict verdict = Verdict::kUnseen;
  int32_t frames = 0;
  int32_t matches = 0;
  int32_t tof_matches = 0;
  float rows_px = 0;
  float rows_spread_px = 0;
  float rows_sigma_px = -1;
  SeenTurn right = {};
  SeenTurn tof = {};
  double range_offset_m = 0;
  double range_sigma_m = -1;

  bool operator==(const RigChange&) const = default;
};

}  // namespace sprout
