// Alg. 1 for EPC on the open pixels of a band of rows. Highway compiles this file once for each
// instruction set and picks one when the program runs.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "services/grow/sweep/growth_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/sweep/growth_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET != HWY_SCALAR
#include "services/grow/sweep/window_costs-inl.h"
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
inline constexpr int kRejected = kLevels;

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
      if (!HasOpenNeighbour(id)) continue;  // leads nowhere
      queue_.Push(kInitial | static_cast<SeedQueue::Id>(i), LevelOf(id, seed.d),
                  band_.seed_links[i]);
    }
  }

  // Visits open pixels from the matched pixels beside them.
  void StartBesideMatched(int r) {
    for (int u = kWindowRadius; u < band_.image_size.width - kWindowRadius; ++u) {
      const PixelId id = band_.PixelAt(r, u);
      if (left_[id].disparity != LeftPixel::kFree) continue;
      const auto visit_from = [&](PixelId from) HWY_ATTR {
        if (left_[from].disparity > LeftPixel::kClosed) Visit(id, left_[from].disparity);
      };
      visit_from(id - 1);
      visit_from(id + 1);
      visit_from(id - stride_);
      visit_from(id + stride_);
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
    const Match best = BestOfThree(id, d);  // Steps 6 and 7
    if (best.level == kRejected) return;    // Step 8
    uint8_t& right = right_[static_cast<ptrdiff_t>(id) - best.disparity];
    if (right != kUnmatched) return;
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

  // The best of three; of equals d comes before d − 1 before d + 1.
  Match BestOfThree(PixelId id, int d) const {
    constexpr int kOne = DisparityImage::kCountsPerPixel;
    const LeftPixel& pixel = left_[id];
    const auto sigma = static_cast<uint8_t>(pixel.sigma);
    if (std::abs(d * kOne - pixel.prior) > rule_.prior_reaches[sigma] + kOne) {
      return {d, kRejected};  // eq. (5) alone rules out d − 1, d and d + 1
    }
    const FourNumbers costs = ToNumbers(FourCosts(rule_, band_, id, pixel.prior, sigma, d));
    Match best{d, 0};
    int32_t cost = costs[1];
    if (costs[2] < cost) best.disparity = d - 1, cost = costs[2];
    if (costs[0] < cost) best.disparity = d + 1, cost = costs[0];
    best.level = cost <= rule_.limit ? rule_.LevelOf(cost) : kRejected;
    return best;
  }

  // Neighbours beyond the band's border rows are kClosed.
  bool HasOpenNeighbour(PixelId id) const {
    const auto is_open = [&](PixelId at)
                             HWY_ATTR { return left_[at].disparity == LeftPixel::kFree; };
    return is_open(id - 1) || is_open(id + 1) || is_open(id - stride_) || is_open(id + stride_);
  }

  int LevelOf(PixelId id, int d) const {
    const LeftPixel& pixel = left_[id];
    if (pixel.prior == DisparityImage::kInvalid) return kLevels - 1;
    const auto sigma = static_cast<uint8_t>(pixel.sigma);
    return rule_.LevelOf(ToNumbers(FourCosts(rule_, band_, id, pixel.prior, sigma, d))[1]);
  }

  const GrowthRule& rule_;
  GrowthBand& band_;
  SeedQueue& queue_;
  LeftPixel* const left_;
  uint8_t* const right_;
  const PixelId stride_;
};

// The left pixels of a row of the band, and the right ones that they match.
class RowTable {
 public:
  RowTable(const GrowthRule& rule, const GrowthInput& input, const DisparityImage& map,
           GrowthBand& band)
      : rule_(rule),
        input_(input),
        map_(map),
        band_(band),
        counts_(RowSize()),
        priors_(RowSize()),
        sigmas_(RowSize()) {}

  void Fill(int r) {
    using D = hn::CappedTag<int32_t, kRunPixels>;
    constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
    const D d;
    const hn::Rebind<int16_t, D> d16;
    const hn::Rebind<uint8_t, D> d8;
    const int v = band_.first_row + r;
    std::copy_n(map_.counts()[v], width(), counts_.data());
    std::copy_n(input_.prior.disparity.counts()[v], width(), priors_.data());
    std::copy_n(input_.prior.sigma[v], width(), sigmas_.data());
    const bool windows_fit = v >= kWindowRadius && v < band_.image_size.height - kWindowRadius;
    const int end = windows_fit ? width() - kWindowRadius : 0;
    LeftPixel* const left = band_.left.data() + band_.PixelAt(r, 0);
    for (int u = 0; u < width(); u += kLanes) {
      const auto counts = hn::PromoteTo(d, hn::LoadU(d16, counts_.data() + u));
      const auto prior = hn::PromoteTo(d, hn::LoadU(d16, priors_.data() + u));
      const auto sigma = hn::PromoteTo(d, hn::LoadU(d8, sigmas_.data() + u));
      const auto columns = hn::Iota(d, u);
      const auto inside =
          hn::And(hn::Gt(columns, hn::Set(d, kWindowRadius - 1)), hn::Lt(columns, hn::Set(d, end)));
      const auto open =
          hn::And(hn::And(inside, hn::Gt(sigma, hn::Set(d, rule_.min_open_sigma - 1))),
                  hn::Ne(prior, hn::Set(d, DisparityImage::kInvalid)));
      static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
      const auto whole = hn::ShiftRight<5>(hn::Add(counts, hn::Set(d, 1 << 4)));
      const auto matched = hn::And(hn::Ne(counts, hn::Set(d, DisparityImage::kInvalid)),
                                   hn::Lt(columns, hn::Set(d, width())));
      auto state = hn::IfThenElse(matched, whole, hn::Set(d, LeftPixel::kClosed));
      state = hn::IfThenElse(open, hn::Set(d, LeftPixel::kFree), state);
      LeftPixels<D>(sigma, prior, state).Store(left + u);
    }
    MatchRight(r);
  }

 private:
  int width() const { return band_.image_size.width; }
  size_t RowSize() const { return static_cast<size_t>(width() + kRunPixels); }

  void MatchRight(int r) {
    if (band_.has_open[static_cast<size_t>(r)] == 0) return;  // no pixel asks for them
    uint8_t* const right = band_.right.data() + band_.PixelAt(r, 0);
    for (int u = kWindowRadius; u < width() - kWindowRadius; ++u) {
      const int16_t counts = counts_[static_cast<size_t>(u)];
      if (counts != DisparityImage::kInvalid) right[u - WholeDisparity(counts)] = kMatched;
    }
  }

  const GrowthRule& rule_;
  const GrowthInput& input_;
  const DisparityImage& map_;
  GrowthBand& band_;
  std::vector<int16_t> counts_, priors_;  // of a row; a run longer
  std::vector<uint8_t> sigmas_;
};

void Prepare(const GrowthRule& rule, const GrowthInput& input, const DisparityImage& map,
             GrowthBand& band) {
  const int width = band.image_size.width;
  RowTable table(rule, input, map, band);
  for (int r = -GrowthBand::kMargin; r < band.rows + GrowthBand::kMargin; ++r) {
    const int v = band.first_row + r;
    if (v < 0 || v >= band.image_size.height) continue;
    const PixelId first = band.PixelAt(r, 0);
    std::copy_n(input.left[v], width, band.left_grey.data() + first);
    std::copy_n(input.right[v], width, band.right_grey.data() + first);
    std::fill_n(band.right.data() + first + kWindowRadius, width - 2 * kWindowRadius,
                uint8_t{kUnmatched});
    if (r >= 0 && r < band.rows) table.Fill(r);
  }
  band.queue = SeedQueue();
  band.seed_links.resize(band.seeds.size());
}

void GrowFromSeeds(const GrowthRule& rule, GrowthBand& band) {
  Growth growth(rule, band);
  growth.AddSeeds();
  for (int r = 0; r < band.rows; ++r) {
    if (band.has_open[static_cast<size_t>(r)] != 0) growth.StartBesideMatched(r);
  }
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

// The sub-pixel step (S2) of a matched pixel.
HWY_INLINE int StepOf(const GrowthRule& rule, const GrowthBand& band, PixelId id, uint8_t sigma) {
  const LeftPixel& pixel = band.left[id];
  const int d = pixel.disparity;
  const FourSums sums = SumFour(band, id, d);
  const FourNumbers costs = ToNumbers(FourCosts(rule, band, id, pixel.prior, sigma, d, sums));
  const FourNumbers differences = ToNumbers(sums.differences);
  const FourNumbers textures = TexturesAt(band, id);
  const hn::RebindToFloat<DFour> df;
  using F = hn::Vec<decltype(df)>;
  const auto one = [](int32_t number) HWY_ATTR { return hn::Set(DFour(), number); };
  const auto real = [&](int32_t number) HWY_ATTR { return hn::ConvertTo(df, one(number)); };
  const StepWindows<F, Four> windows{real(differences[2]),
                                     real(differences[1]),
                                     real(differences[0]),
                                     one(costs[2]),
                                     one(costs[1]),
                                     one(costs[0]),
                                     one(textures[0]),
                                     one(textures[1]),
                                     AtLeastOne(one(ToNumbers(sums.energies)[1])),
                                     real(d * DisparityImage::kCountsPerPixel - pixel.prior)};
  return hn::GetLane(StepsToMinimum(rule, windows, hn::Set(df, rule.prior_scales[sigma])));
}

// The counts of a row's matched open pixels.
void WriteRow(const GrowthRule& rule, const GrowthInput& input, const GrowthBand& band, int r,
              int16_t* counts) {
  const uint8_t* const sigmas = input.prior.sigma[band.first_row + r];
  for (int u = kWindowRadius; u < band.image_size.width - kWindowRadius; ++u) {
    const PixelId id = band.PixelAt(r, u);
    const LeftPixel& pixel = band.left[id];
    if (!rule.IsOpen(sigmas[u]) || pixel.disparity <= LeftPixel::kClosed) continue;
    const bool has_next = u + 1 < band.image_size.width - kWindowRadius;
    const int step = rule.sub_pixel && has_next ? StepOf(rule, band, id, sigmas[u]) : 0;
    counts[u] = static_cast<int16_t>(pixel.disparity * DisparityImage::kCountsPerPixel + step);
  }
}

void Write(const GrowthRule& rule, const GrowthInput& input, const GrowthBand& band,
           DisparityImage& map) {
  for (int r = 0; r < band.rows; ++r) {
    if (band.has_open[static_cast<size_t>(r)] == 0) continue;
    WriteRow(rule, input, band, r, map.counts()[band.first_row + r]);
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
  left.assign(pixels, {{0}, 0, LeftPixel::kClosed});
  right.assign(pixels, kNoWindow);
  left_grey.assign(pixels, 0);
  right_grey.assign(pixels, 0);
}

HWY_EXPORT(KernelOnTarget);

const GrowthKernel* FindGrowthKernel() { return HWY_DYNAMIC_DISPATCH(KernelOnTarget)(); }

}  // namespace sprout::grow
#endif  // HWY_ONCE
