#include "common/geometry/widened_frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

namespace sprout {
namespace {

cv::Mat Padded(const cv::Mat& image, int left, int right) {
  cv::Mat padded;
  if (!image.empty()) {
    cv::copyMakeBorder(image, padded, 0, 0, left, right, cv::BORDER_REPLICATE);
  }
  return padded;
}

void Shift(DisparityImage& map, int counts) {
  for (int16_t& count : map.counts()) {
    if (count == DisparityImage::kInvalid) continue;
    const int shifted = count + counts;
    count = std::abs(shifted) <= std::numeric_limits<int16_t>::max() ? static_cast<int16_t>(shifted)
                                                                     : DisparityImage::kInvalid;
  }
}

int CountsOf(int columns) { return columns * DisparityImage::kCountsPerPixel; }

std::optional<SeedSet> Widened(std::optional<SeedSet> seeds, int columns) {
  if (!seeds) return seeds;
  for (Seed& seed : seeds->seeds) seed.u += static_cast<float>(columns);
  return seeds;
}

PriorMap Widened(const PriorMap& prior, int columns) {
  if (prior.empty()) return prior;
  PriorMap wide(cv::Size(prior.disparity.width() + columns, prior.disparity.height()));
  const cv::Rect inside({columns, 0}, prior.size());
  prior.disparity.counts().copyTo(wide.disparity.counts()(inside));
  prior.sigma.copyTo(wide.sigma(inside));
  Shift(wide.disparity, CountsOf(columns));
  return wide;
}

// @param any_right  whether u' may be beside the right image, as of points that only the left
//                   camera sees.
void Narrow(SeedSet& seeds, int columns, cv::Size size, bool any_right) {
  size_t next = 0;
  for (Seed seed : seeds.seeds) {
    seed.u -= static_cast<float>(columns);
    const bool inside =
        seed.u >= 0 && (any_right || seed.u_right <= static_cast<float>(size.width - 1));
    if (inside) {
      seeds.seeds[next++] = seed;
    } else if (seed.origin == SeedOrigin::kTof) {
      ++seeds.outside;
    }
  }
  seeds.seeds.resize(next);
}

}  // namespace

int ColumnsBelowZero(const RectifiedPair& pair) {
  constexpr double kRounding = 1e-6;
  const double columns = std::ceil(pair.cx_right - pair.cx - kRounding);
  return static_cast<int>(std::clamp<double>(columns, 0, kMaxColumns + 1));
}

int ColumnsBelowZero(std::span<const Seed> seeds) {
  constexpr double kRoom = 4;  // for what grows from them, and for planes through them
  double least = 0;
  for (const Seed& seed : seeds) least = std::min(least, double{seed.disparity()});
  return least < -1 ? static_cast<int>(std::min(std::ceil(kRoom - least), kMaxColumns + 0.0)) : 0;
}

Frame Widened(const Frame& frame, int columns) {
  assert(columns >= 1 && columns <= kMaxColumns);
  Frame wide = frame;
  wide.left = Padded(frame.left, columns, 0);
  wide.right = Padded(frame.right, 0, columns);
  wide.left_grey = Padded(frame.left_grey, columns, 0);
  wide.right_grey = Padded(frame.right_grey, 0, columns);
  if (wide.rig) {
    wide.rig->pair.width += columns;
    wide.rig->pair.cx += columns;
  }
  wide.seeds = Widened(frame.seeds, columns);
  wide.left_seeds = Widened(frame.left_seeds, columns);
  if (frame.prior) wide.prior = Widened(*frame.prior, columns);
  return wide;
}

void Narrow(StageResult& result, int columns, cv::Size size) {
  const cv::Rect inside({columns, 0}, size);
  for (PartOutput& output : result.outputs) {
    if (auto* seeds = std::get_if<SeedSet>(&output.value)) {
      Narrow(*seeds, columns, size, output.part == Part::kLeftSeeds);
    } else if (auto* map = std::get_if<DisparityImage>(&output.value)) {
      *map = DisparityImage(cv::Mat1s(map->counts()(inside).clone()));
      Shift(*map, -CountsOf(columns));
    } else if (auto* prior = std::get_if<PriorMap>(&output.value)) {
      *prior = PriorMap(DisparityImage(cv::Mat1s(prior->disparity.counts()(inside).clone())),
                        prior->sigma(inside).clone());
      Shift(prior->disparity, -CountsOf(columns));
    } else if (auto* image = std::get_if<cv::Mat>(&output.value)) {
      *image = (*image)(inside).clone();
    }
  }
}

}  // namespace sprout
