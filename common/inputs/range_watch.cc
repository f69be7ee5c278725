#include "common/inputs/range_watch.h"

#include <fmt/core.h>

#include <algorithm>

namespace sprout::inputs {
namespace {

constexpr int64_t kMinSilentFrames = 10;  // frames: half a second of quick cameras

}  // namespace

std::string RangeWatch::Add(const TofImage& tof, const SeedSet& seeds, const SeedSet& left_seeds) {
  const bool came = !tof.depth_m.empty();
  const bool returned = came && seeds.raw > 0;
  const bool hit = returned && seeds.outside < seeds.raw;
  const bool became =
      hit && (CountTofSeeds(seeds.seeds) > 0 || CountTofSeeds(left_seeds.seeds) > 0);
  ++frames_;
  if (came) {
    if (Gave(Step::kCame) > 0) longest_pause_ = std::max(longest_pause_, without_);
    without_ = 0;
  } else {
    ++without_;
  }
  size_t step = 0;  // the first one that gives nothing
  for (const bool gives : {came, returned, hit, became}) {
    if (!gives) break;
    ++gave_[step++];
  }
  if (!came && without_ <= std::max(kMinSilentFrames, 2 * longest_pause_)) return {};
  auto silent = static_cast<Step>(step);
  // CheckInputs() says what is missing from the start, except for seeds.
  if (silent < Step::kSeeds && Gave(silent) == 0) silent = Step::kNone;
  if (silent == last_) return {};
  last_ = silent;
  return TextOf(silent, seeds);
}

std::string RangeWatch::TextOf(Step silent, const SeedSet& seeds) const {
  const std::string counts = fmt::format(
      " (of {} frames {} had a range image, {} returns, {} points in the picture, {} "
      "seeds of them)",
      frames_, Gave(Step::kCame), Gave(Step::kReturns), Gave(Step::kHits), Gave(Step::kSeeds));
  switch (silent) {
    case Step::kCame:
      return "range images do not come any more" + counts;
    case Step::kReturns:
      return "the range image has no return" + counts;
    case Step::kHits:
      return fmt::format("none of {} range points falls into both pictures", seeds.raw) + counts;
    case Step::kSeeds:
      return fmt::format(
                 "none of {} range points became a seed: {} outside, {} dark, {} loose, {} "
                 "background, {} hidden, {} contradicted",
                 seeds.raw, seeds.outside, seeds.dark, seeds.loose, seeds.background, seeds.hidden,
                 seeds.contradicted) +
             counts;
    case Step::kNone:
      break;
  }
  return {};
}

}  // namespace sprout::inputs
