#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_COVERAGE_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_COVERAGE_H_

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

// What a good calibration needs from its views.
inline constexpr int kFewViews = 15;  ///< of each camera, at least
inline constexpr int kMinCornersInNinth = 8;
inline constexpr double kMinRangeRatio = 1.25;  ///< of farthest and nearest board

/// Corners in each ninth of an image, row by row from the upper left.
using Ninths = std::array<int, 9>;

/// The ninth of an image that a pixel lies in.
size_t NinthOf(const cv::Point2d& pixel, cv::Size size);

/// A line for each ninth of an image that has too few corners.
/// @param camera  "left", for the text.
std::vector<std::string> MissingNinths(const std::string& camera, const Ninths& corners);

/// What the views of a board cover while it is shown, without any calibration.
class Coverage {
 public:
  /// The ways to tilt a board, by the edge that is nearer to the cameras.
  enum Tilt { kRightNearer, kLeftNearer, kLowerNearer, kUpperNearer };
  static constexpr size_t kTilts = 4;

  explicit Coverage(const Board& board) : board_(board) {}

  /// @param sizes  of the cameras' images, px; ToF 0×0: there is none.
  void Add(const BoardView& view, const std::array<cv::Size, kCameraCount>& sizes);

  int views(CameraIndex camera) const { return cameras_[camera].views; }
  const Ninths& ninths(CameraIndex camera) const { return cameras_[camera].corners; }
  int tilted(Tilt tilt) const { return tilted_[tilt]; }

  /// One line for each thing that is missing, with what to do; empty: nothing is missing.
  std::vector<std::string> Missing() const;

  /// The whole coverage as text, for people.
  std::string Text() const;

 private:
  struct OfCamera {
    cv::Size size;
    int views = 0;
    Ninths corners{};
  };
  struct Placed {
    cv::Vec3d normal;  // of the board, away from the cameras
    double distance;   // m, by a lens of 53°
  };

  std::optional<Placed> PlaceOf(const BoardCorners& corners, cv::Size size) const;
  bool HasTof() const { return !cameras_[kTof].size.empty(); }

  Board board_;
  std::array<OfCamera, kCameraCount> cameras_;
  std::array<int, kTilts> tilted_{};
  double nearest_ = 0;
  double farthest_ = 0;
};

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_COVERAGE_H_
