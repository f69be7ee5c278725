#include "services/depth/depth_in_view.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "services/depth/rays.h"
#include "services/depth/voxel_filter.h"

namespace sprout::depth {
namespace {

// Disparities of one surface, in counts: the error up to which a disparity counts as right.
constexpr int kSurfaceCounts = DisparityImage::kCountsPerPixel;

// Most pixels of the view along a side of what one pixel of the map fills. A view 16 times finer
// than the map is closed; a point right in front of the camera does not take the time of an image.
constexpr float kMaxSidePx = 16;

// Of an empty pixel. Pixels hold depth − 1 in counts, so that the nearest is the smallest, and
// adding 1 makes 0 of an empty one.
constexpr uint16_t kEmpty = std::numeric_limits<uint16_t>::max();

// The pixels of a row of the map, in the view.
struct ProjectedRow {
  explicit ProjectedRow(size_t width) : x(width), y(width), z(width) {}

  std::vector<float> x, y;  // px
  std::vector<float> z;     // m; 0 = no point, or not in front of the view
};

struct Bounds {
  float low, high;
};

Bounds BoundsOf(float a, float b, float c, float d) {
  return {std::min(std::min(a, b), std::min(c, d)), std::max(std::max(a, b), std::max(c, d))};
}

// Fills the part of a z-buffer that a band of rows of the map is projected to.
class BandMapper {
 public:
  BandMapper(const DisparityImage& map, const Rays& rays, const DepthOfCounts& depth_m,
             const View& view, double metres_per_count, double left_focal_px)
      : map_(map),
        rays_(rays),
        depth_m_(depth_m),
        view_(view),
        counts_per_m_(static_cast<float>(1 / metres_per_count)),
        // Half the side of a pixel of the map at equal depths.
        half_side_px_(static_cast<float>(view.focal_px / left_focal_px / 2)),
        buffer_(view.size, kEmpty),
        upper_(Width()),
        lower_(Width()) {}

  void Map(const cv::Range& rows) {
    // Whether the pixels (u, v) to (u + 1, v + 1) span a surface, at index u + 1.
    std::vector<uint8_t> above(Width() + 1, 0);
    std::vector<uint8_t> below(Width() + 1, 0);
    Project(rows.start, lower_);
    if (rows.start > 0) {
      Project(rows.start - 1, upper_);
      FindSurfaces(rows.start - 1, above, /*fill=*/false);  // another band does
    }
    for (int v = rows.start; v < rows.end; ++v) {
      std::swap(upper_, lower_);
      std::fill(below.begin(), below.end(), uint8_t{0});
      if (v + 1 < map_.height()) {
        Project(v + 1, lower_);
        FindSurfaces(v, below, /*fill=*/true);
      }
      FillBorders(v, upper_, above, below);
      std::swap(above, below);
    }
  }

  const cv::Mat1w& buffer() const { return buffer_; }

 private:
  size_t Width() const { return static_cast<size_t>(map_.width()); }

  void Project(int v, ProjectedRow& row) const {
    const Eigen::Vector3f start = rays_.RowStart(v).cast<float>();
    const Eigen::Vector3f per_u = rays_.per_u.cast<float>();
    const Eigen::Vector3f origin = rays_.origin.cast<float>();
    const auto focal_px = static_cast<float>(view_.focal_px);
    const auto cx = static_cast<float>(view_.cx);
    const auto cy = static_cast<float>(view_.cy);
    const int16_t* const counts = map_.counts()[v];
    float* const x = row.x.data();
    float* const y = row.y.data();
    float* const z = row.z.data();
    const int width = map_.width();
    for (int u = 0; u < width; ++u) z[u] = depth_m_(counts[u]);
    for (int u = 0; u < width; ++u) {
      const auto column = static_cast<float>(u);
      const float left_z = z[u];
      const float view_z = origin[2] + left_z * (start[2] + column * per_u[2]);
      const float scale = focal_px / view_z;
      x[u] = scale * (origin[0] + left_z * (start[0] + column * per_u[0])) + cx;
      y[u] = scale * (origin[1] + left_z * (start[1] + column * per_u[1])) + cy;
      z[u] = left_z > 0 && view_z > 0 ? view_z : 0.0F;
    }
  }

