#ifndef SPROUT_SERVICES_CALIBRATE_VIEW_COLLECTOR_H_
#define SPROUT_SERVICES_CALIBRATE_VIEW_COLLECTOR_H_

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "services/calibrate/board.h"
#include "services/calibrate/board_view.h"

namespace sprout::calibrate {

/// What became of the images of a calibration.
struct ViewCounts {
  int images = 0;      ///< triplets
  int no_board = 0;    ///< neither left nor right sees kMinCorners corners
  int foreign = 0;     ///< of these: markers are there, but they do not lie as on the board
  int moving = 0;      ///< the board moved
  int similar = 0;     ///< the board was there before
  int other_size = 0;  ///< not of the first view's size
  int too_many = 0;    ///< beyond kMaxViews
};

/// Keeps those views of a board that say something new: the board stands still, and elsewhere than
/// before.
class ViewCollector {
 public:
  /// More make the result no better and the wait longer.
  static constexpr int kMaxViews = 100;

  explicit ViewCollector(const Board& board) : board_(board) {}

  /// Looks for the board in a triplet. O(pixels + views).
  /// @param utime  time of exposure, µs, ascending; without it nothing counts as moving.
  void Add(const RigImages& images, std::optional<int64_t> utime);

  /// Behind the end of a recording: what comes next says nothing about motion.
  void EndRecording() { newest_.reset(); }

  const ViewCounts& counts() const { return counts_; }
  const std::vector<BoardView>& views() const { return views_; }

  /// Sizes of the views' images, px; ToF 0×0: there is none. What has no board in it sets none, so
  /// that one stray frame does not keep all others out.
  const std::array<cv::Size, kCameraCount>& sizes() const { return sizes_; }

  /// The triplet in which the cameras see most of the board, to look at. Empty without views.
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
  RigImages best_images_;
  int best_corners_ = 0;
};

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_VIEW_COLLECTOR_H_
