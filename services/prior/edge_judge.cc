#include "services/prior/edge_judge.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/core/disparity_image.h"

namespace sprout {
namespace {

constexpr int kRadius = 4;            // of the window, px
constexpr int kStep = 2;              // between the rows and columns of the window that count
constexpr int kLargestGrey = 20;      // differences above are as bad as this
constexpr double kColourRange = 20;   // sum over the channels by which likeness falls to 1/e
constexpr double kDistanceRange = 5;  // px
constexpr int kWeightOne = 256;

// Weights that fall exponentially, as whole numbers.
int ExpWeight(double exponent) {
  return static_cast<int>(std::lround(kWeightOne * std::exp(-exponent)));
}

int ColourDistance(const cv::Vec3b& a, const cv::Vec3b& b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

// Counts to whole pixels.
int Rounded(int counts) {
  constexpr int kOne = DisparityImage::kCountsPerPixel;
  static_assert(kOne == 1 << 5);
  return (counts + kOne / 2) >> 5;
}

}  // namespace

EdgeJudge::EdgeJudge(const EdgeEvidence& evidence) : evidence_(evidence) {
  for (size_t i = 0; i < likeness_.size(); ++i) {
    likeness_[i] = ExpWeight(static_cast<double>(i) / kColourRange);
  }
  size_t count = 0;
  for (int y = -kRadius; y <= kRadius; y += kStep) {
    for (int x = -kRadius; x <= kRadius; x += kStep) {
      if ((x + y) / kStep % 2 != 0) continue;
      samples_[count++] = {x, y, ExpWeight(std::sqrt(x * x + y * y) / kDistanceRange)};
    }
  }
}

bool EdgeJudge::IsNear(int u, int v, int near, int far) const {
  const int near_px = Rounded(near);
  const int far_px = Rounded(far);
  const double for_near = SpreadVote(u, v, near, far);
  const bool inside = u >= kRadius + std::max(near_px, 0) &&
                      u + kRadius - std::min(far_px, 0) < columns() && v >= kRadius &&
                      v + kRadius < rows();
  const Costs costs = inside ? Inside(u, v, near_px, far_px) : AtBorder(u, v, near_px, far_px);
  return costs.near_minus_far < static_cast<double>(costs.weights) * kLargestGrey * for_near;
}

int EdgeJudge::Likeness(const cv::Vec3b& a, const cv::Vec3b& b) const {
  return likeness_[static_cast<size_t>(ColourDistance(a, b))];
}

// All windows lie in their images.
EdgeJudge::Costs EdgeJudge::Inside(int u, int v, int near_px, int far_px) const {
  Costs costs;
  const cv::Vec3b colour = evidence_.left_bgr(v, u);
  for (const Sample& sample : samples_) {
    const int x = u + sample.u;
    const int y = v + sample.v;
    const int weight = sample.weight * Likeness(colour, evidence_.left_bgr(y, x));
    const int left = evidence_.left_grey(y, x);
    const uint8_t* right = evidence_.right_grey[y] + x;
    costs.weights += weight;
    costs.near_minus_far += weight * (std::min(std::abs(left - right[-near_px]), kLargestGrey) -
                                      std::min(std::abs(left - right[-far_px]), kLargestGrey));
  }
  return costs;
}

EdgeJudge::Costs EdgeJudge::AtBorder(int u, int v, int near_px, int far_px) const {
  Costs costs;
  for (const Sample& sample : samples_) {
    const int x = u + sample.u;
    const int y = v + sample.v;
    if (y < 0 || x < 0 || y >= rows() || x >= columns()) continue;
    const int weight = sample.weight * Likeness(evidence_.left_bgr(v, u), evidence_.left_bgr(y, x));
    costs.weights += weight;
    costs.near_minus_far += weight * (Difference(x, y, near_px) - Difference(x, y, far_px));
  }
  return costs;
}

// Truncated; a pixel that leaves the right image fits as badly as can be.
int EdgeJudge::Difference(int u, int v, int disparity_px) const {
  const int u_right = u - disparity_px;
  if (u_right < 0 || u_right >= columns()) return kLargestGrey;
  return std::min(std::abs(evidence_.left_grey(v, u) - evidence_.right_grey(v, u_right)),
                  kLargestGrey);
}

// Of the four closest pixels of the half image that of the most alike colour: the one that is not
// on the other side of the edge.
float EdgeJudge::SpreadPx(int u, int v) const {
  const cv::Mat3b& half = evidence_.half_bgr;
  const cv::Vec3b colour = evidence_.left_bgr(v, u);
  const int x = u / 2;
  const int y = v / 2;
  const int beside = std::clamp(u % 2 == 0 ? x - 1 : x + 1, 0, half.cols - 1);
  const int below = std::clamp(v % 2 == 0 ? y - 1 : y + 1, 0, half.rows - 1);
  cv::Point best(x, y);
  int least = ColourDistance(colour, half(best));
  for (const cv::Point& other :
       {cv::Point(beside, y), cv::Point(x, below), cv::Point(beside, below)}) {
    const int distance = ColourDistance(colour, half(other));
    if (distance >= least) continue;
    least = distance;
    best = other;
  }
  return evidence_.spread_px(best);
}

// By how much nearer the spread seeds are to `near`, as a share of the distance between the two;
// times the weight of that.
double EdgeJudge::SpreadVote(int u, int v, int near, int far) const {
  constexpr int kOne = DisparityImage::kCountsPerPixel;
  const double spread = double{SpreadPx(u, v)} * kOne;
  if (std::isnan(spread)) return 0;
  const double gap = near - far;
  const double off_near = std::min(std::abs(near - spread), gap);
  const double off_far = std::min(std::abs(far - spread), gap);
  return evidence_.spread_weight * (off_far - off_near) / gap;
}

}  // namespace sprout
