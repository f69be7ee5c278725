#include "common/scenes/surface_renderer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include "common/geometry/lens.h"

namespace sprout::scenes {
namespace {

constexpr double kSameSurfacePx = 1;
constexpr double kInFrontPx = 1.5;

// A corner of a quadrilateral in the plane of the samples.
struct Vertex {
  double x;
  double y;
  double inverse_depth;  // 1/m; linear over a plane's image, as depth is not
};

using Quad = std::array<Vertex, 4>;  // in the order of walking around it

double Cross(const Vertex& a, const Vertex& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

// One view's truth as quadrilaterals.
class Surface {
 public:
  // @param shift  1 for the right view, whose pixel u' has the left column u' + d; else 0.
  Surface(const Rig& rig, const cv::Mat1f& disparity, double shift)
      : camera_(rig.tof),
        pair_(rig.pair),
        disparity_(disparity),
        shift_(shift),
        tof_from_left_(rig.tof.left_from_tof_rotation.toRotationMatrix().transpose()) {}

  // Nothing when the disparity is unknown or a corner is not in front of the cameras.
  std::optional<Quad> QuadOf(int u, int v) const {
    const float disparity = disparity_(v, u);
    if (!std::isfinite(disparity)) return {};
    Quad quad;
    size_t next = 0;
    for (const auto& [right, below] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      const std::optional<Vertex> vertex = VertexAt(
          u + right - 0.5, v + below - 0.5, CornerDisparity(u + right, v + below, disparity));
      if (!vertex) return {};
      quad[next++] = *vertex;
    }
    return quad;
  }

 private:
  // Mean over the four pixels around the corner above and left of (u, v).
  double CornerDisparity(int u, int v, float own) const {
    double sum = 0;
    int count = 0;
    for (int y = std::max(v - 1, 0); y <= std::min(v, disparity_.rows - 1); ++y) {
      for (int x = std::max(u - 1, 0); x <= std::min(u, disparity_.cols - 1); ++x) {
        if (!(std::abs(disparity_(y, x) - own) <= kSameSurfacePx)) continue;  // nor unknown
        sum += disparity_(y, x);
        ++count;
      }
    }
    return sum / count;
  }

  std::optional<Vertex> VertexAt(double u, double v, double disparity) const {
    const double depth_m = pair_.DepthFromDisparity(disparity);
    if (!(depth_m > 0) || !std::isfinite(depth_m)) return {};
    const Eigen::Vector3d in_left((u + shift_ * disparity - pair_.cx) * depth_m / pair_.focal_px,
                                  (v - pair_.cy) * depth_m / pair_.focal_px, depth_m);
    const Eigen::Vector3d in_tof = tof_from_left_ * (in_left - camera_.left_from_tof_translation_m);
    if (!(in_tof.z() > 0)) return {};
    const Eigen::Vector2d pixel =
        PixelOfDirection(lens_, {in_tof.x() / in_tof.z(), in_tof.y() / in_tof.z()});
    return Vertex{TofSamples::SamplePosition(pixel.x()), TofSamples::SamplePosition(pixel.y()),
                  1 / in_tof.z()};
  }

  const TofCamera& camera_;
  Lens lens_ = camera_.lens();
  const RectifiedPair& pair_;
  const cv::Mat1f& disparity_;
  double shift_;
  Eigen::Matrix3d tof_from_left_;
};

// The nearest surface at every sample.
struct ZBuffer {
  explicit ZBuffer(cv::Size size) : inverse_depth(size, 0.f), albedo(size, 0.f) {}

  void DrawTriangle(const Vertex& a, const Vertex& b, const Vertex& c, float brightness) {
    const double area = Cross(a, b, c.x, c.y);
    if (area == 0 || !std::isfinite(area)) return;
    const auto first = [](double low) { return static_cast<int>(std::ceil(std::max(low, 0.0))); };
    const auto last = [](double high, int size) {
      return static_cast<int>(std::floor(std::min(high, size - 1.0)));
    };
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
    if (right < 0 || bottom < 0 || left > albedo.cols - 1 || top > albedo.rows - 1) return;
    for (int y = first(top); y <= last(bottom, albedo.rows); ++y) {
      for (int x = first(left); x <= last(right, albedo.cols); ++x) {
        const double of_a = Cross(b, c, x, y) / area;
        const double of_b = Cross(c, a, x, y) / area;
        const double of_c = Cross(a, b, x, y) / area;
        constexpr double kOnEdge = -1e-9;  // belongs to both neighbours, so that no gap is left
        if (of_a < kOnEdge || of_b < kOnEdge || of_c < kOnEdge) continue;
        const auto inverse = static_cast<float>(of_a * a.inverse_depth + of_b * b.inverse_depth +
                                                of_c * c.inverse_depth);
        if (inverse <= inverse_depth(y, x)) continue;
        inverse_depth(y, x) = inverse;
        albedo(y, x) = brightness;
      }
    }
  }

  cv::Mat1f inverse_depth;  // 1/m; 0 = nothing
  cv::Mat1f albedo;
};

ZBuffer RenderView(const Rig& rig, const cv::Mat1f& disparity, double shift, const cv::Mat1b& grey,
                   cv::Size size) {
  ZBuffer buffer(size);
  const Surface surface(rig, disparity, shift);
  for (int v = 0; v < disparity.rows; ++v) {
    for (int u = 0; u < disparity.cols; ++u) {
      const std::optional<Quad> quad = surface.QuadOf(u, v);
      if (!quad) continue;
      const float brightness = static_cast<float>(grey(v, u)) / 255;
      buffer.DrawTriangle((*quad)[0], (*quad)[1], (*quad)[2], brightness);
      buffer.DrawTriangle((*quad)[0], (*quad)[2], (*quad)[3], brightness);
    }
  }
  return buffer;
}

}  // namespace

TofSamples RenderSurface(const Rig& rig, const GroundTruth& truth, const cv::Mat1b& left,
                         const cv::Mat1b& right) {
  assert(truth.left.size() == left.size());
  TofSamples samples({rig.tof.width, rig.tof.height});
  const ZBuffer from_left = RenderView(rig, truth.left, 0, left, samples.depth_m.size());
  const ZBuffer from_right = RenderView(rig, truth.right, 1, right, samples.depth_m.size());
  // d = f·b/z + constant: a step in disparity as one in inverse depth.
  const double in_front = kInFrontPx / (rig.pair.focal_px * rig.pair.baseline_m);
  for (int y = 0; y < samples.depth_m.rows; ++y) {
    for (int x = 0; x < samples.depth_m.cols; ++x) {
      const double left_inverse = from_left.inverse_depth(y, x);
      const double right_inverse = from_right.inverse_depth(y, x);
      const bool take_right = left_inverse == 0 || right_inverse > left_inverse + in_front;
      const double inverse = take_right ? right_inverse : left_inverse;
      if (inverse == 0) continue;
      samples.depth_m(y, x) = static_cast<float>(1 / inverse);
      samples.albedo(y, x) = (take_right ? from_right : from_left).albedo(y, x);
    }
  }
  return samples;
}

}  // namespace sprout::scenes
