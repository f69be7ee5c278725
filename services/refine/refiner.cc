#include "services/refine/refiner.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/core/image.h"
#include "common/core/parallel.h"
#include "common/core/window_sums.h"
#include "services/refine/range/range_rules.h"
#include "services/refine/stereo/stereo_rules.h"
#include "services/refine/surface/range_steps.h"
#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {
namespace {

constexpr int kWindow = SurfaceRules::kWindow;
constexpr int kRadius = SurfaceRules::kRadius;

int Pixel(float position) { return static_cast<int>(std::lround(position)); }

// Whether the window around a pixel lies in the image.
bool WindowFits(float u, float v, cv::Size size) { return IsInside(u, v, size, kRadius - 0.5); }

// Sum of the grey values in the window around a pixel.
int WindowSum(const cv::Mat1b& image, int u, int v) {
  int sum = 0;
  for (int y = v - kRadius; y <= v + kRadius; ++y) {
    const uint8_t* row = image[y] + u - kRadius;
    for (int x = 0; x < kWindow; ++x) sum += row[x];
  }
  return sum;
}

}  // namespace

Refiner::Refiner(const RefineConfig& config) : config_(config), stereo_(config) {
  RequireInRange(config, "refine");
}

Result<SeedSet> Refiner::Compute(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                                 const TofProjector& projector, const TofZones& zones) {
  const Rig& rig = projector.rig();
  const cv::Size size = rig.pair.size();
  if (left.size() != size || right.size() != size) {
    return Fail("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                ": allowed is the calibrated size " + SizeText(size));
  }
  const CellGrid grid(stereo_.SpacingPx(left.cols), size);
  if (const Result<void> set = zones_.Set(zones, rig.pair, grid); !set) {
    return tl::unexpected(set.error());
  }
  SeedSet result;
  found_ = {};
  before_move_.clear();
  doubts_edges_ = false;
  left_seeds_ = {.seeds = std::move(left_seeds_.seeds)};
  // Projection of every ToF point to (u, u', v) (paper, II-A).
  points_ = projector.Project(tof, result.outside, std::move(points_));
  result.raw = static_cast<int32_t>(points_.size()) + result.outside;
  if (config_.unambiguous_range_m() > 0) {
    result.contradicted =
        unwrapper_.Apply(left, right, tof, projector, config_.unambiguous_range_m(), points_);
  }
  left_seeds_.seeds.clear();
  left_seeds_.seeds.reserve(points_.size());
  SearchAsFarAsPoints(left.cols);
  if (!points_.empty()) {
    surface_.Set(rig, points_);
    for (ProjectedPoint& point : points_) point.seed.sigma_px = 0;
    if (config_.align_tof()) Align(left, right, tof, projector);
    if (config_.range_bias() != RefineConfig::OFF)
      CorrectRanges(left, right, tof, projector, result);
    AddNoise(left, right);
    KeepReliable(left, right, tof, result);
    KeepVisible(left, right, result);
  }
  if (config_.stereo_seeds()) AddStereo(left, right, grid, result);
  if (!zones.views.empty()) FillFromZones(result, grid, left.size());
  return result;
}

// Seeds from the pair, where the points leave room for them.
void Refiner::AddStereo(const cv::Mat1b& left, const cv::Mat1b& right, const CellGrid& grid,
                        SeedSet& result) {
  const bool nothing_fits = found_.range_error.rows_shifted ||
                            (found_.range_error.pair_unfit &&
                             found_.range_error.contradicted_share > RangeRules::kNothingFits);
  if (nothing_fits) return;
  const double spacing_px = points_.empty() ? 0 : surface_.spacing_px();
  const bool dense = !points_.empty() && !stereo_.IsCoarse(spacing_px, left.cols);
  stereo_.SetColumnError(found_.range_error.columns_px);
  // A sensor that is refused for its place was found wrong with all of them.
  const std::span<const Seed> stereo =
      found_.range_error.rejected
          ? stereo_.found()
          : stereo_.Find(left, right, result.seeds, Covered(dense), spacing_px, zones_.most_px());
  found_.unanswered_cells = stereo_.unanswered();
  if (dense) result.contradicted += unsure_.Drop(grid, noise_, stereo, result.seeds);
  result.seeds.insert(result.seeds.end(), stereo.begin(), stereo.end());
}

// The frame as the estimates of the range sensor's errors take it.
RangeInput Refiner::InputOf(const cv::Mat1b& left, const cv::Mat1b& right, const Rig& rig) {
  return {.left = left,
          .right = right,
          .rig = rig,
          .surface = surface_,
          .noise_px = surface_.Noise(points_).middle_px,
          .coarse = stereo_.IsCoarse(surface_.spacing_px(), left.cols)};
}

// Moves the points of a sensor whose pose is off, or whose scan is of another moment.
void Refiner::Align(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                    const TofProjector& projector) {
  const Rig& rig = projector.rig();
  if (surface_.has_pixels()) {
    found_.tof_offset = aligner_.Estimate(left, right, points_, tof, projector);
    if (!found_.tof_offset.IsOff()) return;
    before_move_ = points_;
    RangeNodes before, after;
    before.Set(InputOf(left, right, rig), points_);
    ApplyOffset(found_.tof_offset, rig, points_);
    surface_.Set(rig, points_);
    after.Set(InputOf(left, right, rig), points_);
    if (after.SigmasWorseThan(before) <= AlignmentRules::kWorseSigmas) return;
    found_.tof_offset = {};
    doubts_edges_ = true;
    points_ = before_move_;
  } else {
    found_.scan_move = scan_aligner_.Estimate(InputOf(left, right, rig), points_);
    before_move_ = points_;
    if (!found_.scan_move.is_off) return;
    ApplyMove(found_.scan_move, rig, points_);
  }
  surface_.Set(rig, points_);
}

// Drops the points beside the edges of a smoothed range image, or those of near surfaces that reach
// beyond their edges. Not without stereo: nothing would take their place.
void Refiner::DropBesideEdges(const cv::Mat1b& left, const cv::Mat1b& right, const Rig& rig,
                              SeedSet& result) {
  if (!surface_.has_pixels() || !config_.stereo_seeds()) return;
  const auto before = std::ssize(points_);
  found_.smoothing = DropSmoothed(surface_, points_);
  if (!found_.smoothing) {
    const double noise_px = surface_.Noise(points_).middle_px;
    found_.fattening = DropFattened(surface_, left, right, noise_px, points_, before_fattening_);
  }
  if (!found_.smoothing && !found_.fattening) return;
  result.contradicted += static_cast<int32_t>(before - std::ssize(points_));
  surface_.Set(rig, points_);
}

// Undoes what was moved and dropped so far: images that do not fit each other cannot correct a
// sensor.
void Refiner::UndoCorrections(const Rig& rig, SeedSet& result) {
  if (found_.fattening) {
    result.contradicted -= static_cast<int32_t>(before_fattening_.size() - points_.size());
    points_ = before_fattening_;
    found_.fattening = {};
  }
  if (found_.tof_offset.IsOff()) {
    ApplyOffset({.du_px = -found_.tof_offset.du_px, .dv_px = -found_.tof_offset.dv_px}, rig,
                points_);
    found_.tof_offset = {};
  }
  if (found_.scan_move.is_off) {
    points_ = before_move_;
    found_.scan_move = {};
  }
  surface_.Set(rig, points_);
}

// Moves the points to where the images show them, and drops those that they contradict.
void Refiner::CorrectRanges(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                            const TofProjector& projector, SeedSet& result) {
  const Rig& rig = projector.rig();
  DropBesideEdges(left, right, rig, result);
  const auto is_displaced = [&] {
    found_.range_error = range_.Apply(
        InputOf(left, right, rig),
        {.field = config_.range_bias() == RefineConfig::FIELD,
         .has_wrong_edges = bool{found_.fattening},
         .error_m = config_.range_error_m(),
         .matches = [&] { return stereo_.Find(left, right, {}, {}, 0, zones_.most_px()); }},
        points_);
    return IsDisplaced(left, right, tof, projector);
  };
  if (is_displaced() && !(AlignAgain(left, right, rig) && !is_displaced())) {
    found_.range_error.rejected = true;
  }
  const bool is_unknown = found_.range_error.IsUnknown();
  if (is_unknown) UndoCorrections(rig, result);
  const float smoothed_px = found_.smoothing ? SurfaceRules::kSmoothedSigmaPx : 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    float& sigma_px = points_[i].seed.sigma_px;
    if (!found_.contradiction.sigma_px.empty())
      sigma_px = std::max(sigma_px, found_.contradiction.sigma_px[i]);
    sigma_px = std::hypot(sigma_px, smoothed_px);
  }
  AddStepSigma(rig.pair, tof, points_);
  if (is_unknown) return;
  const auto is_contradicted = [&](size_t i) {
    return found_.range_error.rejected || range_.contradicted()[i] != 0 ||
           (!found_.contradiction.points.empty() && found_.contradiction.points[i] != 0);
  };
  size_t kept = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    if (!is_contradicted(i)) points_[kept++] = points_[i];
  }
  if (found_.range_error.moved_share == 0 && kept == points_.size()) return;
  result.contradicted += static_cast<int32_t>(points_.size() - kept);
  points_.resize(kept);
  surface_.Set(rig, points_);
}

