#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "services/tools/evaluate/run_pictures.h"
#include "services/tools/evaluate/video_score.h"

namespace sprout::evaluate {

/// What is done with a source, frame after frame.
struct VideoSettings {
  SproutConfig config;                ///< effective; its source is replaced
  int frames = 10;                    ///< at most; a data set may have fewer
  double rate_hz = 10;                ///< of the frames, which have no times of their own
  double image_noise = 0;             ///< standard deviation that both images get, grey levels
  std::filesystem::path images = {};  ///< folder for VideoPictures; empty: none
};

/// A source's figures.
struct VideoResult {
  std::string source;
  int frames = 0;
  VideoFigures single;   ///< each frame by itself
  VideoFigures average;  ///< the running average that RealSense's filter takes
  VideoFigures fused;    ///< sprout-temporal
  bool motion_known = false;
  MotionScore motion;
  double filter_ms = 0;      ///< of a frame, median
  std::string wrong_inputs;  ///< what is wrong with the first frame or its truth; empty: nothing
};

/// Runs the chain and the temporal filter on the frames of a source and scores both, and a rival:
/// the exponential average of librealsense's temporal filter with its defaults (weight of the new
/// frame 0.4, where it is less than 20/32 px from the average; a pixel without a disparity keeps
/// the last one). Scored are the pixels with a known truth, of a recorded scan those away from its
/// points (AwayFromPoints).
/// @param source    as capture's: kitti:DIR?beams=16, synthetic:640x480?tof=sr4000, middlebury:DIR
///                  (the scene again and again, with new noise of the ToF camera).
/// @param on_frame  called before each frame.
/// @throws std::runtime_error for a picture that cannot be written.
VideoResult EvaluateVideo(const std::string& source, const VideoSettings& settings,
                          const std::function<void(int)>& on_frame);

/// A table of the results, and their means.
std::string VideoTable(const std::vector<VideoResult>& results);

/// The maps of a frame that are compared: each frame by itself, the running average, fused; px,
/// NaN = none.
using VideoMaps = std::array<cv::Mat1f, 3>;

/// Names of these, for tables and pictures.
inline constexpr std::array<const char*, 3> kVideoMapNames = {"single", "average", "fused"};

/// A video in two files: NAME_strip.png with the left image and the maps' errors (0 to
/// kLargestErrorPx) of up to six frames, evenly spaced, and NAME.svg with bad 3 over the frames.
class VideoPictures {
 public:
  /// @param source  of the video; NAME is it with '_' for what is no letter, digit, '.' or '-'.
  /// @param frames  of the video.
  VideoPictures(const std::string& source, int frames);

  /// @param mask  pixels that are scored.
  void Add(int frame, const cv::Mat& left, const cv::Mat1f& truth, const cv::Mat1b& mask,
           const VideoMaps& maps);

  /// @throws std::runtime_error naming path and reason.
  void Write(const std::filesystem::path& folder) const;

  /// bad 3 of each frame, %, of each map; NaN where nothing is scored.
  const std::array<std::vector<double>, 3>& bad3_percent() const { return bad3_percent_; }

 private:
  std::string source_;
  int every_;
  std::vector<FigureRow> rows_;
  std::array<std::vector<double>, 3> bad3_percent_;
};

}  // namespace sprout::evaluate
