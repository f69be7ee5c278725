#include <algorithm>

#include "common/core/checks.h"
#include "common/core/pose_checks.h"
#include "common/messages/convert.h"
#include "common/messages/pose_fields.h"

namespace sprout {

motion_t ToMessage(const FrameId& id, const CameraMotion& motion) {
  motion_t message;
  message.header = ToMessage(id);
  message.last_seq = motion.last_seq;
  message.start_seq = motion.start_seq;
  message.resets = motion.resets;
  message.tracked = motion.tracked;
  message.inliers = motion.inliers;
  message.reset = static_cast<int32_t>(motion.reset);
  FillPose(motion.last_from_left, message.last_from_left_rotation,
           message.last_from_left_translation_m);
  FillPose(motion.start_from_left, message.start_from_left_rotation,
           message.start_from_left_translation_m);
  std::copy(motion.covariance.begin(), motion.covariance.end(), message.covariance);
  return message;
}

Result<CameraMotion> FromMessage(const motion_t& message) {
  CameraMotion motion{.last_from_left = PoseOf(message.last_from_left_rotation,
                                               message.last_from_left_translation_m),
                      .start_from_left = PoseOf(message.start_from_left_rotation,
                                                message.start_from_left_translation_m),
                      .last_seq = message.last_seq,
                      .start_seq = message.start_seq,
                      .tracked = message.tracked,
                      .inliers = message.inliers,
                      .reset = MemoryReset::kNone,
                      .resets = message.resets};
  Checks checks;
  checks.NotNegative("last_seq", message.last_seq)
      .NotNegative("start_seq", message.start_seq)
      .NotNegative("resets", message.resets)
      .NotNegative("tracked", message.tracked)
      .Require(message.inliers >= 0 && message.inliers <= message.tracked, "inliers",
               message.inliers, "0 to tracked")
      .Require(message.reset >= 0 && message.reset < kMemoryResets, "reset", message.reset,
               "one of the RESET constants");
  CheckPoseFields(checks, "last_from_left", motion.last_from_left);
  CheckPoseFields(checks, "start_from_left", motion.start_from_left);
  for (const double value : message.covariance) checks.Finite("covariance", value);
  if (!checks.ok()) return checks.error();
  motion.reset = static_cast<MemoryReset>(message.reset);
  std::copy_n(message.covariance, motion.covariance.size(), motion.covariance.begin());
  return motion;
}

}  // namespace sprout
