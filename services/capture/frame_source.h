#ifndef SPROUT_SERVICES_CAPTURE_FRAME_SOURCE_H_
#define SPROUT_SERVICES_CAPTURE_FRAME_SOURCE_H_

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"

namespace sprout {

/// True disparities, px of the image they belong to; NaN = unknown.
struct GroundTruth {
  cv::Mat1f left;   ///< d = u − u' at the pixels of the left image
  cv::Mat1f right;  ///< the same at the pixels of the right image; empty when not known
  /// Pixels of the left image that the right camera sees too, 255, where the data set says so;
  /// empty = to be found out from the maps.
  cv::Mat1b nonoccluded = {};
};

/// One synchronised, rectified triplet, as a camera driver would hand it over.
struct CapturedFrame {
  cv::Mat left;       ///< 8UC1 or 8UC3 (BGR), rectified
  cv::Mat right;      ///< 8UC1 or 8UC3 (BGR), rectified, of the same size
  TofImage tof;       ///< 0×0, as the rig's, without a ToF camera
  GroundTruth truth;  ///< left map empty when the source knows none
  /// Of a simulated ToF camera whose ranges are known only modulo this, m along the ray; 0 =
  /// another.
  double unambiguous_range_m = 0;
};

/// Where frames come from: a dataset, a simulation, a recording, a camera.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Calibration; the same for all frames.
  virtual const Rig& rig() const = 0;

  /// Number of frames; nothing = endless.
  virtual std::optional<int64_t> frame_count() const = 0;

  /// Frame `index` (from 0, below frame_count()). The same index gives the same bytes at every
  /// call, so a frame can be sent again.
  virtual CapturedFrame Get(int64_t index) = 0;
};

/// Opens the source that config.source() names.
///   middlebury:DIR  a Middlebury scene: view1/view5/disp1/disp5 with dmin.txt (2005, 2006), or
///                   im0/im1/disp0.pfm with calib.txt (2014); images as .png, .jpg or .ppm
///   kitti:DIR/ID, kitti:DIR  a frame, or all frames, in KITTI's layout with the scan as ToF image;
///                   ?beams=N keeps N of its 64 beams
///   synthetic:WxH   a moving scene with exact ground truth
/// The ToF camera is simulated as config.tof() says, or as ?tof=grid or ?tof=sr4000 behind the
/// source does; with none there is no ToF camera. Several options are separated by '&': behind
/// ?tof=sr4000 &blind=P, &wrapped=P and &calibration=PX, see Sr4000Config.
/// @throws ConfigError naming what is missing or wrong, and where.
std::unique_ptr<FrameSource> OpenFrameSource(const CaptureConfig& config);

}  // namespace sprout

#endif  // SPROUT_SERVICES_CAPTURE_FRAME_SOURCE_H_
