#ifndef SPROUT_SERVICES_PIPELINE_FILES_PAIR_READER_H_
#define SPROUT_SERVICES_PIPELINE_FILES_PAIR_READER_H_

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/rig/rectifier.h"
#include "services/pipeline/files/image_pairs.h"

namespace sprout {

/// The calibration: a rig file, or focal length and baseline of a pair that is rectified already.
struct RigOptions {
  std::string rig_file = {};
  std::optional<double> focal_px = {};
  std::optional<double> baseline_m = {};
  std::optional<double> cx = {};        ///< of the left image, px; otherwise its middle
  std::optional<double> cx_right = {};  ///< of the right image, px; otherwise cx
};

/// Turns image files into the parts LEFT, RIGHT, TOF and RIG of a frame. With a rig file the images
/// are raw and are rectified here. Otherwise they are rectified already, and the ToF image has the
/// left camera's position and field of view, at any resolution.
class PairReader {
 public:
  /// @throws ConfigError for a calibration that is missing or cannot be used.
  explicit PairReader(const RigOptions& options);

  /// @returns the frame, without a number, or what is wrong with a file.
  Result<Frame> Read(const ImagePair& pair) const;

 private:
  Result<void> Rectify(Frame& frame) const;

  RigOptions options_;
  std::optional<Rectifier> rectifier_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PIPELINE_FILES_PAIR_READER_H_
