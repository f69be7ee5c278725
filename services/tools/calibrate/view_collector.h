#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_VIEW_COLLECTOR_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_VIEW_COLLECTOR_H_

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

/// How many images of a calibration were kept, and why others were not.
struct ViewCounts {
  int images = 0;      ///< triplets
  int no_board = 0;    ///< neither left nor right sees kMinCorners corners
  int foreign = 0;     ///< of these: with markers of another board
  int moving = 0;      ///< the board moved
  int similar = 0;     ///< the board was there in an earlier view
  int other_size = 0;  ///< not of the first view's size
  int too_many = 0;    ///< beyond kMaxViews
};

/// Keeps the views of a board that add information: the board stands still, and elsewhere than
/// before.
class ViewCollector {
 public:
  /// Most views that are kept: more do not improve the result, but take longer.
  static constexpr int kMaxViews = 100;
  static constexpr size_t kMaxStrange = 3;

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

  /// Left images without a board, the first kMaxStrange of them, to be looked into.
  const std::vector<cv::Mat1b>& strange() const { return strange_; }

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
  std::vector<cv::Mat1b> strange_;
  RigImages best_images_;
  int best_corners_ = 0;
};

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_VIEW_COLLECTOR_H_
