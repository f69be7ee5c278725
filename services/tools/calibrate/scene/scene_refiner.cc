#include "services/tools/calibrate/scene/scene_refiner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/geometry/projection.h"
#include "services/tools/calibrate/scene/scene_checks.h"
#include "services/tools/calibrate/scene/scene_deviations.h"

namespace sprout::calibrate {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// Images that are off by less are not rectified again, which takes most of the time: depth edges
// are found in them as well.
constexpr double kSameImagesPx = 0.5;

double MedianOrUnknown(std::vector<double> values) {
  return values.empty() ? kNotMeasured : Median(values);
}

std::vector<double> Sizes(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values;
}

// Range of a patch along the ray, with the offset applied.
double RangeOf(const TofPatch& patch, double offset_m) {
  return patch.distance_m / patch.per_range + offset_m;
}

// Matches with the corrections added to what the ToF camera measured.
std::vector<SceneMatch> Corrected(std::vector<SceneMatch> matches, const SceneRefinement& found,
                                  double offset_m) {
  const AmplitudeCorrection& light = found.light;
  if (found.curve.empty() && light.empty()) return matches;
  for (SceneMatch& match : matches) {
    if (!match.tof) continue;
    TofPatch& patch = *match.tof;
    patch.distance_m +=
        patch.per_range * (CorrectionAt(found.curve, RangeOf(patch, offset_m)).offset_m +
                           light.offset_m * BrightnessOf(patch.amplitude, light.middle));
  }
  return matches;
}

// Whether the ToF camera's turn is that of the pass before, to a third of its standard deviation.
bool TofStandsStill(const RigNumbers& before, const AdjustedScene& now) {
  return std::ranges::all_of(std::array{kTofPitch, kTofYaw, kTofRoll}, [&](RigNumber number) {
    return 3 * std::abs(now.change[number] - before[number]) <= now.frames_sigma[number];
  });
}

}  // namespace

SceneEffort QuickEffort(const RectifiedPair& pair) {
  // Pixels in which features are searched: more of them show the same, and take more time
  // (services/selfcalibrate/NOTES.md). Some 1500 matches of all frames together know a turn to a
  // hundredth of a pixel.
  constexpr double kSearchedPixels = 0.15e6;
  const double times = std::sqrt(double(pair.width) * pair.height / kSearchedPixels);
  return {.match = {.shrink = std::max(1, static_cast<int>(std::lround(times))), .max_in_cell = 20},
          .max_matches = 1500};
}

SceneRefiner::SceneRefiner(const RawRig& rig, const Rectification& images,
                           const SceneEffort& effort)
    : rig_(rig), images_(images), effort_(effort) {}

