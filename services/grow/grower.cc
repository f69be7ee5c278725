#include "services/grow/grower.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/core/image.h"
#include "common/core/parallel.h"
#include "services/grow/paper/plain_growth.h"

// A pixel whose prior has a standard deviation below GrowthRule::min_open_sigma is swept: it
// chooses among up to 15 disparities around the prior, without a queue (sweep/). All others with a
// prior are "open" and grow best first as in the paper (paper/plain_growth.cc; with EPC its fast
// twin, sweep/growth_kernel.cc). With preset paper, MNCC and EXPSSD all are open.

namespace sprout::grow {
namespace {

// Whole pixels; without those whose windows leave an image.
std::vector<Correspondence> Rounded(std::span<const Seed> seeds, cv::Size size) {
  std::vector<Correspondence> rounded;
  rounded.reserve(seeds.size());
  for (const Seed& seed : seeds) {
    const Correspondence s{static_cast<int>(std::lround(seed.u)),
                           static_cast<int>(std::lround(seed.v)),
                           static_cast<int>(std::lround(seed.disparity()))};
    if (WindowsFit(s, size)) rounded.push_back(s);
  }
  return rounded;
}

// Disparities of a band's first and last row, as in LeftPixel.
struct Seams {
  std::vector<int16_t> first, last;

  // The border rows of a band that grows best first, from its table.
  explicit Seams(const GrowthBand& band) {
    const auto row = [&](int r, std::vector<int16_t>& seam) {
      for (int u = 0; u < band.image_size.width; ++u) {
        seam.push_back(band.left[band.PixelAt(r, u)].disparity);
      }
    };
    row(0, first);
    row(band.rows - 1, last);
  }

  // The border rows of a band without open pixels, from its part of the map.
  Seams(const SweepBand& band, const DisparityImage& map) {
    const auto row = [&](int v, std::vector<int16_t>& seam) {
      for (int u = 0; u < map.width(); ++u) {
        seam.push_back(map.IsValid(u, v) ? static_cast<int16_t>(WholeDisparity(map.counts()(v, u)))
                                         : LeftPixel::kClosed);
      }
    };
    row(band.first_row, first);
    row(band.first_row + band.rows - 1, last);
  }
};

bool HasOpen(const SweepBand& band) {
  return std::any_of(band.has_open.begin(), band.has_open.end(),
                     [](uint8_t row) { return row != 0; });
}

}  // namespace

Grower::Grower(const GrowConfig& config) {
  RequireInRange(config, "grow");
  rule_ = MakeGrowthRule(config);
}

Result<DisparityImage> Grower::Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                       std::span<const Seed> seeds, const PriorMap& prior) {
  const cv::Size size = left.size();
  if (right.size() != size) {
    return Fail("images of " + SizeText(size) + " and " + SizeText(right.size()) +
                ": allowed are two of one size");
  }
  if (size.width < kWindow || size.height < kWindow) {
    return Fail("images of " + SizeText(size) + ": smaller than the 5x5 window");
  }
  if (std::max(size.width, size.height) > INT16_MAX) {
    return Fail("images of " + SizeText(size) + ": allowed are up to " + std::to_string(INT16_MAX) +
                " pixels a side");
  }
  const bool with_prior = rule_.similarity == GrowConfig::EPC;
  if (with_prior && (prior.size() != size || prior.sigma.size() != size)) {
    return Fail("prior of " + SizeText(prior.size()) + ": allowed is the images' size " +
                SizeText(size));
  }
  const GrowthInput input{left, right, prior};
  const std::vector<Correspondence> rounded = Rounded(seeds, size);
  const SweepFunction sweep = with_prior ? FindSweep() : nullptr;
  if (sweep == nullptr) return GrowPlainly(rule_, input, rounded);
  Renew(map_, size);
  CutIntoBands(size.height);
  if (rule_.min_open_sigma > 0) {
    Sweep(sweep, input, rounded);
  } else {  // all pixels are open
    map_.counts() = DisparityImage::kInvalid;
    for (SweepBand& band : sweeps_) band.has_open.assign(static_cast<size_t>(band.rows), 1);
  }
  if (std::any_of(sweeps_.begin(), sweeps_.end(), HasOpen)) {
    GrowOpen(*FindGrowthKernel(), input, rounded);
  }
  return map_;
}

void Grower::CutIntoBands(int height) {
  const int rows = RowsPerBand(height);
  sweeps_.resize(static_cast<size_t>(CountBands(height)));
  for (size_t i = 0; i < sweeps_.size(); ++i) {
    sweeps_[i].first_row = static_cast<int>(i) * rows;
    sweeps_[i].rows = std::min(rows, height - sweeps_[i].first_row);
  }
}

void Grower::Sweep(SweepFunction sweep, const GrowthInput& input,
                   std::span<const Correspondence> seeds) {
  seeds_by_row_.Sort(seeds, input.left.rows);
  ForEachParallel(sweeps_.size(), [&](size_t i) {
    sweep(rule_, input, sweeps_[i], map_);      // (W1), (W2)
    LinkRows(map_, seeds_by_row_, sweeps_[i]);  // (W3)
  });
  LinkBands(map_, sweeps_);
  ForEachParallel(sweeps_.size(),
                  [&](size_t i) { EraseUnreached(sweeps_[i], map_); });  // (W4), (W5)
}

void Grower::GrowOpen(const GrowthKernel& kernel, const GrowthInput& input,
                      std::span<const Correspondence> seeds) {
  const cv::Size size = input.left.size();
  const size_t count = sweeps_.size();
  const auto rows = static_cast<size_t>(RowsPerBand(size.height));
  bands_.resize(count);
  for (GrowthBand& band : bands_) band.seeds.clear();
  for (const Correspondence& seed : seeds) {
    bands_[static_cast<size_t>(seed.v) / rows].seeds.push_back(seed);
  }
  const auto for_each_open = [&](const auto& act) {
    ForEachParallel(count, [&](size_t i) {
      if (HasOpen(sweeps_[i])) act(i);
    });
  };
  for_each_open([&](size_t i) {
    GrowthBand& band = bands_[i];
    band.Resize(size, sweeps_[i].first_row);
    band.has_open = sweeps_[i].has_open;
    kernel.prepare(rule_, input, map_, band);
    kernel.grow_from_seeds(rule_, band);
  });
  for (bool changed = true; changed;) {
    std::vector<Seams> before;
    for (size_t i = 0; i < count; ++i) {
      before.push_back(HasOpen(sweeps_[i]) ? Seams(bands_[i]) : Seams(sweeps_[i], map_));
    }
    for (GrowthBand& band : bands_) band.changed = false;
    for_each_open([&](size_t i) {
      const SeamRow above = i > 0 ? SeamRow(before[i - 1].last) : SeamRow();
      const SeamRow below = i + 1 < count ? SeamRow(before[i + 1].first) : SeamRow();
      kernel.grow_from_seams(rule_, above, below, bands_[i]);
    });
    changed = std::any_of(bands_.begin(), bands_.end(),
                          [](const GrowthBand& band) { return band.changed; });
  }
  for_each_open([&](size_t i) { kernel.write(rule_, input, bands_[i], map_); });
}

}  // namespace sprout::grow
