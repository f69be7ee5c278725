// Alg. 1 for EPC on a band of rows. Highway compiles this file once for each instruction set and
// picks one when the program runs.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "services/grow/growth_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/growth_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET != HWY_SCALAR
#include "services/grow/candidates-inl.h"
#include "services/grow/window_costs-inl.h"
#endif

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

const GrowthKernel* KernelOnTarget() { return nullptr; }

#else

// Seeds in the queue are pixels of the band or, with this bit, initial ones (number).
inline constexpr SeedQueue::Id kInitial = SeedQueue::Id{1} << 31;

// Level in the queue of seeds of what must not be matched: behind all levels.
inline constexpr int kRefused = kLevels;

struct Match {
  int disparity;
  int level;
};

class Growth {
 public:
  Growth(const GrowthRule& rule, GrowthBand& band)
      : rule_(rule),
        band_(band),
        queue_(band.queue),
        left_(band.left.data()),
        right_(band.right.data()),
        stride_(static_cast<PixelId>(band.stride)) {}

  void AddSeeds() {  // Step 2: similarity of every seed
    for (size_t i = 0; i < band_.seeds.size(); ++i) {
      const Correspondence& seed = band_.seeds[i];
      const PixelId id = band_.PixelAt(seed.v - band_.first_row, seed.u);
      queue_.Push(kInitial | static_cast<SeedQueue::Id>(i), LevelOf(id, seed.d),
                  band_.seed_links[i]);
    }
  }

  void Run() {
    while (!queue_.empty()) {                 // Steps 4 and 13
      const Seed seed = TakeBest();           // Step 5
      Visit(seed.pixel - 1, seed.disparity);  // Step 6
      Visit(seed.pixel + 1, seed.disparity);
      Visit(seed.pixel - stride_, seed.disparity);
      Visit(seed.pixel + stride_, seed.disparity);
    }
  }

  // One neighbour of a seed of disparity d.
  HWY_INLINE void Visit(PixelId id, int d) {
    LeftPixel& pixel = left_[id];
    if (pixel.disparity != LeftPixel::kFree) return;
    const Match best = pixel.candidates.IsOpen() ? BestOfOpen(id, d) : BestOfTwo(pixel, d);
    if (best.level == kRefused) return;  // Step 7
    uint8_t& right = right_[static_cast<ptrdiff_t>(id) - best.disparity];
    if (right != kUnmatched) return;                         // Step 8
    queue_.Push(id, best.level, pixel.next);                 // Step 9
    pixel.disparity = static_cast<int16_t>(best.disparity);  // Step 10
    right = kMatched;
    band_.changed = true;
  }

 private:
  struct Seed {
    PixelId pixel;
    int disparity;
  };

  HWY_INLINE Seed TakeBest() {
    const SeedQueue::Id id = queue_.Top();
    if ((id & kInitial) != 0) {
      const Correspondence& seed = band_.seeds[id & ~kInitial];
      queue_.Pop(band_.seed_links[id & ~kInitial]);
      return {band_.PixelAt(seed.v - band_.first_row, seed.u), seed.d};
    }
    const LeftPixel& pixel = left_[id];
    queue_.Pop(pixel.next);
    return {id, pixel.disparity};
  }

  static HWY_INLINE Match BestOfTwo(const LeftPixel& pixel, int d) {
    const int m = FirstCandidate(pixel);
    const auto near = static_cast<unsigned>(d - m + 1);
    if (near > 3) return {d, kRefused};
    const Candidates candidates = pixel.candidates;
    const unsigned which = candidates.Better(near);
    return {m + static_cast<int>(which),
            candidates.IsAccepted(which) ? candidates.Level(which) : kRefused};
  }

