#include "services/prior/edges.h"

#include <optional>

#include "common/core/parallel.h"

namespace sprout {
namespace {

constexpr int kCoarsest = 2;  // step between the pixels that are decided first

// The pixels that a step decides: those of its grid that are not on the grid twice as wide.
class GridStep {
 public:
  GridStep(const EdgeHypotheses& hypotheses, const EdgeJudge& judge, int step,
           DisparityImage& prior)
      : hypotheses_(hypotheses),
        near_(hypotheses.near.counts()),
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
    const std::optional<bool> all_near =
        step_ < kCoarsest ? AreNear(u, v, near + far) : std::nullopt;
    if (all_near) return *all_near;
    return judge_.IsNear({u, v, near, far}, hypotheses_.edge(v, u));
  }

  // Whether the four corners of the pixel's cell in the wide grid are closer to the near surface;
  // nothing when they do not agree, or when the cell leaves the image. On a line of the grid cells
  // have no width: corners coincide.
  std::optional<bool> AreNear(int u, int v, int near_plus_far) const {
    const int wide = 2 * step_;
    const int left = u & -wide;  // steps are powers of two, and divisions are slow
    const int above = v & -wide;
    const int right = left == u ? left : left + wide;
    const int below = above == v ? above : above + wide;
    if (right >= prior_.cols || below >= prior_.rows) return std::nullopt;
    const auto is_near = [&](int y, int x) { return 2 * prior_(y, x) > near_plus_far; };
    const bool near = is_near(above, left);
    if (is_near(above, right) != near || is_near(below, left) != near ||
        is_near(below, right) != near) {
      return std::nullopt;
    }
    return near;
  }

  const EdgeHypotheses& hypotheses_;
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
    ForRangesParallel(rows, rows, [&](const cv::Range& range) {
      GridStep grid(hypotheses, judge, step, prior);
      for (int row = range.start; row < range.end; ++row) grid.DecideRow(row * step);
    });
  }
}

}  // namespace sprout