// Adds what zones say where nothing else does. It goes to the left seeds: it is no correspondence
// to grow from.
void Refiner::FillFromZones(const SeedSet& result, const CellGrid& grid, cv::Size image) {
  Join(result.seeds, left_seeds_.seeds, all_seeds_);
  all_points_.Set(all_seeds_, grid);
  cv::Mat1b known(grid.size, uint8_t{0});
  for (const Seed& seed : all_seeds_) {
    const cv::Point cell(grid.At(seed.u), grid.At(seed.v));
    if (cv::Rect({}, grid.size).contains(cell)) known(cell) = 1;
  }
  constexpr int kSide = 2 * ZoneRules::kGapCells + 1;
  cv::dilate(known, known, cv::Mat1b::ones(kSide, kSide));
  for (int y = 0; y < grid.size.height; ++y) {
    for (int x = 0; x < grid.size.width; ++x) {
      if (known(y, x) != 0) continue;
      const std::optional<ZoneSurface> surface = zones_.SurfaceAt({x, y});
      if (!surface || !AddsInformation(*surface, all_points_, {x, y})) continue;
      const cv::Point2d centre = grid.CentrePx({x, y});
      if (!IsInside(centre.x, centre.y, image, 0)) continue;  // the last cells may reach beyond
      if (!(surface->disparity_px >= 0 && surface->disparity_px < kMaxSide)) continue;
      left_seeds_.seeds.push_back(
          {.u = static_cast<float>(centre.x),
           .v = static_cast<float>(centre.y),
           .u_right = static_cast<float>(centre.x - surface->disparity_px),
           .sigma_px = static_cast<float>(std::clamp(surface->sigma_px, SurfaceRules::kMinSigmaPx,
                                                     SurfaceRules::kMaxSigmaPx))});
      ++left_seeds_.raw;
    }
  }
}

