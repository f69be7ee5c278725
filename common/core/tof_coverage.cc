#include "common/core/tof_coverage.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

namespace sprout {
namespace {

constexpr int kCellsAcross = 40;
constexpr int kMinCellSide = 8;  // px

// Whether the nearest pixel is one of the image. Compared as it is: points beside the cameras
// project to anywhere, and NaN nowhere.
bool InImage(const Seed& seed, cv::Size size) {
  return seed.u >= -0.5F && seed.u < static_cast<float>(size.width) - 0.5F && seed.v >= -0.5F &&
         seed.v < static_cast<float>(size.height) - 0.5F;
}

// The cell in which a position lies, of `count` equal ones along a side of the image.
int CellOf(float position, int count, int side) {
  const auto cell =
      static_cast<int>((position + 0.5F) * static_cast<float>(count) / static_cast<float>(side));
  return std::min(cell, count - 1);
}

}  // namespace

float TofCoverage(std::span<const Seed> seeds, cv::Size size) {
  assert(!size.empty());
  const int cell_px = std::max(kMinCellSide, size.width / kCellsAcross);
  // The remainder of the division gets no cell of its own: it would be small and hardly ever
  // covered.
  const int columns = std::max(1, size.width / cell_px);
  const int rows = std::max(1, size.height / cell_px);
  std::vector<uint8_t> covered(static_cast<size_t>(columns) * static_cast<size_t>(rows));
  for (const Seed& seed : seeds) {
    if (seed.origin != SeedOrigin::kTof || !InImage(seed, size)) continue;
    const int cell =
        CellOf(seed.v, rows, size.height) * columns + CellOf(seed.u, columns, size.width);
    covered[static_cast<size_t>(cell)] = 1;
  }
  const auto count = std::count(covered.begin(), covered.end(), uint8_t{1});
  return static_cast<float>(count) / static_cast<float>(covered.size());
}

}  // namespace sprout
