#pragma once

#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "services/grow/sweep/sweep_band.h"

// Steps (W3) to (W5) of the sweep, on segments instead of pixels: which ones seeds reach.
namespace sprout::grow {

/// Seeds in the order of their rows.
class SeedsByRow {
 public:
  /// @param seeds  that lie in the image. O(seeds + height).
  void Sort(std::span<const Correspondence> seeds, int height);

  /// The seeds of a row; none above and below the image.
  std::span<const Correspondence> Row(int v) const;

 private:
  std::vector<Correspondence> seeds_;
  std::vector<size_t> first_;  // of each row, one more than rows
};

/// (W3) within a band: makes its segments from the cuts, links those of neighbouring rows, and
/// marks those that seeds reach. O(segments + seeds), and where rows meet in pixels.
void LinkRows(const DisparityImage& map, const SeedsByRow& seeds, SweepBand& band);

/// (W3) from band to band: goes on marking until nothing changes.
void LinkBands(const DisparityImage& map, std::span<SweepBand> bands);

/// (W4) and (W5) in the band's rows of the map.
void EraseUnreached(const SweepBand& band, DisparityImage& map);

}  // namespace sprout::grow
