#ifndef SPROUT_SERVICES_CAPTURE_VIDEO_SOURCE_H_
#define SPROUT_SERVICES_CAPTURE_VIDEO_SOURCE_H_

#include <memory>
#include <string>
#include <vector>

#include "services/capture/raw_source.h"

namespace sprout::capture {

/// What OpenCV's VideoCapture opens.
struct VideoSettings {
  /// Left and right camera, or one with both views side by side: a video, an image list
  /// (left_%04d.png), a device (a number, /dev/video0).
  std::vector<std::string> places;
  bool loop = false;  ///< start files again at the end
  /// Requested from a device, for the whole picture; 0 = its own choice.
  int width = 0;   ///< px
  int height = 0;  ///< px
  double fps = 0;  ///< Hz
};

/// Images of a stereo camera or of recordings, without a clock and without a ToF camera. Two files
/// end with the shorter one; a lost device is opened again, with a try every second.
/// @throws ConfigError naming what cannot be opened.
std::unique_ptr<RawSource> OpenVideo(const VideoSettings& settings);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_VIDEO_SOURCE_H_
