#include "services/grow/grower.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/core/image.h"
#include "common/core/parallel.h"

namespace sprout {
namespace {

// Pixels whose window lies in the image.
cv::Rect WindowCentres(cv::Size size) {
  return {kWindowRadius, kWindowRadius, size.width - 2 * kWindowRadius,
          size.height - 2 * kWindowRadius};
}

// The pixels and disparity of a seed, rounded. One whose windows leave an image has v = −1.
GrowthSeed Rounded(const Seed& seed, cv::Rect centres) {
  const auto u = static_cast<int>(std::lround(seed.u));
  const auto v = static_cast<int>(std::lround(seed.v));
  const auto d = static_cast<int>(std::lround(seed.disparity()));
  const bool fits = d >= 0 && centres.contains({u, v}) && centres.contains({u - d, v});
  if (!fits) return {0, -1, 0, SeedQueue::kNone};
  return {static_cast<int16_t>(u), static_cast<int16_t>(v), static_cast<int16_t>(d),
          SeedQueue::kNone};
}

// The disparities of every band's first and last row as the last round but one and the last left
// them: one round is read while the next is written.
class Seams {
 public:
  Seams(std::vector<int16_t>& memory, size_t bands, int width)
      : memory_(memory), bands_(bands), width_(static_cast<size_t>(width)) {
    memory_.resize(2 * bands_ * 2 * width_);
  }

  void Save(size_t round, const GrowthBand& band, size_t index) {
    for (const bool last : {false, true}) {
      const GrowthRow& row = band.row(last ? band.rows() - 1 : 0);
      int16_t* to = memory_.data() + Offset(round, index, last);
      for (size_t u = 0; u < width_; ++u) to[u] = row.left[u].disparity;
    }
  }

  SeamRow Row(size_t round, size_t index, bool last) const {
    return {memory_.data() + Offset(round, index, last), width_};
  }

 private:
  size_t Offset(size_t round, size_t index, bool last) const {
    return ((round % 2 * bands_ + index) * 2 + (last ? 1 : 0)) * width_;
  }

  std::vector<int16_t>& memory_;
  size_t bands_;
  size_t width_;
};

// Of a band with these rows, by how sure the prior is of its pixels.
GrowthBand::Kind KindOf(const PriorMap& prior, const cv::Range& rows, int least_open) {
  for (int v = rows.start; v < rows.end; ++v) {
    const uint8_t* sigma = prior.sigma[v];
    const int16_t* counts = prior.disparity.counts()[v];
    for (int u = 0; u < prior.sigma.cols; ++u) {
      if (sigma[u] >= least_open && counts[u] != DisparityImage::kInvalid) {
        return GrowthBand::Kind::kMixed;
      }
    }
  }
  return GrowthBand::Kind::kTabled;
}

}  // namespace

Grower::Grower(const GrowConfig& config) : config_(config) {
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
  PrepareScratch(size, prior);
  DistributeSeeds(seeds, size);
  GrowBands({left, right, prior});
  Renew(map_, size);
  ForEachParallel(bands_.size(), [&](size_t i) { WriteBand(rule_, bands_[i], map_); });
  return map_;
}

void Grower::PrepareScratch(cv::Size size, const PriorMap& prior) {
  const int rows = GrowthBand::RowsPerBand(size.height);
  bands_.resize(static_cast<size_t>((size.height + rows - 1) / rows));
  ForEachParallel(bands_.size(), [&](size_t i) {
    const int first = static_cast<int>(i) * rows;
    const cv::Range band(first, std::min(first + rows, size.height));
    const bool any_candidates = rule_.similarity == GrowConfig::EPC && rule_.least_open > 1;
    const GrowthBand::Kind kind =
        any_candidates ? KindOf(prior, band, rule_.least_open) : GrowthBand::Kind::kOpen;
    bands_[i].Resize(size, first, rule_, kind);
  });
}

// Sorts the seeds by bands, each band's in the order given.
void Grower::DistributeSeeds(std::span<const Seed> seeds, cv::Size size) {
  rounded_seeds_.clear();
  rounded_seeds_.reserve(seeds.size());
  const cv::Rect centres = WindowCentres(size);
  std::vector<size_t>& end = seeds_end_;
  end.assign(bands_.size() + 1, 0);
  const auto band_of = [rows = GrowthBand::RowsPerBand(size.height)](const GrowthSeed& seed) {
    return static_cast<size_t>(seed.v / rows);
  };
  for (const Seed& seed : seeds) {
    const GrowthSeed rounded = Rounded(seed, centres);
    if (rounded.v < 0) continue;
    rounded_seeds_.push_back(rounded);
    ++end[band_of(rounded) + 1];
  }
  seeds_.resize(rounded_seeds_.size());
  for (size_t i = 1; i < end.size(); ++i) end[i] += end[i - 1];
  for (size_t i = 0; i < bands_.size(); ++i) {
    bands_[i].seeds = std::span(seeds_).subspan(end[i], end[i + 1] - end[i]);
  }
  for (const GrowthSeed& seed : rounded_seeds_) seeds_[end[band_of(seed)]++] = seed;
}

void Grower::GrowBands(const GrowthInput& input) {
  const size_t count = bands_.size();
  Seams seams(seams_, count, input.left.cols);
  ForEachParallel(count, [&](size_t i) {
    PrepareBand(input, rule_, bands_[i]);
    GrowFromSeeds(rule_, bands_[i]);
    seams.Save(0, bands_[i], i);
  });
  const auto changed = [](const GrowthBand& band) { return band.changed; };
  for (size_t round = 1; std::any_of(bands_.begin(), bands_.end(), changed); ++round) {
    ForEachParallel(count, [&](size_t i) {
      GrowthBand& band = bands_[i];
      band.changed = false;
      const SeamRow above = i > 0 ? seams.Row(round - 1, i - 1, /*last=*/true) : SeamRow();
      const SeamRow below = i + 1 < count ? seams.Row(round - 1, i + 1, /*last=*/false) : SeamRow();
      GrowFromSeams(rule_, above, below, band);
      seams.Save(round, band, i);
    });
  }
}

size_t Grower::scratch_bytes() const {
  size_t bytes = (seeds_.capacity() + rounded_seeds_.capacity()) * sizeof(GrowthSeed) +
                 seams_.capacity() * sizeof(int16_t);
  for (const GrowthBand& band : bands_) bytes += band.bytes();
  return bytes;
}

}  // namespace sprout
