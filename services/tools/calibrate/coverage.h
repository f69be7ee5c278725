#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

// What a good calibration needs of its views.
inline constexpr int kMinViewsOfCamera = 15;  ///< of each camera, at least
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

/// How many images of a calibration were kept, and why others were not.
struct ViewCounts {
  int images = 0;      ///< triplets
  int no_board = 0;    ///< neither left nor right sees kMinCorners corners
  int foreign = 0;     ///< of these: with markers of another board
  int moving = 0;      ///< the board moved
  int similar = 0;     ///< the board was at that place in an earlier view
  int two_sizes = 0;   ///< left and right differ in size
  int other_size = 0;  ///< not of the first view's size
  int too_many = 0;    ///< beyond kMaxViews
};

/// Keeps the views of a board that add information: the board stands still, and elsewhere than
/// before.
class ViewCollector {
 public:
  /// Most views that are kept: more do not improve the result, but take longer.
  static constexpr int kMaxViews = 100;
  static constexpr size_t kMaxWithoutBoard = 3;

  explicit ViewCollector(const Board& board) : board_(board) {}

  /// Searches the board in a triplet. O(pixels + views).
  /// @param utime  time of exposure, µs, ascending; without it nothing counts as moving.
  void Add(const RigImages& images, std::optional<int64_t> utime);

  /// The end of a recording: motion is not judged between this and the next image.
  void EndRecording() { newest_.reset(); }

  const ViewCounts& counts() const { return counts_; }
  const std::vector<BoardView>& views() const { return views_; }

  /// Sizes of the views' images, px; ToF 0×0: there is none. Frames without a board do not set
  /// them, so that a stray frame does not exclude all others.
  const std::array<cv::Size, kCameraCount>& sizes() const { return sizes_; }

  /// Left images without a board, the first kMaxWithoutBoard of them, to be looked into.
  const std::vector<cv::Mat1b>& images_without_board() const { return images_without_board_; }

  /// The triplet in which the cameras see most of the board, for the report. Empty without views.
  const RigImages& best_images() const { return best_images_; }

 private:
  struct Pair {
    BoardCorners left;
    BoardCorners right;
  };
  struct Timed {
    int64_t utime;
    Pair pair;
  };

  bool FitsTheViews(const std::array<cv::Size, kCameraCount>& sizes) const;
  bool Moves(const Pair& pair, std::optional<int64_t> utime, int width);
  bool IsSimilar(const Pair& pair) const;
  static std::optional<double> Shift(const Pair& a, const Pair& b);

  Board board_;
  ViewCounts counts_;
  std::array<cv::Size, kCameraCount> sizes_;
  std::vector<BoardView> views_;
  std::optional<Timed> newest_;
  std::vector<cv::Mat1b> images_without_board_;
  RigImages best_images_;
  int best_corners_ = 0;
};

}  // namespace sprout::calibrate
