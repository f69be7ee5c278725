#pragma once

#include <memory>
#include <string>
#include <vector>

#include "services/capture/raw_source.h"
#include "services/capture/video_pictures.h"

namespace sprout::capture {

/// What OpenCV's VideoCapture opens.
struct VideoSettings {
  /// Left and right camera, or one with both views side by side: a video, an image list
  /// (left_%04d.png), a device (a number, /dev/video0).
  std::vector<std::string> places;
  bool loop = false;        ///< start files again at the end
  PictureMode device = {};  ///< for the whole picture
  int bits = 0;             ///< see EightBits
  /// How much later than the left video the right one begins, ms.
  double offset_ms = 0;
  /// Called once each time a device stops giving pictures.
  scenes::Waiting waiting = {};
};

/// Images of a stereo camera or of recordings, without a clock and without a ToF camera. Images of
/// two lists are joined by PairNames(), pictures of two videos by their times
/// (TripletSynchronizer), which differ by at most half the time between two pictures of the faster
/// one; of devices the newest ones belong together. A lost device is opened again, with a try every
/// second.
/// @throws ConfigError naming what cannot be opened.
std::unique_ptr<RawSource> OpenVideo(const VideoSettings& settings);

}  // namespace sprout::capture
