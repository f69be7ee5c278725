#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "tests/common/rig/tilted_rig.h"

namespace sprout::capture {

inline cv::Mat Picture(cv::Size size, int grey) { return {size, CV_8UC3, cv::Scalar::all(grey)}; }

/// A frame of the cameras of TiltedRig(), of a grey wall 2 m away.
inline scenes::CapturedFrame RawFrame(int grey) {
  const RawRig rig = TiltedRig();
  scenes::CapturedFrame frame;
  frame.left = Picture(rig.left.size(), grey);
  frame.right = Picture(rig.right.size(), grey);
  frame.tof.depth_m = cv::Mat1f(rig.tof.size(), 2.f);
  return frame;
}

/// TiltedRig(), the right camera turned down by half a degree: other maps and another calibration.
inline RigInUsePtr TurnedRig() {
  RawRig rig = TiltedRig();
  rig.left_from_right = TurnedBy(rig.left_from_right, {-0.009, 0, 0});
  return std::make_shared<const RigInUse>(RigInUse{Rectifier(rig), "turned"});
}

}  // namespace sprout::capture
