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

/// Where the cameras stand: a rig file, or the numbers of a pair that is rectified already.
struct RigOptions {
  std::string rig_file = {};
  std::optional<double> focal_px = {};
  std::optional<double> baseline_m = {};
  std::optional<double> cx = {};        ///< of the left image, px; otherwise its middle
  std::optional<double> cx_right = {};  ///< of the right image, px; otherwise cx
};

/// Image files to the parts LEFT, RIGHT, TOF and RIG of a frame. By a rig file the images are as
/// the cameras gave them, and are rectified; otherwise they are rectified, and the ToF image lies
/// in the left camera's place, of any resolution: its corners are the left image's.
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
