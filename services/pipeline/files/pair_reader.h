#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/picture/eight_bits.h"
#include "common/rig/rectifier.h"
#include "common/scenes/kitti_calibration.h"
#include "services/capture/video_pictures.h"
#include "services/pipeline/files/image_pairs.h"

namespace sprout {

/// The calibration: a rig file, or of a pair that is rectified already a calib.txt, or focal length
/// and baseline.
struct RigOptions {
  std::string rig_file = {};
  std::string calib_file = {};  ///< see scenes::OpenCalibFile()
  std::optional<double> focal_px = {};
  std::optional<double> baseline_m = {};
  std::optional<double> cx = {};        ///< of the left image, px; otherwise its middle
  std::optional<double> cx_right = {};  ///< of the right image, px; otherwise cx
  std::optional<double> cy = {};        ///< of both images, px; otherwise their middle
  /// Lens and pose of the ToF camera of a pair that is rectified already, see TofCameraOf(); empty:
  /// it shows what the left image shows.
  std::string tof_rig_file = {};
};

/// What the numbers of the files stand for.
struct PixelOptions {
  int bits = 0;               ///< see EightBits
  std::string tof_unit = {};  ///< see scenes::ParseRangeUnit(); empty: mm of integers, else m
};

/// Turns image files into the parts LEFT, RIGHT, TOF and RIG of a frame. With a rig file the images
/// are raw and are rectified here. Otherwise they are rectified already, and the ToF image has the
/// left camera's position and field of view, at any resolution, unless a file says more.
class PairReader {
 public:
  /// @throws ConfigError for a calibration that is missing or cannot be used, and for a unit that
  ///         is none.
  explicit PairReader(const RigOptions& options, const PixelOptions& pixels = {});

  /// @returns the frame, without a number, or what is wrong with a file.
  Result<Frame> Read(const ImagePair& pair);

  /// What a user should know of the pairs read since the last call, one line; mostly empty.
  std::string TakeNote();

 private:
  // A video, and the number of its next picture.
  struct OpenVideo {
    std::unique_ptr<capture::Pictures> pictures;
    int64_t next = 0;
  };

  Result<CameraImage> ReadView(const std::filesystem::path& path, int64_t number, OpenVideo& video);
  Result<void> Rectify(Frame& frame) const;
  Result<void> CheckFirstSize(cv::Size size);
  Result<RectifiedPair> PairOf(const cv::Mat& left);
  void NoteOblong(cv::Size tof, cv::Size left);
  Result<void> Calibrate(Frame& frame);

  RigOptions options_;
  EightBits eight_bits_;
  std::string note_;  // see TakeNote()
  bool noted_oblong_ = false;
  cv::Size first_size_;  // of left images that have the focal length of the options
  std::optional<double> tof_unit_m_;
  scenes::PairCalibration calibration_;  // of options_.calib_file
  OpenVideo left_video_, right_video_;
  std::optional<Rectifier> rectifier_;
  std::optional<TofCamera> tof_camera_;     // of a rectified pair
  std::optional<Rectifier> tof_rectifier_;  // where its file has the whole rig
};

}  // namespace sprout