  // The best of three; of equals d comes before d − 1 before d + 1.
  Match BestOfOpen(PixelId id, int d) const {
    constexpr int kOne = DisparityImage::kCountsPerPixel;
    const LeftPixel& pixel = left_[id];
    const uint8_t sigma = pixel.candidates.Sigma();
    if (std::abs(d * kOne - pixel.prior) > rule_.prior_reaches[sigma] + kOne) {
      return {d, kRefused};  // eq. (5) alone rules out d − 1, d and d + 1
    }
    const FourNumbers costs = ToNumbers(FourCosts(rule_, band_, id, pixel.prior, sigma, d));
    Match best{d, 0};
    int32_t cost = costs[1];
    if (costs[2] < cost) best.disparity = d - 1, cost = costs[2];
    if (costs[0] < cost) best.disparity = d + 1, cost = costs[0];
    best.level = cost <= rule_.limit ? rule_.LevelOf(cost) : kRefused;
    return best;
  }

  int LevelOf(PixelId id, int d) const {
    const LeftPixel& pixel = left_[id];
    if (pixel.disparity == LeftPixel::kClosed) return kLevels - 1;
    if (pixel.candidates.IsOpen()) {
      const auto sigma = pixel.candidates.Sigma();
      return rule_.LevelOf(ToNumbers(FourCosts(rule_, band_, id, pixel.prior, sigma, d))[1]);
    }
    const auto which = static_cast<unsigned>(d - FirstCandidate(pixel));
    return which < 2 ? pixel.candidates.Level(which) : kLevels - 1;
  }

  const GrowthRule& rule_;
  GrowthBand& band_;
  SeedQueue& queue_;
  LeftPixel* const left_;
  uint8_t* const right_;
  const PixelId stride_;
};

void Prepare(const GrowthRule& rule, const GrowthInput& input, GrowthBand& band) {
  const int width = band.image_size.width;
  for (int r = -GrowthBand::kMargin; r < band.rows + GrowthBand::kMargin; ++r) {
    const int v = band.first_row + r;
    if (v < 0 || v >= band.image_size.height) continue;
    const PixelId first = band.PixelAt(r, 0);
    std::copy_n(input.left[v], width, band.left_grey.data() + first);
    std::copy_n(input.right[v], width, band.right_grey.data() + first);
    std::fill_n(band.right.data() + first + kWindowRadius, width - 2 * kWindowRadius,
                uint8_t{kUnmatched});
  }
  band.queue = SeedQueue();
  band.seed_links.resize(band.seeds.size());
  band.changed = false;
  BandTables(rule, input, band).Fill();
}

void GrowFromSeeds(const GrowthRule& rule, GrowthBand& band) {
  Growth growth(rule, band);
  growth.AddSeeds();
  growth.Run();
}

void GrowFromSeams(const GrowthRule& rule, SeamRow above, SeamRow below, GrowthBand& band) {
  Growth growth(rule, band);
  const auto cross = [&](SeamRow seam, int r) HWY_ATTR {
    for (size_t u = 0; u < seam.size(); ++u) {
      if (seam[u] > LeftPixel::kClosed) growth.Visit(band.PixelAt(r, static_cast<int>(u)), seam[u]);
    }
  };
  cross(above, 0);
  cross(below, band.rows - 1);
  growth.Run();
}

// Steps from the disparity of each pixel towards the least cost, where there are two candidates.
template <class D>
HWY_INLINE hn::Vec<D> StepsOfCandidates(const int8_t* steps, const LeftPixels<D>& pixels) {
  const D d;
  const hn::Rebind<int8_t, D> d8;
  const auto packed = hn::PromoteTo(d, hn::LoadU(d8, steps));
  const auto better = hn::Add(hn::ShiftRight<5>(pixels.priors()), hn::And(packed, hn::Set(d, 1)));
  return hn::IfThenElseZero(hn::Eq(pixels.disparities(), better), hn::ShiftRight<1>(packed));
}

