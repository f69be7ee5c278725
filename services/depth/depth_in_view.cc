#include "services/depth/depth_in_view.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "services/depth/rays.h"
#include "services/depth/view_kernel.h"

namespace sprout::depth {
namespace {

// Disparities of one surface, in counts: the error up to which a disparity counts as right.
constexpr float kSurfaceCounts = DisparityImage::kCountsPerPixel;

// Longest side of the area that one pixel of the map fills, px of the view. Views up to 16 times
// finer than the map get no holes, and a point right in front of the camera takes little time.
constexpr float kMaxSidePx = 16;

// Value of an empty pixel. Pixels hold depth − 1 in counts, so that the nearest is the smallest,
// and adding 1 makes 0 of an empty one.
constexpr uint16_t kEmpty = std::numeric_limits<uint16_t>::max();

std::array<float, 3> Floats(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// Fills the part of a z-buffer that a band of rows of the map is projected to.
class BandMapper {
 public:
  BandMapper(const DisparityImage& map, const RectifiedPair& pair, const View& view,
             double metres_per_count)
      : map_(map),
        rays_(pair, view.view_from_left),
        projection_{.origin = Floats(rays_.origin),
                    .start = {},
                    .per_u = Floats(rays_.per_u),
                    .focal_px = static_cast<float>(view.focal_px),
                    .cx = static_cast<float>(view.cx),
                    .cy = static_cast<float>(view.cy),
                    .metre_counts = static_cast<float>(DisparityImage::kCountsPerPixel *
                                                       pair.focal_px * pair.baseline_m),
                    .shift = static_cast<float>(DisparityImage::kCountsPerPixel *
                                                (pair.cx_right - pair.cx))},
        rule_{.surface_counts = kSurfaceCounts,
              .side_px = kMaxSidePx,
              .right = static_cast<float>(view.size.width - 1),
              .bottom = static_cast<float>(view.size.height - 1),
              .counts_per_m = static_cast<float>(1 / metres_per_count)},
        // Half the side of a pixel of the map at equal depths.
        half_side_px_(static_cast<float>(view.focal_px / pair.focal_px / 2)),
        buffer_(view.size, kEmpty),
        upper_(Width()),
        lower_(Width()),
        above_(Width()),
        below_(Width()),
        borders_(Width()) {}

  void Map(const cv::Range& rows) {
    Project(rows.start, lower_);
    if (rows.start > 0) {  // another band fills it
      Project(rows.start - 1, upper_);
      FindSpans(upper_, lower_, rule_, below_);
    }
    for (int v = rows.start; v < rows.end; ++v) {
      std::swap(upper_, lower_);
      std::swap(above_, below_);
      if (v + 1 < map_.height()) {
        Project(v + 1, lower_);
        FindSpans(upper_, lower_, rule_, below_);
        FillSurfaces();
      } else {
        std::fill(below_.surface.begin(), below_.surface.end(), uint8_t{0});
      }
      FillBorders();
    }
  }

  const cv::Mat1w& buffer() const { return buffer_; }

 private:
  size_t Width() const { return static_cast<size_t>(map_.width()); }

  void Project(int v, ProjectedRow& row) {
    projection_.start = Floats(rays_.RowStart(v));
    ProjectRow(projection_, map_.counts()[v], row);
  }

  void FillSurfaces() {
    uint16_t* const pixels = buffer_[0];
    const auto stride = static_cast<size_t>(buffer_.cols);  // a new image has no gaps
    for (size_t u = 0; u + 1 < Width(); ++u) {
      const auto value = static_cast<uint16_t>(below_.value[u]);
      const int begin = below_.u_begin[u];
      const int end = below_.u_end[u];
      for (int y = below_.v_begin[u]; y < below_.v_end[u]; ++y) {
        uint16_t* const row = pixels + static_cast<size_t>(y) * stride;
        for (int x = begin; x < end; ++x) row[x] = std::min(row[x], value);
      }
    }
  }

  // Fills the pixels of the upper row that are not surrounded by surfaces.
  void FillBorders() {
    FindBorders(upper_, above_.surface, below_.surface, borders_);
    auto border = borders_.begin();
    while ((border = std::find(border, borders_.end(), uint8_t{1})) != borders_.end()) {
      FillOne(static_cast<size_t>(border - borders_.begin()));
      ++border;
    }
  }

  // The pixels that one pixel of the upper row covers.
  void FillOne(size_t u) {
    const float depth = upper_.z[u] * rule_.counts_per_m + 0.5F;
    if (!(depth >= 1 && depth < 65536)) return;
    const auto value = static_cast<uint16_t>(static_cast<int>(depth) - 1);
    const float half = std::min(half_side_px_ * upper_.left_z[u] / upper_.z[u], kMaxSidePx / 2);
    const cv::Range columns = Within(upper_.x[u], half, rule_.right);
    const cv::Range rows = Within(upper_.y[u], half, rule_.bottom);
    for (int y = rows.start; y < rows.end; ++y) {
      uint16_t* const row = buffer_[y];
      for (int x = columns.start; x < columns.end; ++x) row[x] = std::min(row[x], value);
    }
  }

  // Whole numbers from 0 to `last` that are at most `half` from `middle`.
  static cv::Range Within(float middle, float half, float last) {
    if (!(middle + half >= 0 && middle - half <= last)) return {0, 0};  // or not a number
    return {static_cast<int>(std::ceil(std::max(middle - half, 0.0F))),
            static_cast<int>(std::floor(std::min(middle + half, last))) + 1};
  }

  const DisparityImage& map_;
  Rays rays_;
  RowProjection projection_;
  SpanRule rule_;
  float half_side_px_;
  cv::Mat1w buffer_;
  ProjectedRow upper_;
  ProjectedRow lower_;
  Spans above_;  // between the row before and the upper one
  Spans below_;  // between the upper and the lower one
  std::vector<uint8_t> borders_;
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
  // Each band has a z-buffer of its own; the nearest of all is the same for any number of bands.
  constexpr int kMaxBands = 4;
  const int bands = std::clamp(cv::getNumThreads(), 1, std::min(kMaxBands, map.height()));
  std::vector<cv::Mat1w> buffers(static_cast<size_t>(bands));
  cv::parallel_for_({0, bands}, [&](const cv::Range& part) {
    for (int band = part.start; band < part.end; ++band) {
      BandMapper mapper(map, pair, view, metres_per_count);
      mapper.Map({map.height() * band / bands, map.height() * (band + 1) / bands});
      buffers[static_cast<size_t>(band)] = mapper.buffer();
    }
  });
  DepthImage depth{.counts = buffers[0],
                   .metres_per_count = metres_per_count,
                   .focal_px = view.focal_px,
                   .cx = view.cx,
                   .cy = view.cy};
  for (size_t i = 1; i < buffers.size(); ++i) {
    KeepSmaller(buffers[i][0], depth.counts.total(), depth.counts[0]);
  }
  depth.counts.forEach([](uint16_t& pixel, const int*) { ++pixel; });
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
      cloud.points.push_back(CloudPointOf(point, left, confidence, {left_u, left_v}));
    }
  }
  return cloud;
}

}  // namespace sprout::depth
