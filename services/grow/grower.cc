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

// Standard deviation of the seeds' disparities from the prior, px, from the median: what the
// prior's smoothing took off, so an estimate of the seeds' noise. A variance such as rounding to
// whole pixels has does not count: taking that off makes the prior better, not doubtful.
double NoiseOfSeeds(std::span<const Seed> seeds, const DisparityImage& prior,
                    std::vector<float>& deviations) {
  deviations.clear();
  for (const Seed& seed : seeds) {
    const cv::Point pixel(static_cast<int>(std::lround(seed.u)),
                          static_cast<int>(std::lround(seed.v)));
    if (!cv::Rect({}, prior.size()).contains(pixel) || !prior.IsValid(pixel.x, pixel.y)) continue;
    deviations.push_back(std::abs(seed.disparity() - prior.Px(pixel.x, pixel.y)));
  }
  if (deviations.empty()) return 0;
  const auto middle = deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2);
  std::nth_element(deviations.begin(), middle, deviations.end());
  constexpr double kMedianOfNormal = 0.6745;  // of the absolute value, in standard deviations
  constexpr double kVarianceOfRounding = 1.0 / 12;
  const double deviation = double{*middle} / kMedianOfNormal;
  return std::sqrt(std::max(0.0, deviation * deviation - kVarianceOfRounding));
}

}  // namespace

Grower::Grower(const GrowConfig& config) : config_(config) { RequireInRange(config, "grow"); }

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
  const bool with_prior = config_.similarity() == GrowConfig::EPC;
  if (with_prior && prior.size() != size) {
    return Fail("prior of " + SizeText(prior.size()) + ": allowed is the images' size " +
                SizeText(size));
  }
  const GrowthRule rule = MakeGrowthRule(config_, with_prior ? SigmaP(seeds, prior.disparity) : 1);
  PrepareScratch(size, rule);
  DistributeSeeds(seeds, size);
  GrowBands({left, right, prior.disparity}, rule);
  Renew(map_, size);
  ForEachParallel(bands_.size(), [&](size_t i) { WriteBand(rule, bands_[i], map_); });
  return map_;
}

void Grower::PrepareScratch(cv::Size size, const GrowthRule& rule) {
  const int rows = GrowthBand::RowsPerBand(size.height);
  bands_.resize(static_cast<size_t>((size.height + rows - 1) / rows));
  for (size_t i = 0; i < bands_.size(); ++i) {
    bands_[i].Resize(size, static_cast<int>(i) * rows, rule);
  }
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

void Grower::GrowBands(const GrowthInput& input, const GrowthRule& rule) {
  const size_t count = bands_.size();
  Seams seams(seams_, count, input.left.cols);
  ForEachParallel(count, [&](size_t i) {
    PrepareBand(input, rule, bands_[i]);
    GrowFromSeeds(rule, bands_[i]);
    seams.Save(0, bands_[i], i);
  });
  const auto changed = [](const GrowthBand& band) { return band.changed; };
  for (size_t round = 1; std::any_of(bands_.begin(), bands_.end(), changed); ++round) {
    ForEachParallel(count, [&](size_t i) {
      GrowthBand& band = bands_[i];
      band.changed = false;
      const SeamRow above = i > 0 ? seams.Row(round - 1, i - 1, /*last=*/true) : SeamRow();
      const SeamRow below = i + 1 < count ? seams.Row(round - 1, i + 1, /*last=*/false) : SeamRow();
      GrowFromSeams(rule, above, below, band);
      seams.Save(round, band, i);
    });
  }
}

double Grower::SigmaP(std::span<const Seed> seeds, const DisparityImage& prior) {
  if (config_.sigma_p_noise() == 0) return config_.sigma_p_px();
  return std::max(config_.sigma_p_px(),
                  config_.sigma_p_noise() * NoiseOfSeeds(seeds, prior, deviations_));
}

size_t Grower::scratch_bytes() const {
  size_t bytes = (seeds_.capacity() + rounded_seeds_.capacity()) * sizeof(GrowthSeed) +
                 seams_.capacity() * sizeof(int16_t) + deviations_.capacity() * sizeof(float);
  for (const GrowthBand& band : bands_) bytes += band.bytes();
  return bytes;
}

}  // namespace sprout
