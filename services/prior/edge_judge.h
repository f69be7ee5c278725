#ifndef SPROUT_SERVICES_PRIOR_EDGE_JUDGE_H_
#define SPROUT_SERVICES_PRIOR_EDGE_JUDGE_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace sprout {

/// What the choice between two disparities of a pixel rests on.
struct EdgeEvidence {
  cv::Mat3b left_bgr;   ///< colours of the left image, which say what belongs together
  cv::Mat1b left_grey;  ///< the pair that is matched
  cv::Mat1b right_grey;
  cv::Mat3b half_bgr;        ///< HalveSize() of left_bgr
  cv::Mat1f spread_px;       ///< SeedSpreader::SpreadAtHalfSize()
  double spread_weight = 0;  ///< weight of spread_px against that of the images
};

/// Decides between two disparities of a pixel of the left image. Two things vote:
///   the images: truncated absolute differences in a 9×9 window (13 pixels of it), weighted by
///     likeness of colour and by distance to the pixel (adaptive support weights: Yoon and Kweon,
///     PAMI 2006), so that the window does not reach over the edge;
///   the ToF camera: how far the hypothesis is from the disparity that the seeds spread there
///     along the image's edges.
class EdgeJudge {
 public:
  /// @param evidence  must outlive the judge.
  explicit EdgeJudge(const EdgeEvidence& evidence);

  /// Whether pixel (u, v) rather has disparity `near` than `far`, counts, near > far. Whole-number
  /// weights and differences: the same answer on every machine. O(13); thread-safe.
  bool IsNear(int u, int v, int near, int far) const;

 private:
  // Every other pixel of every other row and column, in quincunx: as good as all of them.
  static constexpr int kSamples = 13;
  struct Sample {
    int u;
    int v;
    int weight;  // by distance
  };

  // Sums over the window; below 2^31, as 13 weights are at most 2^16 and differences 20.
  struct Costs {
    int near_minus_far = 0;
    int weights = 0;
  };

  int rows() const { return evidence_.left_grey.rows; }
  int columns() const { return evidence_.left_grey.cols; }
  int Likeness(const cv::Vec3b& a, const cv::Vec3b& b) const;
  Costs Inside(int u, int v, int near_px, int far_px) const;
  Costs AtBorder(int u, int v, int near_px, int far_px) const;
  int Difference(int u, int v, int disparity_px) const;
  float SpreadPx(int u, int v) const;
  double SpreadVote(int u, int v, int near, int far) const;

  const EdgeEvidence& evidence_;
  std::array<int, 3 * 255 + 1> likeness_{};
  std::array<Sample, kSamples> samples_{};
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_EDGE_JUDGE_H_
