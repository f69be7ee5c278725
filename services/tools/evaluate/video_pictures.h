#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_VIDEO_PICTURES_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_VIDEO_PICTURES_H_

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "services/tools/evaluate/figure.h"

namespace sprout::evaluate {

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

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_VIDEO_PICTURES_H_
