#include "services/prior/seed_votes.h"

#include <algorithm>
#include <cmath>

#include "common/core/disparity_image.h"
#include "services/prior/colour_distance.h"

namespace sprout {
namespace {

// Sums over the channels by which likeness falls to 1/e: for votes by colour, and by proximity.
constexpr double kColourRange = 8;
constexpr double kVagueColourRange = 60;
constexpr double kDistanceRange = 0.5;  // by which nearness falls to 1/e, in distances of seeds
constexpr double kStepsPerDistance = 16;
constexpr float kSilence = 0.01F;  // what weighs less has no say
// A seed whose plane misses both surfaces by so many counts has half a say.
constexpr float kMiss = 0.7F * DisparityImage::kCountsPerPixel;
constexpr size_t kMostNeighbours = 16;  // of one seed; six are usual

// Rounded, since machines differ in the last bit of an exponential.
template <size_t kSize>
void FillWithExp(std::array<float, kSize>& table, double range) {
  constexpr double kOne = 1 << 12;
  for (size_t i = 0; i < kSize; ++i) {
    table[i] =
        static_cast<float>(std::round(kOne * std::exp(-static_cast<double>(i) / range)) / kOne);
  }
}

}  // namespace

SeedVotes::SeedVotes() {
  FillWithExp(likeness_, kColourRange);
  FillWithExp(vague_likeness_, kVagueColourRange);
  FillWithExp(nearness_, kDistanceRange * kStepsPerDistance);
}

void SeedVotes::Look(std::span<const LocalPlane> planes, double spacing_px,
                     const SeedNeighbours& neighbours, const cv::Mat3b& left_bgr) {
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  neighbours_ = &neighbours;
  per_px_ = static_cast<float>(kStepsPerDistance / spacing_px);
  looks_.clear();
  looks_.reserve(planes.size());
  for (const LocalPlane& plane : planes) {
    const int u = std::clamp(cvRound(plane.u), 0, left_bgr.cols - 1);
    const int v = std::clamp(cvRound(plane.v), 0, left_bgr.rows - 1);
    looks_.push_back({static_cast<int16_t>(u), static_cast<int16_t>(v), left_bgr(v, u),
                      kOne * plane.disparity, kOne * plane.per_column, kOne * plane.per_row});
  }
}

SeedVotes::Votes SeedVotes::Of(const SeedTriangle& triangle, cv::Point pixel,
                               const cv::Vec3b& colour, int near, int far) const {
  const float middle = 0.5F * static_cast<float>(near + far);
  const float half_gap = 0.5F * static_cast<float>(near - far);
  float alike_near = 0;
  float alike = kSilence;
  float close_near = 0;
  float close = kSilence;
  for (int corner : triangle) {
    if (static_cast<size_t>(corner) >= looks_.size()) continue;
    const std::span<const int> around = neighbours_->Of(corner);
    for (int seed : around.first(std::min(around.size(), kMostNeighbours))) {
      const SeedLook& look = looks_[static_cast<size_t>(seed)];
      const auto across = static_cast<float>(pixel.x - look.u);
      const auto down = static_cast<float>(pixel.y - look.v);
      const float counts =
          look.counts + look.counts_per_column * across + look.counts_per_row * down;
      const float miss = (std::abs(counts - middle) - half_gap) * (1 / kMiss);
      const float say = 1 / (1 + miss * miss);
      const float vote = counts > middle ? say : -say;
      const auto difference = static_cast<size_t>(ColourDistance(colour, look.colour));
      const float steps = std::sqrt(across * across + down * down) * per_px_;
      const auto step = std::min(static_cast<size_t>(steps), nearness_.size() - 1);
      const float likeness = likeness_[difference];
      const float closeness = vague_likeness_[difference] * nearness_[step];
      alike_near += vote * likeness;
      alike += say * likeness;
      close_near += vote * closeness;
      close += say * closeness;
    }
  }
  return {double{alike_near} / alike, double{close_near} / close};
}

}  // namespace sprout
