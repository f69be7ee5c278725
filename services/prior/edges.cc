#include "services/prior/edges.h"

#include <opencv2/core/utility.hpp>

namespace sprout {
namespace {

constexpr int kCoarsest = 4;  // step between the pixels that are decided first

// The pixels that a step decides: those of its grid that are not on the grid twice as wide.
class GridStep {
 public:
  GridStep(const EdgeHypotheses& hypotheses, const EdgeJudge& judge, int step,
           DisparityImage& prior)
      : near_(hypotheses.near.counts()),
        far_(hypotheses.far.counts()),
        judge_(judge),
        step_(step),
        prior_(prior.counts()) {}

  void DecideRow(int v) {
    const bool all = step_ == kCoarsest;
    const bool on_wide_row = v % (2 * step_) == 0;
    const int first = on_wide_row && !all ? step_ : 0;
    const int stride = on_wide_row && !all ? 2 * step_ : step_;
    const int16_t* const near = near_[v];
    for (int u = first; u < prior_.cols; u += stride) {
      if (near[u] == DisparityImage::kInvalid) continue;
      prior_(v, u) = Decide(u, v) ? near[u] : far_(v, u);
    }
  }

 private:
  // Whether a pixel is near.
  bool Decide(int u, int v) const {
    const int near = near_(v, u);
    const int far = far_(v, u);
    if (step_ < kCoarsest) {
      const int votes = NearNeighbours(u, v, near + far);
      if (votes == 0) return false;
      if (votes == kNeighbours) return true;
    }
    return judge_.IsNear(u, v, near, far);
  }

  // Of the four corners of the pixel's cell in the wide grid, which coincide for a pixel on its
  // lines, those closer to the near surface.
  static constexpr int kNeighbours = 4;
  int NearNeighbours(int u, int v, int near_plus_far) const {
    const int wide = 2 * step_;
    const int left = u - u % wide;
    const int above = v - v % wide;
    const int right = u + step_ < prior_.cols && left != u ? left + wide : left;
    const int below = v + step_ < prior_.rows && above != v ? above + wide : above;
    const auto is_near = [&](int y, int x) { return 2 * prior_(y, x) > near_plus_far ? 1 : 0; };
    return is_near(above, left) + is_near(above, right) + is_near(below, left) +
           is_near(below, right);
  }

  const cv::Mat1s& near_;
  const cv::Mat1s& far_;
  const EdgeJudge& judge_;
  int step_;
  cv::Mat1s& prior_;
};

}  // namespace

void ResolveEdges(const EdgeHypotheses& hypotheses, const EdgeJudge& judge, DisparityImage& prior) {
  for (int step = kCoarsest; step > 0; step /= 2) {
    const int rows = (prior.height() + step - 1) / step;
    // Reads only what wider grids decided: the order of the rows does not matter.
    cv::parallel_for_({0, rows}, [&](const cv::Range& range) {
      GridStep grid(hypotheses, judge, step, prior);
      for (int row = range.start; row < range.end; ++row) grid.DecideRow(row * step);
    });
  }
}

}  // namespace sprout
