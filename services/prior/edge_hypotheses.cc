#include "services/prior/edge_hypotheses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "services/prior/triangle_raster.h"

namespace sprout {
namespace {

constexpr int kRadius = 4;            // of the window, px
constexpr int kStep = 2;              // between the rows and columns of the window that count
constexpr int kLargestGrey = 20;      // differences above are as bad as this
constexpr double kColourRange = 30;   // sum over the channels by which likeness falls to 1/e
constexpr double kDistanceRange = 5;  // px
constexpr int kWeightOne = 256;

// Weights that fall exponentially, as whole numbers.
int ExpWeight(double exponent) {
  return static_cast<int>(std::lround(kWeightOne * std::exp(-exponent)));
}

int ColourDistance(const cv::Vec3b& a, const cv::Vec3b& b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

// The two surfaces that a pixel of a triangle may lie on.
struct Hypotheses {
  float near_px;
  float far_px;
};

// Decides between hypotheses by the images and the spread seeds.
class Judge {
 public:
  explicit Judge(const EdgeEvidence& evidence) : evidence_(evidence) {
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

  bool IsNear(int u, int v, const Hypotheses& hypotheses) const {
    const int near_d = static_cast<int>(std::lround(hypotheses.near_px));
    const int far_d = static_cast<int>(std::lround(hypotheses.far_px));
    // The images cannot tell between disparities of one whole pixel.
    if (near_d == far_d) {
      return FromSpread(u, v, hypotheses, true) < FromSpread(u, v, hypotheses, false);
    }
    const bool inside = u >= kRadius + std::max(near_d, 0) &&
                        u + kRadius - std::min(far_d, 0) < columns() && v >= kRadius &&
                        v + kRadius < rows();
    const Costs costs = inside ? Inside(u, v, near_d, far_d) : AtBorder(u, v, near_d, far_d);
    const double worst = static_cast<double>(costs.weights) * kLargestGrey;
    return costs.near - costs.far <
           worst * (FromSpread(u, v, hypotheses, false) - FromSpread(u, v, hypotheses, true));
  }

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
    int near = 0;
    int far = 0;
    int weights = 0;
  };

  int rows() const { return evidence_.left_grey.rows; }
  int columns() const { return evidence_.left_grey.cols; }

  int Likeness(const cv::Vec3b& a, const cv::Vec3b& b) const {
    return likeness_[static_cast<size_t>(ColourDistance(a, b))];
  }

  // All windows lie in their images.
  Costs Inside(int u, int v, int near_d, int far_d) const {
    Costs costs;
    const cv::Vec3b colour = evidence_.left_bgr(v, u);
    for (const Sample& sample : samples_) {
      const int x = u + sample.u;
      const int y = v + sample.v;
      const int weight = sample.weight * Likeness(colour, evidence_.left_bgr(y, x));
      const int left = evidence_.left_grey(y, x);
      const uint8_t* right = evidence_.right_grey[y] + x;
      costs.weights += weight;
      costs.near += weight * std::min(std::abs(left - right[-near_d]), kLargestGrey);
      costs.far += weight * std::min(std::abs(left - right[-far_d]), kLargestGrey);
    }
    return costs;
  }

  Costs AtBorder(int u, int v, int near_d, int far_d) const {
    Costs costs;
    for (const Sample& sample : samples_) {
      const int x = u + sample.u;
      const int y = v + sample.v;
      if (y < 0 || x < 0 || y >= rows() || x >= columns()) continue;
      const int weight =
          sample.weight * Likeness(evidence_.left_bgr(v, u), evidence_.left_bgr(y, x));
      costs.weights += weight;
      costs.near += weight * Difference(x, y, near_d);
      costs.far += weight * Difference(x, y, far_d);
    }
    return costs;
  }

  // Truncated; a pixel that leaves the right image fits as badly as can be.
  int Difference(int u, int v, int disparity) const {
    const int u_right = u - disparity;
    if (u_right < 0 || u_right >= columns()) return kLargestGrey;
    return std::min(std::abs(evidence_.left_grey(v, u) - evidence_.right_grey(v, u_right)),
                    kLargestGrey);
  }

  // Distance of a hypothesis from the spread seeds as a share of that between the two.
  double FromSpread(int u, int v, const Hypotheses& hypotheses, bool near) const {
    const double spread_px = evidence_.spread_px(v, u);
    if (std::isnan(spread_px)) return 0;
    const double gap_px = std::max(1.0, double{hypotheses.near_px} - hypotheses.far_px);
    const double off_px = std::abs((near ? hypotheses.near_px : hypotheses.far_px) - spread_px);
    return evidence_.spread_weight * std::min(off_px / gap_px, 1.0);
  }

  const EdgeEvidence& evidence_;
  std::array<int, 3 * 255 + 1> likeness_{};
  std::array<Sample, kSamples> samples_{};
};

// The seeds of a triangle, parted where their disparities gape most.
class SplitTriangle {
 public:
  explicit SplitTriangle(std::array<LocalPlane, 3> planes) : planes_(planes) {
    std::sort(planes_.begin(), planes_.end(),
              [](const LocalPlane& a, const LocalPlane& b) { return a.disparity < b.disparity; });
    two_far_ =
        planes_[1].disparity - planes_[0].disparity < planes_[2].disparity - planes_[1].disparity;
  }

  // The corners in the image.
  Seed Corner(size_t i) const { return {.u = planes_[i].u, .v = planes_[i].v, .u_right = 0}; }

  float spread_px() const { return planes_[2].disparity - planes_[0].disparity; }

  Hypotheses At(int u, int v) const {
    const auto column = static_cast<float>(u);
    const auto row = static_cast<float>(v);
    const float a = two_far_ ? planes_[2].At(column, row) : planes_[0].At(column, row);
    const float b = two_far_ ? Between(planes_[0], planes_[1], column, row)
                             : Between(planes_[1], planes_[2], column, row);
    return {std::max(a, b), std::min(a, b)};
  }

 private:
  // Of two planes of one surface, the closer seed's counts more.
  static float Between(const LocalPlane& a, const LocalPlane& b, float u, float v) {
    const float to_a = Distance(a, u, v);
    const float to_b = Distance(b, u, v);
    return (to_b * a.At(u, v) + to_a * b.At(u, v)) / (to_a + to_b);
  }

  static float Distance(const LocalPlane& plane, float u, float v) {
    constexpr float kNotZero = 1e-3F;
    const float across = u - plane.u;
    const float down = v - plane.v;
    return kNotZero + std::sqrt(across * across + down * down);
  }

  std::array<LocalPlane, 3> planes_;  // far to near
  bool two_far_;
};

}  // namespace

void ResolveEdges(const SeedSurface& surface, std::span<const SeedTriangle> triangles,
                  const EdgeEvidence& evidence, DisparityImage& prior) {
  std::vector<SplitTriangle> edges;
  for (const SeedTriangle& triangle : triangles) {
    const auto plane = [&](size_t i) { return surface.planes[static_cast<size_t>(triangle[i])]; };
    const SplitTriangle split({plane(0), plane(1), plane(2)});
    if (split.spread_px() >= static_cast<float>(evidence.edge_px)) edges.push_back(split);
  }
  const Judge judge(evidence);
  PaintInBands(prior.height(), [&](const cv::Range& rows) {
    TriangleRaster raster(prior.width(), rows);
    for (const SplitTriangle& edge : edges) {
      for (const PixelRun& run : raster.Runs(edge.Corner(0), edge.Corner(1), edge.Corner(2))) {
        for (int u = run.begin; u < run.end; ++u) {
          const Hypotheses hypotheses = edge.At(u, run.v);
          const bool near = judge.IsNear(u, run.v, hypotheses);
          prior.counts()(run.v, u) = ToCounts(near ? hypotheses.near_px : hypotheses.far_px);
        }
      }
    }
  });
}

}  // namespace sprout