// Points that are far apart differ by the shape of the scene as well as by their noise.
RangeNoise Refiner::Noise(const cv::Mat1b& left, const cv::Mat1b& right) {
  RangeNoise noise = surface_.Noise(points_);
  const bool coarse = config_.stereo_seeds() && stereo_.IsCoarse(surface_.spacing_px(), left.cols);
  if (!coarse || noise.middle_px <= SurfaceRules::kMinSigmaPx) return noise;
  const double part = std::min(1.0, ImageNoisePx(left, right, points_) / noise.middle_px);
  noise.scale *= part;
  noise.middle_px *= part;
  return noise;
}

// Adds the noise to what the points may be off by otherwise.
void Refiner::AddNoise(const cv::Mat1b& left, const cv::Mat1b& right) {
  noise_ = Noise(left, right);
  const bool coarse = stereo_.IsCoarse(surface_.spacing_px(), left.cols);
  for (ProjectedPoint& point : points_) {
    Seed& seed = point.seed;
    const double noise_px =
        coarse ? noise_.PxAt(seed.disparity()) : surface_.NoisePxAt(point, noise_);
    seed.sigma_px = std::clamp(std::hypot(seed.sigma_px, static_cast<float>(noise_px)),
                               static_cast<float>(SurfaceRules::kMinSigmaPx),
                               static_cast<float>(SurfaceRules::kMaxSigmaPx));
  }
}

// Where points leave no room for stereo seeds. Dark points are not believed. Loose ones count: on
// which side of an edge they lie the prior decides better than stereo. Dense points count unless
// they are unsure, where a sensor is off with their noise; between coarse ones stereo is asked
// anyway.
std::span<const cv::Point2f> Refiner::Covered(bool dense) {
  covered_.clear();
  const bool is_off = found_.range_error.moved_share > 0;
  const auto is_unsure = [&](const Seed& point) {
    return is_off ? point.sigma_px > StereoRules::kAskedSigmaPx
                  : UnsurePoints::IsUnsure(point, noise_);
  };
  for (size_t i = 0; i < points_.size(); ++i) {
    const bool sure = !dense || !is_unsure(points_[i].seed);
    if (fates_[i] != Fate::kDark && fates_[i] != Fate::kOutside && sure && !found_.are_noise) {
      covered_.emplace_back(points_[i].seed.u, points_[i].seed.v);
    }
  }
  return covered_;
}