  // @pre upper_ and lower_ are the rows v and v + 1.
  void FindSurfaces(int v, std::vector<uint8_t>& surfaces, bool fill) {
    const int16_t* const upper = map_.counts()[v];
    const int16_t* const lower = map_.counts()[v + 1];
    for (int u = 0; u + 1 < map_.width(); ++u) {
      const int a = upper[u], b = upper[u + 1], c = lower[u], d = lower[u + 1];
      const int spread =
          std::max(std::max(a, b), std::max(c, d)) - std::min(std::min(a, b), std::min(c, d));
      if (spread > kSurfaceCounts) continue;
      const auto i = static_cast<size_t>(u);
      const float nearest =
          std::min(std::min(upper_.z[i], upper_.z[i + 1]), std::min(lower_.z[i], lower_.z[i + 1]));
      if (nearest == 0) continue;
      const Bounds x = BoundsOf(upper_.x[i], upper_.x[i + 1], lower_.x[i], lower_.x[i + 1]);
      const Bounds y = BoundsOf(upper_.y[i], upper_.y[i + 1], lower_.y[i], lower_.y[i + 1]);
      if (x.high - x.low > kMaxSidePx || y.high - y.low > kMaxSidePx) continue;
      surfaces[i + 1] = 1;
      if (!fill) continue;
      Fill(x, y, (upper_.z[i] + upper_.z[i + 1] + lower_.z[i] + lower_.z[i + 1]) / 4);
    }
  }

  // The pixels of row v that are not surrounded by surfaces.
  void FillBorders(int v, const ProjectedRow& row, const std::vector<uint8_t>& above,
                   const std::vector<uint8_t>& below) {
    for (size_t u = 0; u < Width(); ++u) {
      if (row.z[u] == 0 || (above[u] & above[u + 1] & below[u] & below[u + 1]) != 0) continue;
      const float left_z = depth_m_(map_.counts()(v, static_cast<int>(u)));
      const float half = std::min(half_side_px_ * left_z / row.z[u], kMaxSidePx / 2);
      Fill({row.x[u] - half, row.x[u] + half}, {row.y[u] - half, row.y[u] + half}, row.z[u]);
    }
  }

  // The pixels whose centres lie within the bounds.
  void Fill(const Bounds& x, const Bounds& y, float z) {
    const auto right = static_cast<float>(view_.size.width - 1);
    const auto bottom = static_cast<float>(view_.size.height - 1);
    if (!(x.high >= 0 && x.low <= right && y.high >= 0 && y.low <= bottom)) return;  // or NaN
    const float depth = z * counts_per_m_ + 0.5F;  // rounded to nearest below
    if (!(depth >= 1 && depth < 65536)) return;
    const auto value = static_cast<uint16_t>(static_cast<int>(depth) - 1);
    // Conversion cuts off, which is rounding down for what is not negative.
    const int u_end = static_cast<int>(std::min(x.high, right)) + 1;
    const int v_end = static_cast<int>(std::min(y.high, bottom)) + 1;
    const int u_begin = Ceil(std::max(x.low, 0.0F));
    const int v_begin = Ceil(std::max(y.low, 0.0F));
    for (int v = v_begin; v < v_end; ++v) {
      uint16_t* const row = buffer_[v];
      for (int u = u_begin; u < u_end; ++u) row[u] = std::min(row[u], value);
    }
  }

  static int Ceil(float not_negative) {
    const int down = static_cast<int>(not_negative);
    return down + (static_cast<float>(down) < not_negative ? 1 : 0);
  }

