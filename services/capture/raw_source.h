#pragma once

#include <memory>
#include <string>

#include "common/app/log.h"
#include "common/scenes/frame_source.h"
#include "services/capture/current_rig.h"

namespace sprout::capture {

/// Cameras: raw triplets, neither rectified nor with corrected ranges.
using RawSource = scenes::TripletSource;

/// Rectified frames of cameras, each with the rig that is current when it comes. A frame of another
/// size than the calibrated one counts as lost.
std::unique_ptr<scenes::FrameSource> Rectified(std::unique_ptr<RawSource> cameras,
                                               std::shared_ptr<CurrentRig> rig);

/// Reports why cameras are waited for: to `waiting`, or in the log where that is empty.
inline void TellWaiting(const scenes::Waiting& waiting, const std::string& reason) {
  if (waiting) {
    waiting(reason);
  } else {
    LogLine(LogLevel::kWarning, "{}", reason);
  }
}

/// Cameras, and the calibration that belongs to them.
struct OpenedCameras {
  std::unique_ptr<RawSource> cameras;
  std::shared_ptr<CurrentRig> rig;  ///< null when there is no calibration yet
};

/// Whether a source names cameras: genicam:, opencv: or v4l2:.
bool NamesCameras(const std::string& source);

/// Opens the cameras that a source names.
///   genicam:RIG        GigE Vision and USB3 Vision cameras: those of a rig file (OpenGenicam())
///   opencv:LEFT,RIGHT  two videos, image lists (left_%04d.png) or devices that OpenCV opens
///   opencv:BOTH        one that has both views side by side
///   v4l2:DEVICE        a UVC stereo camera, both views side by side; &width=, &height= and &fps=
///                      behind it: the size of the whole picture
/// ?rig=FILE behind it, other than genicam:, names the rig file with the calibration.
///
/// @param loop     start files again at the end.
/// @param waiting  called while cameras of genicam: are waited for; what OpenCV opens waits by
///                 itself, and calls once.
/// @param calibrated  false: no calibration is looked at, so that a rig whose calibration is
///                    useless can be calibrated again.
/// @throws ConfigError naming what is missing or wrong, and where.
OpenedCameras OpenCameras(const std::string& source, bool loop, scenes::Waiting waiting = {},
                          bool calibrated = true);

}  // namespace sprout::capture
