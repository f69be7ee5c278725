#include "services/prior/seed_votes.h"

#include <algorithm>
#include <cmath>

#include "common/core/disparity_image.h"
#include "common/core/parallel.h"

namespace sprout {
namespace {

// Sums over the channels by which likeness falls to a quarter, for votes by colour, and to a half,
// for those by proximity.
constexpr float kColourRange = 10;
constexpr float kVagueColourRange = 60;
constexpr double kDistanceRange = 0.8;  // by which nearness falls to an eighth, in spacings
constexpr float kSilence = 0.01F;       // what weighs less has no say
// A seed whose plane misses both surfaces by so many counts has half a say.
constexpr float kMiss = 0.7F * DisparityImage::kCountsPerPixel;
constexpr float kNoColour = 1e6;  // that nothing is like

float Square(float x) { return x * x; }

template <size_t kSize>
float Sum(const std::array<float, kSize>& terms) {
  float sum = 0;
  for (float term : terms) sum += term;
  return sum;
}

}  // namespace

void SeedVotes::Look(std::span<const EdgeTriangle> edges, std::span<const LocalPlane> planes,
                     double spacing_px, const cv::Mat3b& left_bgr) {
  const double range_px = kDistanceRange * spacing_px;
  nearness_per_px2_ = static_cast<float>(1 / (range_px * range_px));
  edges_.resize(edges.size());
  ForEachParallel(edges.size(), [&](size_t i) {
    const std::span<const int> seeds = edges[i].nearby();
    edges_[i].looks = (seeds.size() + kLanes - 1) / kLanes;
    for (size_t k = 0; k < edges_[i].looks * kLanes; ++k) {
      Looks& looks = edges_[i].around[k / kLanes];
      const size_t lane = k % kLanes;
      const bool is_seed = k < seeds.size();
      LookAt(planes[static_cast<size_t>(seeds[is_seed ? k : 0])], left_bgr, lane, looks);
      if (!is_seed) looks.blue[lane] = kNoColour;
    }
  });
}

void SeedVotes::LookAt(const LocalPlane& plane, const cv::Mat3b& left_bgr, size_t lane,
                       Looks& looks) {
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  looks.u[lane] = plane.u;
  looks.v[lane] = plane.v;
  looks.counts[lane] = kOne * plane.disparity;
  looks.per_column[lane] = kOne * plane.per_column;
  looks.per_row[lane] = kOne * plane.per_row;
  const int u = cvRound(std::clamp(plane.u, 0.F, static_cast<float>(left_bgr.cols - 1)));
  const int v = cvRound(std::clamp(plane.v, 0.F, static_cast<float>(left_bgr.rows - 1)));
  const cv::Vec3b& bgr = left_bgr(v, u);
  looks.blue[lane] = bgr[0];
  looks.green[lane] = bgr[1];
  looks.red[lane] = bgr[2];
}

SeedVotes::Votes SeedVotes::Of(int edge, cv::Point pixel, const cv::Vec3b& colour, int near,
                               int far) const {
  const auto u = static_cast<float>(pixel.x);
  const auto v = static_cast<float>(pixel.y);
  const cv::Vec3f bgr = colour;
  const float middle = 0.5F * static_cast<float>(near + far);
  const float half_gap = 0.5F * static_cast<float>(near - far);
  Lanes alike{};
  Lanes alike_near{};  // less those for far
  Lanes close{};
  Lanes close_near{};
  const Edge& at = edges_[static_cast<size_t>(edge)];
  for (const Looks& looks : std::span(at.around).first(at.looks)) {
    for (size_t i = 0; i < kLanes; ++i) {
      const float across = u - looks.u[i];
      const float down = v - looks.v[i];
      const float above =
          looks.counts[i] + looks.per_column[i] * across + looks.per_row[i] * down - middle;
      const float difference = std::abs(bgr[0] - looks.blue[i]) +
                               std::abs(bgr[1] - looks.green[i]) + std::abs(bgr[2] - looks.red[i]);
      const float missed = 1 + Square((std::abs(above) - half_gap) * (1 / kMiss));
      const float unlike = 1 + Square(difference * (1 / kColourRange));
      const float by_colour = 1 / (missed * Square(unlike));
      const float vaguely_unlike = 1 + Square(difference * (1 / kVagueColourRange));
      const float far_off = 1 + (Square(across) + Square(down)) * nearness_per_px2_;
      const float by_proximity = 1 / (missed * vaguely_unlike * Square(far_off) * far_off);
      alike[i] += by_colour;
      alike_near[i] += std::copysign(by_colour, above);
      close[i] += by_proximity;
      close_near[i] += std::copysign(by_proximity, above);
    }
  }
  return {double{Sum(alike_near)} / (kSilence + Sum(alike)),
          double{Sum(close_near)} / (kSilence + Sum(close))};
}

}  // namespace sprout
