#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/geometry/projection.h"
#include "common/scenes/dataset.h"
#include "common/scenes/source_options.h"

namespace sprout::evaluate {

/// Which ToF camera is simulated, as --tof names it.
///   grid:auto    every round(rows / 111)th pixel of the ground truth: 10 at full size, as in the
///                paper, 5 at half and 3 at third
///   grid:auto*K  K times that spacing, rounded
///   grid:N       every Nth pixel
///   sr4000       a camera of its own with the faults of a real one (Sr4000Config); behind it
///                ?blind=P, ?wrapped=P, ?calibration=PX, ?every=K, as in capture's sources
///                behind either ?range=MM and other RangeErrorsConfig, as in capture's sources
///   zones:CxR    a multi-zone sensor (ZonesConfig); behind it ?mode=nearest, &targets=N
///   none         no ToF camera
/// For a scene with a recorded scan (kitti), instead: scan         that none         leave it out
class TofChoice {
 public:
  static constexpr char kNone[] = "none";
  static constexpr char kScan[] = "scan";

  /// @throws ConfigError naming the flag, the value and what is allowed.
  explicit TofChoice(const std::string& text);

  const std::string& text() const { return text_; }

  /// Applies the choice to capture's configuration.
  /// @param rows  of the images, px.
  void Apply(int rows, CaptureConfig& config) const;

 private:
  // @param grid  what stands before the '?'.
  void ReadSpacing(std::string_view grid);

  std::string text_;
  CaptureConfig chosen_;           // the camera and its options
  std::optional<int> spacing_px_;  // nothing: from the rows
  double factor_ = 1;              // on the spacing from the rows
};

/// One frame with ground truth, ready to be run through methods.
struct Scene {
  std::string name;            ///< last part of the folder's path, or the source's text
  scenes::DatasetFrame frame;  ///< images, ToF image, truth
  cv::Mat1b left_grey;         ///< grey image, as used by the stages
  cv::Mat1b right_grey;
  TofProjector projector;  ///< knows the rig
  cv::Mat1b nonoccluded;   ///< the data set's mask, else NonOccludedMask() of its maps
  cv::Mat1b occluded;      ///< pixels that a nearer surface hides from the right camera
  cv::Mat1b away;          ///< 255 = at least kAwayPx from every ToF point
  bool truth_is_scan;      ///< KITTI: beside a ToF point the truth is the point itself
  int max_disparity_px;    ///< largest true disparity, rounded up

  cv::Size size() const { return left_grey.size(); }

  /// Refinement as a user would configure it for the scene's camera: with its unambiguous range,
  /// unless `config` has one.
  RefineConfig WithRange(RefineConfig config) const;
};

/// Where ground truth comes from the range sensor itself (KITTI), pixels nearer than this to a
/// point that a method was given test nothing, px.
inline constexpr double kAwayPx = 3;

/// Whether the scene is in KITTI's layout ("kitti:…"), which has a recorded scan.
bool IsKitti(const std::string& scene);

/// The scenes of one argument: all frames of kitti:DIR; DIR of middlebury:DIR, as capture calls it;
/// otherwise the scene itself.
/// @throws ConfigError when there is none.
std::vector<std::string> ScenesOf(const std::string& scene);

/// Loads frame 0 of a scene.
///
/// @param scene   a Middlebury folder, or a source of capture's that starts with "synthetic:" or
///                "kitti:"; options behind a '?' (?tof=sr4000&blind=50) override `tof`.
/// @param config  its source and ToF camera are replaced.
/// @throws ConfigError naming what is missing or wrong, and where.
Scene LoadScene(const std::string& scene, const TofChoice& tof, CaptureConfig config);

/// Pixels of the left image, with known truth, that the right camera sees, and those that a nearer
/// surface hides from it: 255, else 0.
struct Visibility {
  cv::Mat1b nonoccluded;
  cv::Mat1b occluded;
};

/// From the data set's mask, or by NonOccludedMask() and OccludedMask().
/// @throws ConfigError when its maps differ in size.
Visibility VisibilityOf(const scenes::GroundTruth& truth);

}  // namespace sprout::evaluate
