#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/picture/read_image.h"

namespace sprout::capture {

/// Pictures, one after the other.
class Pictures {
 public:
  virtual ~Pictures() = default;

  /// Takes the next picture. @returns whether there was one.
  virtual bool Grab() = 0;

  /// The picture that was taken; empty when it cannot be decoded.
  /// @throws ConfigError for one that cannot be used.
  virtual CameraImage Retrieve() = 0;

  /// When it is shown, µs since the first one; nothing: not known.
  virtual std::optional<int64_t> Time() const { return std::nullopt; }

  /// How long ago a device took it, by its driver; nothing: not known.
  virtual std::optional<std::chrono::microseconds> Age() const { return std::nullopt; }

  /// Pictures a second; 0: not known.
  virtual double Rate() const { return 0; }

  /// What is wrong with the end; empty when nothing is.
  virtual std::string EndText() const { return {}; }
};

/// The files that a pattern of glob() names, in any order.
std::vector<std::string> FilesMatching(const std::string& pattern);

/// Opens a list of files, each of which is a picture.
std::unique_ptr<Pictures> OpenImages(std::vector<std::string> files);

/// What is requested from a device; 0 = its own choice.
struct PictureMode {
  int width = 0;   ///< px
  int height = 0;  ///< px
  double fps = 0;  ///< Hz
};

/// Opens a video file, or a device (a number, or /dev/video0).
/// @returns null when it cannot be opened.
/// @throws ConfigError for pictures that are too large.
std::unique_ptr<Pictures> OpenVideoPictures(const std::string& place,
                                            const PictureMode& device = {});

/// Takes the newest picture and drops those before it, which the queue of a device keeps for a
/// reader that is slower than the camera.
/// @returns whether there is one.
bool GrabNewest(Pictures& pictures);

/// Whether a place is a device.
bool IsDevice(const std::string& place);

}  // namespace sprout::capture