Result<void> SceneRefiner::Add(const cv::Mat& left, const cv::Mat& right, const TofImage& tof) {
  const RectifiedPair& pair = images_.pair;
  if (left.size() != pair.size() || right.size() != pair.size()) {
    return Fail("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                ": allowed is the calibrated size " + SizeText(pair.size()));
  }
  const Rig rig = RigOfFrame(RectifiedRig(rig_, images_), tof);
  if (const Result<void> fits = CheckTofSize(rig, tof); !fits) return fits;

  const cv::Mat1b left_grey = ToGrey(left).clone();
  const cv::Mat1b right_grey = ToGrey(right).clone();
  const PairMatches found = MatchPair(left_grey, right_grey, effort_.match);
  const Eigen::Matrix3d left_back = BackOf(images_.left_turn);
  const Eigen::Matrix3d right_back = BackOf(images_.right_turn);
  for (const PairMatch& match : found.matches) {
    const Eigen::Vector2d at_left =
        RawPixel(rig_.left, left_back, pair, pair.cx, match.left.x, match.left.y);
    const Eigen::Vector2d at_right =
        RawPixel(rig_.right, right_back, pair, pair.cx_right, match.right.x, match.right.y);
    // With a wrong yaw the farthest points lie behind infinity.
    constexpr double kFarthestM = 1000;
    const double disparity_px =
        std::max(match.left.x - match.right.x, pair.DisparityFromDepth(kFarthestM));
    const double depth_m = pair.DepthFromDisparity(disparity_px);
    const Eigen::Vector3d point =
        left_back * Eigen::Vector3d(depth_m * (match.left.x - pair.cx) / pair.focal_px,
                                    depth_m * (match.left.y - pair.cy) / pair.focal_px, depth_m);
    if (!(point.z() > 0)) continue;
    matches_.push_back({.view = views_.size(),
                        .left = {at_left.x(), at_left.y()},
                        .right = {at_right.x(), at_right.y()},
                        .inverse_depth = 1 / point.z(),
                        .tof = {}});
    left_px_.push_back(match.left);
  }
  views_.push_back({.left = left_grey,
                    .right = right_grey,
                    .tof = {.depth_m = tof.depth_m.clone(), .amplitude = tof.amplitude.clone()},
                    .matches = static_cast<int>(found.matches.size()),
                    .features = std::min(found.left_features, found.right_features)});
  return {};
}

void SceneRefiner::AttachPatches(const RawRig& rig) {
  if (rig_.tof.width == 0) return;
  const TofProjector projector(RectifiedRig(rig, images_));
  size_t i = 0;
  for (size_t view = 0; view < views_.size(); ++view) {
    if (views_[view].tof.depth_m.empty()) {
      while (i < matches_.size() && matches_[i].view == view) ++i;
      continue;
    }
    const TofPatches patches(views_[view].tof, projector);
    for (; i < matches_.size() && matches_[i].view == view; ++i) {
      matches_[i].tof = patches.At(left_px_[i]);
    }
  }
}

void SceneRefiner::ThinOut() {
  const size_t most = effort_.max_matches;
  if (matches_.size() <= most) return;
  for (size_t i = 0; i < most; ++i) {
    const size_t from = i * matches_.size() / most;
    matches_[i] = matches_[from];
    left_px_[i] = left_px_[from];
  }
  matches_.resize(most);
  left_px_.resize(most);
}

std::optional<EdgeShift> SceneRefiner::FindEdges(const RigNumbers& change) {
  edge_views_ = 0;
  if (rig_.tof.width == 0) return std::nullopt;
  const RawRig changed = Changed(rig_, change);
  const bool is_same = MaxMoved(change, images_.pair).right <= kSameImagesPx;
  const Rectification to = is_same ? images_ : RectificationOf(changed);
  const BilinearRemap left = is_same ? BilinearRemap() : LeftAgain(changed, to);
  const BilinearRemap right = is_same ? BilinearRemap() : RightAgain(changed, to);
  const TofProjector projector(RectifiedRig(changed, to));
  std::array<std::vector<double>, 2> turns;
  std::array<std::vector<double>, 2> sigmas;
  for (const View& view : views_) {
    if (view.tof.depth_m.empty()) continue;
    int behind = 0;
    const std::vector<ProjectedPoint> points = projector.Project(view.tof, behind);
    const refine::TofOffset offset = aligner_.Estimate(
        is_same ? view.left : cv::Mat1b(left.Apply(view.left)),
        is_same ? view.right : cv::Mat1b(right.Apply(view.right)), points, view.tof, projector);
    if (!offset.sure) continue;
    // The turn is that of refine::ApplyOffset().
    turns[0].push_back(-offset.dv_px / to.pair.focal_px);
    turns[1].push_back(offset.du_px / to.pair.focal_px);
    sigmas[0].push_back(offset.sigma_v_px / to.pair.focal_px);
    sigmas[1].push_back(offset.sigma_u_px / to.pair.focal_px);
  }
  edge_views_ = static_cast<int>(turns[0].size());
  if (edge_views_ == 0) return std::nullopt;
  // Frames share what makes edges look shifted, so that more of them are hardly surer than one.
  return EdgeShift{.turn = {Median(turns[0]), Median(turns[1])},
                   .sigma = {Median(sigmas[0]), Median(sigmas[1])},
                   .applied = {change[kTofPitch], change[kTofYaw], change[kTofRoll]},
                   .rectified_from_left = BackOf(to.left_turn).transpose()};
}

Result<void> SceneRefiner::Adjust(const SceneWishes& wishes, SceneRefinement& result) {
  // The ToF camera's pose decides which points are compared, so this is done until its turn stands
  // still: first with all numbers, since a change that is sure looks like chance before, then with
  // those that are sure, and the ranges' curve. A turn looks much like an error of the ranges, and
  // is halved from pass to pass when it is one.
  constexpr int kFreePasses = 5;
  constexpr int kMaxPasses = 12;
  const auto is_tof = [](const SceneMatch& match) { return match.tof.has_value(); };
  bool only_sure = false;
  bool stands_still = false;
  for (int pass = 0; pass < kMaxPasses && !(only_sure && stands_still); ++pass) {
    only_sure |= stands_still || pass >= kFreePasses;
    const RigNumbers change = result.adjusted.change;
    AttachPatches(Changed(rig_, change));
    if (pass == 0) result.before = FitOf(ResidualsOf(rig_, matches_, Depths(matches_), {}));
    result.tof_matches = static_cast<int>(std::ranges::count_if(matches_, is_tof));
    const std::optional<EdgeShift> edges = FindEdges(change);
    const bool sees_tof = result.tof_matches >= kMinTofMatches;
    for (const RigNumber number : {kTofPitch, kTofYaw, kTofRoll, kRangeOffset}) {
      result.wanted[number] = sees_tof;
    }
    result.wanted[kYaw] = sees_tof || wishes.yaw;
    Result<AdjustedScene> adjusted = AdjustScene(
        rig_, Corrected(matches_, result, change[kRangeOffset]), edges, result.wanted, only_sure);
    if (!adjusted) return tl::unexpected(adjusted.error());
    stands_still = TofStandsStill(change, *adjusted);
    result.adjusted = std::move(*adjusted);
    if (only_sure) FindCorrections(result);
  }
  return {};
}

Result<SceneRefinement> SceneRefiner::Refine(const SceneWishes& wishes) {
  if (const Result<void> enough = CheckScene(views_, matches_, left_px_, images_.pair); !enough) {
    return tl::unexpected(enough.error());
  }
  ThinOut();
  SceneRefinement result;
  result.wanted.fill(true);
  result.wanted[kPlaceY] = result.wanted[kPlaceZ] = wishes.place;
  result.wanted[kFocal] = result.wanted[kFocalRight] = wishes.focal;
  result.wanted[kRowRight] = wishes.row;
  if (const Result<void> done = Adjust(wishes, result); !done) {
    return tl::unexpected(done.error());
  }
  const RigNumbers& change = result.adjusted.change;
  const std::vector<MatchResidual> before = ResidualsOf(rig_, matches_, Depths(matches_), {});
  matches_ = Corrected(std::move(matches_), result, change[kRangeOffset]);
  const std::vector<MatchResidual> after =
      ResidualsOf(rig_, matches_, result.adjusted.inverse_depths, change);
  if (const Result<void> agree = CheckAgreement(matches_, after, views_.size()); !agree) {
    return tl::unexpected(agree.error());
  }
  result.rig = Changed(rig_, change);
  result.rig.range_correction = Chained(rig_.range_correction, result.curve);
  if (!result.light.empty()) {
    result.rig.amplitude_correction = result.light;
    result.rig.amplitude_correction.offset_m += rig_.amplitude_correction.offset_m;
  }
  if (const Result<void> usable = CheckRawRig(result.rig); !usable) {
    return Fail("the refined calibration cannot be used: " + usable.error().text);
  }
  result.views = static_cast<int>(views_.size());
  result.matches = static_cast<int>(matches_.size());
  result.edge_views = edge_views_;
  result.after = FitOf(after);
  for (size_t i = 0; i < matches_.size(); ++i) {
    result.shown.push_back({.left = left_px_[i],
                            .rows_before_px = before[i].rows_px,
                            .rows_after_px = after[i].rows_px});
  }
  result.reasons = ReasonsAgainst(result);
  return result;
}

// The amplitude at which ranges are not corrected: that of the rig, or else the median.
double SceneRefiner::MiddleAmplitude() const {
  if (!rig_.amplitude_correction.empty()) return rig_.amplitude_correction.middle;
  std::vector<double> amplitudes;
  for (const SceneMatch& match : matches_) {
    if (match.tof && match.tof->amplitude > 0) amplitudes.push_back(match.tof->amplitude);
  }
  return amplitudes.empty() ? 0 : Median(amplitudes);
}

void SceneRefiner::FindCorrections(SceneRefinement& result) const {
  const AdjustedScene& adjusted = result.adjusted;
  const double middle = MiddleAmplitude();
  const std::vector<MatchResidual> residuals =
      ResidualsOf(rig_, matches_, adjusted.inverse_depths, adjusted.change);
  std::vector<RangeSample> samples;
  for (size_t i = 0; i < matches_.size(); ++i) {
    if (!residuals[i].tof_m || !(std::abs(*residuals[i].tof_px) > 0)) continue;
    const TofPatch& patch = *matches_[i].tof;
    const double m_per_px = std::abs(*residuals[i].tof_m / *residuals[i].tof_px);
    samples.push_back(
        {.range_m = RangeOf(patch, adjusted.change[kRangeOffset]),
         .error_m = *residuals[i].tof_m / patch.per_range,
         .sigma_m = std::hypot(patch.sigma_m, adjusted.match_sigma_px * m_per_px) / patch.per_range,
         .shared_m = kSharedMatchPx * m_per_px / patch.per_range,
         .yaw_m = rig_.left.fx * adjusted.sigma[kYaw] * m_per_px / patch.per_range,
         .part = PartOf(matches_[i].left, rig_.left),
         .brightness = BrightnessOf(patch.amplitude, middle)});
  }
  const RangeFit fit = FitRangeCurve(std::move(samples));
  result.curve = fit.curve;
  result.light = {};
  if (fit.light_m != 0) result.light = {fit.light_m, fit.light_sigma_m, middle};
}

SceneFit SceneRefiner::FitOf(const std::vector<MatchResidual>& residuals) const {
  std::vector<double> rows;
  std::vector<double> tof_px;
  std::vector<double> tof_m;
  for (const MatchResidual& residual : residuals) {
    rows.push_back(residual.rows_px);
    if (!residual.tof_m) continue;
    tof_px.push_back(*residual.tof_px);
    tof_m.push_back(*residual.tof_m);
  }
  return {.rows_median_px = MedianOrUnknown(rows),
          .rows_abs_median_px = MedianOrUnknown(Sizes(rows)),
          .rows_abs_95_px = Quantile(Sizes(rows), 0.95),
          .tof_px = MedianOrUnknown(tof_px),
          .tof_abs_px = MedianOrUnknown(Sizes(tof_px)),
          .tof_m = MedianOrUnknown(tof_m),
          .tof_abs_m = MedianOrUnknown(Sizes(tof_m))};
}

const SceneRefiner::View& SceneRefiner::best_view() const {
  return *std::ranges::max_element(views_, {}, &View::matches);
}

BilinearRemap SceneRefiner::LeftAgain(const RawRig& by, const Rectification& to) const {
  return RectifyAgain({rig_.left, images_.left_turn, images_.pair, images_.pair.cx},
                      {by.left, to.left_turn, to.pair, to.pair.cx});
}

BilinearRemap SceneRefiner::RightAgain(const RawRig& by, const Rectification& to) const {
  return RectifyAgain({rig_.right, images_.right_turn, images_.pair, images_.pair.cx_right},
                      {by.right, to.right_turn, to.pair, to.pair.cx_right});
}

}  // namespace sprout::calibrate