// Writes a row's counts, from whole disparities and the steps that are known of candidates.
HWY_INLINE void WriteRow(const LeftPixel* left, const int8_t* steps, int width, int16_t* counts) {
  using D = hn::CappedTag<int32_t, GrowthBand::kRunPixels>;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  const D d;
  const hn::Rebind<int16_t, D> d16;
  for (int u = 0; u < width; u += kLanes) {
    const LeftPixels<D> pixels(left + u);
    const auto disparities = pixels.disparities();
    auto values = hn::ShiftLeft<5>(disparities);
    if (steps != nullptr) values = hn::Add(values, StepsOfCandidates(steps + u, pixels));
    const auto matched = hn::Gt(disparities, hn::Set(d, LeftPixel::kClosed));
    values = hn::IfThenElse(matched, values, hn::Set(d, DisparityImage::kInvalid));
    int16_t run[kLanes];
    hn::StoreU(hn::DemoteTo(d16, values), d16, run);
    std::copy_n(run, std::min(kLanes, width - u), counts + u);
  }
}

// Moves the counts of a row's matched open pixels towards the least cost.
void RefineOpen(const GrowthRule& rule, const GrowthInput& input, const GrowthBand& band, int r,
                int16_t* counts) {
  const auto one = [](int32_t cost) HWY_ATTR { return hn::Set(DFour(), cost); };
  const uint8_t* const sigmas = input.prior.sigma[band.first_row + r];
  for (int u = 0; u < band.image_size.width; ++u) {
    if (counts[u] == DisparityImage::kInvalid || sigmas[u] < rule.least_open) continue;
    const PixelId id = band.PixelAt(r, u);
    const LeftPixel& pixel = band.left[id];
    const FourNumbers costs =
        ToNumbers(FourCosts(rule, band, id, pixel.prior, sigmas[u], pixel.disparity));
    const auto step = hn::GetLane(StepsToMinimum(one(costs[2]), one(costs[1]), one(costs[0])));
    counts[u] = static_cast<int16_t>(pixel.disparity * DisparityImage::kCountsPerPixel + step);
  }
}

void Write(const GrowthRule& rule, const GrowthInput& input, const GrowthBand& band,
           DisparityImage& map) {
  for (int r = 0; r < band.rows; ++r) {
    const PixelId first = band.PixelAt(r, 0);
    int16_t* const counts = map.counts()[band.first_row + r];
    const int8_t* const steps = rule.sub_pixel ? band.steps.data() + first : nullptr;
    WriteRow(band.left.data() + first, steps, band.image_size.width, counts);
    if (rule.sub_pixel && band.has_open[static_cast<size_t>(r)] != 0) {
      RefineOpen(rule, input, band, r, counts);
    }
  }
}

const GrowthKernel* KernelOnTarget() {
  static constexpr GrowthKernel kKernel = {Prepare, GrowFromSeeds, GrowFromSeams, Write};
  return &kKernel;
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::grow {

void GrowthBand::Resize(cv::Size size, int first) {
  if (size == image_size && first == first_row) return;
  image_size = size;
  first_row = first;
  rows = std::min(RowsPerBand(size.height), size.height - first);
  stride = size.width + 2 * kPadding;
  // The last row is read and written up to a run behind its end.
  const auto row = static_cast<size_t>(stride);
  const size_t pixels = static_cast<size_t>(rows + 2 * kMargin) * row + 2 * kRunPixels;
  left.assign(pixels, {{SeedQueue::kNone}, 0, LeftPixel::kClosed});
  right.assign(pixels, kNoWindow);
  left_grey.assign(pixels, 0);
  right_grey.assign(pixels, 0);
  steps.assign(pixels, 0);
  has_open.assign(static_cast<size_t>(rows), 0);
}

HWY_EXPORT(KernelOnTarget);

const GrowthKernel* FindGrowthKernel() { return HWY_DYNAMIC_DISPATCH(KernelOnTarget)(); }

}  // namespace sprout::grow
#endif  // HWY_ONCE
