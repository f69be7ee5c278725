#include "services/prior/sigma_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/core/parallel.h"
#include "common/core/prior_map.h"
#include "services/prior/triangle_raster.h"

namespace sprout {
namespace {

// Planes that gape wider lie on two surfaces. Which of them a pixel is on the images have decided:
// the prior is as sure there as on either surface, or wrong by the whole step, which no Gaussian
// says.
constexpr double kEdgePx = 1;

using Corners = std::array<LocalPlane, 3>;

Seed SeedOf(const LocalPlane& plane) {
  return {.u = plane.u, .v = plane.v, .u_right = plane.u - plane.disparity};
}

// Eq. (P1).
double SigmaPx(const Corners& corners) {
  const auto& [a, b, c] = corners;
  const float u = (a.u + b.u + c.u) / 3;
  const float v = (a.v + b.v + c.v) / 3;
  const float disparity = (a.disparity + b.disparity + c.disparity) / 3;
  double squares = 0;
  for (const LocalPlane& corner : corners) {
    const double off = double{corner.At(u, v)} - disparity;
    squares += double{corner.sigma_px} * corner.sigma_px;
    if (std::abs(off) < kEdgePx) squares += off * off;
  }
  return std::sqrt(squares / 3);
}

}  // namespace

void PaintSigma(std::span<const LocalPlane> planes, std::span<const SeedTriangle> triangles,
                cv::Size size, cv::Mat1b& sigma) {
  sigma.create(size);
  PaintInBands(size.height, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      std::fill_n(sigma[v], size.width, kMaxSigmaCounts);
    }
    for (const SeedTriangle& triangle : triangles) {
      const auto plane = [&](size_t i) { return planes[static_cast<size_t>(triangle[i])]; };
      const Corners corners{plane(0), plane(1), plane(2)};
      const auto& [a, b, c] = corners;
      const TriangleRaster raster(SeedOf(a), SeedOf(b), SeedOf(c), size.width, rows);
      if (raster.end_row() <= raster.first_row()) continue;
      const uint8_t counts = SigmaToCounts(SigmaPx(corners));
      for (int v = raster.first_row(); v < raster.end_row(); ++v) {
        const PixelRun run = raster.Run(v);
        std::fill(sigma[v] + run.begin, sigma[v] + std::max(run.begin, run.end), counts);
      }
    }
  });
}

}  // namespace sprout