// Keeps the points that are reliable by themselves, and counts the others.
void Refiner::KeepReliable(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                           SeedSet& result) {
  fates_.resize(points_.size());
  ForEachParallel(points_.size(),
                  [&](size_t i) { fates_[i] = FateOf(points_[i], left, right, tof); });
  DropNoise();
  kept_.clear();
  for (const bool in_both : {true, false}) {
    SeedSet& counts = in_both ? result : left_seeds_;
    for (size_t i = 0; i < points_.size(); ++i) {
      const Seed& seed = points_[i].seed;
      if (WindowFits(seed.u_right, seed.v, left.size()) != in_both) continue;
      if (!in_both || fates_[i] == Fate::kOutside) ++result.outside;
      if (!in_both && fates_[i] != Fate::kOutside) ++left_seeds_.raw;
      if (fates_[i] == Fate::kDark) ++counts.dark;
      if (fates_[i] == Fate::kLoose) ++counts.loose;
      if (fates_[i] == Fate::kKept) kept_.push_back(points_[i]);
    }
    if (in_both) kept_in_both_ = kept_.size();
  }
}

// Takes all points for noise where most are loose: then the others have neighbours by chance. Edges
// make few of them loose, 7 in 100 with a camera, 5 with 4 beams of a lidar.
void Refiner::DropNoise() {
  const auto in_picture = std::ranges::count_if(
      fates_, [](Fate fate) { return fate == Fate::kKept || fate == Fate::kLoose; });
  found_.are_noise = in_picture >= SurfaceRules::kMinNoisePoints &&
                     2 * std::ranges::count(fates_, Fate::kLoose) > in_picture;
  if (found_.are_noise) std::ranges::replace(fates_, Fate::kKept, Fate::kLoose);
}

Refiner::Fate Refiner::FateOf(const ProjectedPoint& point, const cv::Mat1b& left,
                              const cv::Mat1b& right, const TofImage& tof) const {
  const Seed& seed = point.seed;
  // Two images as wide as these cannot show a larger disparity.
  const bool possible = seed.disparity() >= 0 && seed.disparity() < static_cast<float>(left.cols);
  if (!WindowFits(seed.u, seed.v, left.size()) || !possible) return Fate::kOutside;
  // Dark (paper, II-B): unreliable depth on very dark regions.
  if (WindowSum(left, Pixel(seed.u), Pixel(seed.v)) < kWindow * kWindow * config_.min_mean_grey() ||
      (!tof.amplitude.empty() &&
       !(tof.amplitude(point.tof_v, point.tof_u) >= config_.min_amplitude()))) {
    return Fate::kDark;
  }
  // Loose, beyond the paper: over a wide spacing a slant alone puts neighbours further off than the
  // tolerance.
  const double tolerance_px =
      std::max(config_.loose_tolerance_px(), SurfaceRules::kSteepest * surface_.spacing_px());
  const bool loose = config_.loose_tolerance_px() > 0 && surface_.IsIsolated(point, tolerance_px) &&
                     !surface_.IsConfirmed(point, tolerance_px, left, right);
  return loose ? Fate::kLoose : Fate::kKept;
}

// Makes seeds of the kept points that no nearer surface makes doubtful.
void Refiner::KeepVisible(const cv::Mat1b& left, const cv::Mat1b& right, SeedSet& result) {
  std::vector<Seed>& seeds = result.seeds;
  seeds.clear();
  seeds.reserve(kept_in_both_);
  for (size_t i = 0; i < kept_in_both_; ++i) seeds.push_back(kept_[i].seed);
  // Background (paper, II-B): what the ToF camera sees beside or behind a nearer surface.
  // What it drops still hides other points.
  const std::vector<uint8_t>& background =
      background_.Find(seeds, left.size(), config_.background_tolerance_px());
  const HiddenRule rule{.core = config_.hidden_core(),
                        .reach = config_.hidden_reach(),
                        .tolerance_px = config_.hidden_tolerance_px()};
  const std::vector<Hidden>& hidden = surface_.FindHidden(kept_, kept_in_both_, left, right, rule);
  size_t next = 0;
  for (size_t i = 0; i < seeds.size(); ++i) {
    if (background[i] != 0) {
      ++result.background;
    } else if (hidden[i].from_left || hidden[i].from_right) {
      ++result.hidden;
      if (hidden[i].from_left) continue;
      ++left_seeds_.raw;
      left_seeds_.seeds.push_back(seeds[i]);
    } else {
      seeds[next++] = seeds[i];
    }
  }
  seeds.resize(next);
  for (size_t i = kept_in_both_; i < kept_.size(); ++i) {
    if (hidden[i].from_left) {
      ++left_seeds_.hidden;
    } else {
      left_seeds_.seeds.push_back(kept_[i].seed);
    }
  }
}

}  // namespace sprout::refine
