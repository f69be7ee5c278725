#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/scenes/frame_source.h"

namespace sprout::scenes {

/// True disparities, px of the image they belong to; NaN = unknown.
struct GroundTruth {
  cv::Mat1f left;   ///< d = u − u' at the pixels of the left image
  cv::Mat1f right;  ///< the same at the pixels of the right image; empty when not known
  /// Pixels of the left image that the right camera also sees (255), if the data set has them;
  /// empty = computed from the maps.
  cv::Mat1b nonoccluded = {};
};

/// A frame of a data set or a simulation: what cameras would give, and the truth.
struct DatasetFrame : CapturedFrame {
  GroundTruth truth;  ///< left map empty when the dataset knows none
  /// Unambiguous range of a simulated ToF camera, m along the ray; 0 = ranges are unambiguous.
  double unambiguous_range_m = 0;
};

/// Frames that can be read in any order and again: files, a simulation.
class Dataset {
 public:
  virtual ~Dataset() = default;

  /// Calibration; the same for all frames.
  virtual const Rig& rig() const = 0;

  /// Number of frames; nothing = endless.
  virtual std::optional<int64_t> frame_count() const = 0;

  /// Frame `index` (from 0, below frame_count()). The same index gives the same bytes at every
  /// call.
  virtual DatasetFrame Get(int64_t index) = 0;
};

/// Opens the dataset that config.source() names.
///   middlebury:DIR  a Middlebury scene: view1/view5/disp1/disp5 with dmin.txt (2005, 2006),
///                   im2/im6/disp2/disp6 (2003), or im0/im1/disp0.pfm or disp0GT.pfm with calib.txt
///                   (2014, 2021, ETH3D); images as .png, .jpg, .ppm or .pgm
///   kitti:DIR/ID, kitti:DIR  a frame, or all frames, in KITTI's layout with the scan as ToF image;
///                   ?beams=N keeps N of its 64 beams
///   synthetic:WxH   a moving scene with exact ground truth
/// The range sensor is simulated by config.tof(), or by ?tof=grid, ?tof=sr4000 or ?tof=zones:CxR
/// after the source; with ?tof=none there is none. ?tof=sr4000 may be followed by &blind=P,
/// &wrapped=P, &calibration=PX and &every=K, see Sr4000Config; ?tof=zones:CxR by &mode=mean,
/// &mode=nearest and &targets=N, see ZonesConfig; any other, also a scan, by what its ranges are
/// off by, such as &range=MM, see RangeErrorsConfig.
/// @throws ConfigError naming what is missing or wrong, and where.
std::unique_ptr<Dataset> OpenDataset(const CaptureConfig& config);
/// Opens a source with the default settings.
std::unique_ptr<Dataset> OpenDataset(const std::string& source);

/// The frames of a data set one after the other, as from a camera; without times.
/// @param loop  start again at the end.
std::unique_ptr<FrameSource> PlayDataset(std::unique_ptr<Dataset> dataset, bool loop);

}  // namespace sprout::scenes
