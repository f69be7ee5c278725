#include "common/inputs/range_watch.h"

#include <fmt/core.h>

#include <algorithm>

namespace sprout::inputs {
namespace {

constexpr int64_t kFewestWithout = 10;  // frames: half a second of quick cameras

}  // namespace

std::string RangeWatch::Add(const TofImage& tof, const SeedSet& seeds, const SeedSet& left_seeds) {
  const bool came = !tof.depth_m.empty();
  const bool returned = came && seeds.raw > 0;
  const bool hit = returned && seeds.outside < seeds.raw;
  const bool became =
      hit && (CountTofSeeds(seeds.seeds) > 0 || CountTofSeeds(left_seeds.seeds) > 0);
  ++frames_;
  if (came) {
    if (came_ > 0) longest_pause_ = std::max(longest_pause_, without_);
    without_ = 0;
    ++came_;
  } else {
    ++without_;
  }
  if (returned) ++returned_;
  if (hit) ++hit_;
  if (became) ++became_seeds_;
  Step step = Step::kNone;
  if (!came) {
    if (without_ <= std::max(kFewestWithout, 2 * longest_pause_)) return {};
    if (came_ > 0) step = Step::kCame;
  } else if (!returned) {
    if (returned_ > 0) step = Step::kReturns;
  } else if (!hit) {
    if (hit_ > 0) step = Step::kHits;
  } else if (!became) {
    step = Step::kSeeds;
  }
  if (step == last_) return {};
  last_ = step;
  const std::string counts = fmt::format(
      " (of {} frames {} had a range image, {} returns, {} points in the picture, {} "
      "seeds of them)",
      frames_, came_, returned_, hit_, became_seeds_);
  switch (step) {
    case Step::kNone:
      break;
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
  }
  return {};
}

}  // namespace sprout::inputs