  const DisparityImage& map_;
  const Rays& rays_;
  const DepthOfCounts& depth_m_;
  const View& view_;
  float counts_per_m_;
  float half_side_px_;
  cv::Mat1w buffer_;
  ProjectedRow upper_;
  ProjectedRow lower_;
};

}  // namespace

View ViewOf(const Lens& lens, const Pose& left_from_camera) {
  return {.size = lens.size(),
          .focal_px = lens.fx,
          .cx = lens.cx,
          .cy = lens.cy,
          .view_from_left = left_from_camera.Inverse()};
}

DepthImage DepthInView(const DisparityImage& map, const RectifiedPair& pair, const View& view,
                       double metres_per_count) {
  assert(map.size() == pair.size() && !view.size.empty());
  const Rays rays(pair, view.view_from_left);
  const DepthOfCounts depth_m(pair);
  // Each band has a z-buffer of its own; the nearest of all is the same for any number of bands.
  constexpr int kMaxBands = 4;
  const int bands = std::clamp(cv::getNumThreads(), 1, std::min(kMaxBands, map.height()));
  std::vector<cv::Mat1w> buffers(static_cast<size_t>(bands));
  cv::parallel_for_({0, bands}, [&](const cv::Range& part) {
    for (int band = part.start; band < part.end; ++band) {
      BandMapper mapper(map, rays, depth_m, view, metres_per_count, pair.focal_px);
      mapper.Map({map.height() * band / bands, map.height() * (band + 1) / bands});
      buffers[static_cast<size_t>(band)] = mapper.buffer();
    }
  });
  DepthImage depth{.counts = cv::Mat1w(view.size),
                   .metres_per_count = metres_per_count,
                   .focal_px = view.focal_px,
                   .cx = view.cx,
                   .cy = view.cy};
  for (int v = 0; v < depth.counts.rows; ++v) {
    uint16_t* const row = depth.counts[v];
    for (int u = 0; u < depth.counts.cols; ++u) row[u] = buffers[0](v, u);
    for (size_t i = 1; i < buffers.size(); ++i) {
      const uint16_t* const other = buffers[i][v];
      for (int u = 0; u < depth.counts.cols; ++u) row[u] = std::min(row[u], other[u]);
    }
    for (int u = 0; u < depth.counts.cols; ++u) row[u] = static_cast<uint16_t>(row[u] + 1);
  }
  return depth;
}

PointCloud CloudInView(const DepthImage& depth, const View& view, const RectifiedPair& pair,
                       const cv::Mat& left, const cv::Mat& confidence,
                       const CloudThinning& thinning) {
  assert(depth.size() == view.size && left.size() == pair.size());
  assert(confidence.empty() || confidence.size() == pair.size());
  const Pose left_from_view = view.view_from_left.Inverse();
  const auto nearest = [](double position, int size) {
    return static_cast<int>(std::lround(std::clamp(position, 0.0, size - 1.0)));
  };
  PointCloud cloud;
  VoxelFilter filter(thinning.voxel_m);
  for (int v = 0; v < view.size.height; v += thinning.stride) {
    for (int u = 0; u < view.size.width; u += thinning.stride) {
      if (depth.counts(v, u) == 0) continue;
      const double z = depth.Metres(u, v);
      const Eigen::Vector3d point((u - view.cx) * z / view.focal_px,
                                  (v - view.cy) * z / view.focal_px, z);
      if (!filter.IsFirst(point)) continue;
      if (cloud.points.size() == kMaxCloudPoints) return cloud;
      const Eigen::Vector3d in_left =
          left_from_view.rotation * point + left_from_view.translation_m;
      const double scale = pair.focal_px / in_left.z();
      const int left_u = nearest(scale * in_left.x() + pair.cx, pair.width);
      const int left_v = nearest(scale * in_left.y() + pair.cy, pair.height);
      cloud.points.push_back(
          {.position_m = {static_cast<float>(point.x()), static_cast<float>(point.y()),
                          static_cast<float>(point.z())},
           .bgr = ColourAt(left, left_u, left_v),
           .confidence =
               confidence.empty() ? uint8_t{255} : confidence.at<uint8_t>(left_v, left_u)});
    }
  }
  return cloud;
}

}  // namespace sprout::depth
