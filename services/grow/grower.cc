#include "services/grow/grower.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/core/image.h"
#include "common/core/parallel.h"
#include "services/grow/plain_growth.h"

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

// The disparities of a band's first and last row.
struct Seams {
  std::vector<int16_t> first, last;

  explicit Seams(const GrowthBand& band) {
    first.reserve(static_cast<size_t>(band.image_size.width));
    last.reserve(static_cast<size_t>(band.image_size.width));
    for (int u = 0; u < band.image_size.width; ++u) {
      first.push_back(band.left[band.PixelAt(0, u)].disparity);
      last.push_back(band.left[band.PixelAt(band.rows - 1, u)].disparity);
    }
  }
};

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
  const GrowthKernel* const kernel = with_prior ? FindGrowthKernel() : nullptr;
  if (kernel == nullptr) return GrowPlainly(rule_, input, rounded);
  return GrowInBands(*kernel, input, rounded);
}

DisparityImage Grower::GrowInBands(const GrowthKernel& kernel, const GrowthInput& input,
                                   std::span<const Correspondence> seeds) {
  const cv::Size size = input.left.size();
  const int rows = RowsPerBand(size.height);
  const auto count = static_cast<size_t>(CountBands(size.height));
  bands_.resize(count);
  for (GrowthBand& band : bands_) band.seeds.clear();
  for (const Correspondence& seed : seeds) {
    bands_[static_cast<size_t>(seed.v / rows)].seeds.push_back(seed);
  }
  ForEachParallel(count, [&](size_t i) {
    GrowthBand& band = bands_[i];
    band.Resize(size, static_cast<int>(i) * rows);
    kernel.prepare(rule_, input, band);
    kernel.grow_from_seeds(rule_, band);
  });
  const auto changed = [](const GrowthBand& band) { return band.changed; };
  while (std::any_of(bands_.begin(), bands_.end(), changed)) {
    const std::vector<Seams> before(bands_.begin(), bands_.end());
    ForEachParallel(count, [&](size_t i) {
      bands_[i].changed = false;
      const SeamRow above = i > 0 ? SeamRow(before[i - 1].last) : SeamRow();
      const SeamRow below = i + 1 < count ? SeamRow(before[i + 1].first) : SeamRow();
      kernel.grow_from_seams(rule_, above, below, bands_[i]);
    });
  }
  DisparityImage map{cv::Mat1s(size)};
  ForEachParallel(count, [&](size_t i) { kernel.write(rule_, input, bands_[i], map); });
  return map;
}

}  // namespace sprout::grow
