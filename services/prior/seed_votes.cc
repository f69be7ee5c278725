#include "services/prior/seed_votes.h"

#include <algorithm>
#include <cmath>

#include "common/core/disparity_image.h"
#include "services/prior/colour_distance.h"

namespace sprout {
namespace {

// Sums over the channels by which likeness falls to 1/e: for votes by colour, and by proximity.
constexpr double kColourRange = 10;
constexpr double kVagueColourRange = 60;
constexpr double kDistanceRange = 0.5;  // by which nearness falls to 1/e, in distances of seeds
constexpr double kStepsPerDistance = 16;
constexpr int kOne = 1 << 12;
constexpr int kSilence = kOne / 100;  // what weighs less has no say
// Of one seed; six are usual. Their weights' sums stay below 2^31.
constexpr size_t kMostNeighbours = 16;

template <size_t kSize>
void FillWithExp(std::array<int, kSize>& table, double range) {
  for (size_t i = 0; i < kSize; ++i) {
    table[i] = static_cast<int>(std::lround(kOne * std::exp(-static_cast<double>(i) / range)));
  }
}

}  // namespace

SeedVotes::SeedVotes() {
  FillWithExp(likeness_, kColourRange);
  FillWithExp(vague_likeness_, kVagueColourRange);
  FillWithExp(nearness_, kDistanceRange * kStepsPerDistance);
}

void SeedVotes::Look(std::span<const Seed> seeds, double spacing_px,
                     const SeedNeighbours& neighbours, const cv::Mat3b& left_bgr) {
  neighbours_ = &neighbours;
  per_px_ = static_cast<float>(kStepsPerDistance / spacing_px);
  looks_.clear();
  looks_.reserve(seeds.size());
  for (const Seed& seed : seeds) {
    const int u = std::clamp(cvRound(seed.u), 0, left_bgr.cols - 1);
    const int v = std::clamp(cvRound(seed.v), 0, left_bgr.rows - 1);
    looks_.push_back({static_cast<int16_t>(u), static_cast<int16_t>(v), left_bgr(v, u),
                      2 * ToCounts(seed.disparity())});
  }
}

SeedVotes::Votes SeedVotes::Of(const SeedTriangle& triangle, cv::Point pixel,
                               const cv::Vec3b& colour, int near_plus_far) const {
  int alike_near = 0;
  int alike = kSilence;
  int close_near = 0;
  int close = kSilence * kOne;
  for (int corner : triangle) {
    if (static_cast<size_t>(corner) >= looks_.size()) continue;
    const std::span<const int> around = neighbours_->Of(corner);
    for (int seed : around.first(std::min(around.size(), kMostNeighbours))) {
      const SeedLook& look = looks_[static_cast<size_t>(seed)];
      const int side = look.twice_counts > near_plus_far ? 1 : -1;
      const auto difference = static_cast<size_t>(ColourDistance(colour, look.colour));
      const auto across = static_cast<float>(look.u - pixel.x);
      const auto down = static_cast<float>(look.v - pixel.y);
      const float steps = std::sqrt(across * across + down * down) * per_px_;
      const auto step = std::min(static_cast<size_t>(steps), nearness_.size() - 1);
      const int likeness = likeness_[difference];
      const int closeness = vague_likeness_[difference] * nearness_[step];
      alike_near += side * likeness;
      alike += likeness;
      close_near += side * closeness;
      close += closeness;
    }
  }
  return {static_cast<double>(alike_near) / alike, static_cast<double>(close_near) / close};
}

}  // namespace sprout
