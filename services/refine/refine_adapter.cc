#include "services/refine/refine_adapter.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/geometry/native_ranges.h"
#include "common/geometry/widened_frame.h"
#include "common/inputs/check_inputs.h"
#include "services/refine/findings.h"
#include "services/refine/range/range_bias.h"
#include "services/refine/stereo/search_reach.h"

namespace sprout::refine {

namespace {

// Seeds of a result, and those with negative disparities.
struct SeedCounts {
  size_t all = 0;
  size_t negative_tof = 0;
  size_t negative_stereo = 0;
};

SeedCounts CountsOf(const StageResult& result) {
  SeedCounts counts;
  for (const PartOutput& output : result.outputs) {
    for (const Seed& seed : std::get<SeedSet>(output.value).seeds) {
      ++counts.all;
      if (seed.disparity() >= -1) continue;
      ++(seed.origin == SeedOrigin::kTof ? counts.negative_tof : counts.negative_stereo);
    }
  }
  return counts;
}

}  // namespace

// Rays are computed once a calibration.
const TofProjector& RefineAdapter::ProjectorOf(const Rig& rig) {
  const std::string rig_id = RigId(rig);
  for (const KeptProjector& kept : projectors_) {
    if (kept.rig_id == rig_id) return *kept.projector;
  }
  std::swap(projectors_[0], projectors_[1]);
  projectors_[0].rig_id.clear();  // until there is one: memory may run out
  projectors_[0].projector.emplace(rig);
  projectors_[0].rig_id = rig_id;
  return *projectors_[0].projector;
}

Result<SeedSet> RefineAdapter::Refine(const Frame& frame) {
  const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
  const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
  const TofZones zones = frame.tof_zones.value_or(TofZones());
  if (frame.tof->depth_m.empty()) {
    // Has no rays, so it is not worth keeping; the next frame may have an image again.
    const TofProjector no_camera(RigOfFrame(*frame.rig, *frame.tof));
    return refiner_.Compute(left, right, *frame.tof, no_camera, zones);
  }
  // The size is checked before rays are made for a ToF camera of whatever size a message claims.
  if (auto size = CheckTofSize(*frame.rig, *frame.tof); !size) {
    return tl::unexpected(size.error());
  }
  return refiner_.Compute(left, right, *frame.tof, ProjectorOf(*frame.rig), zones);
}

// How far the ToF camera is off in a frame that is due for this check; else nothing.
TofOffsetStatus RefineAdapter::OffsetOf(const Frame& frame) {
  if (frame.tof->depth_m.empty() || check_tof_every_ == 0) return {};
  if (!pose_checks_.IsDue(frame.id, check_tof_every_)) return {};
  TofOffset offset = refiner_.found().tof_offset;
  if (!aligns_tof_) {
    const TofProjector& projector = ProjectorOf(*frame.rig);
    int behind = 0;
    const std::vector<ProjectedPoint> points = projector.Project(*frame.tof, behind);
    const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
    const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
    offset = aligner_.Estimate(left, right, points, *frame.tof, projector);
  }
  if (!offset.sure) return {};
  return {.u_px = static_cast<float>(offset.du_px),
          .v_px = static_cast<float>(offset.dv_px),
          .sigma_px = static_cast<float>(std::hypot(offset.sigma_u_px, offset.sigma_v_px)),
          .is_off = offset.IsOff()};
}

// Checks the input of a frame that is due for it; returns whether it was.
bool RefineAdapter::CheckInput(const Frame& frame) {
  if (check_inputs_every_ == 0) return false;
  const bool has_tof = !frame.tof->depth_m.empty();
  const bool is_due = pair_checks_.IsDue(frame.id, check_inputs_every_);
  const bool is_tof_due = has_tof && tof_checks_.IsDue(frame.id, check_inputs_every_);
  if (!is_due && !is_tof_due) return false;
  const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
  const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
  const TofProjector* const projector = has_tof ? &ProjectorOf(*frame.rig) : nullptr;
  const bool unwraps = has_tof && unambiguous_range_m_ > 0;
  const inputs::Findings findings = inputs::CheckInputs(
      left, right,
      unwraps ? RangeUnwrapper().Unwrap(left, right, *frame.tof, *projector, unambiguous_range_m_)
              : *frame.tof,
      frame.rig->pair, projector);
  wrong_input_ =
      JoinedTexts(BadText(findings), BeyondSearch(findings, config_, frame.rig->pair, has_tof));
  return true;
}

// Whether more than a share of the range points have negative disparities.
bool RefineAdapter::HasPointsBelowZero(const Frame& frame, double share) {
  if (frame.tof->depth_m.empty() || !CheckTofSize(*frame.rig, *frame.tof)) return false;
  int behind = 0;
  const std::vector<ProjectedPoint> points = ProjectorOf(*frame.rig).Project(*frame.tof, behind);
  const auto below = std::ranges::count_if(
      points, [](const ProjectedPoint& point) { return point.seed.disparity() < -1; });
  return static_cast<double>(below) > share * static_cast<double>(points.size());
}

// Refines a frame whose far points may have negative disparities.
RefineAdapter::Refined RefineAdapter::RefineAnySign(const Frame& frame) {
  // Some points and matches are wrong in every frame, and a longer search finds more wrong ones.
  constexpr double kMinShare = 0.01;
  refiner_.SetColumns(0);  // also after a frame that ended with an exception
  refiner_.SetInfinity(InfinityPx(frame.rig->pair));
  const int columns = ColumnsBelowZero(frame.rig->pair);
  if (columns == 0 || frame.left.size() != frame.rig->pair.size()) return RefineNonNegative(frame);
  if (columns > kMaxColumns) {
    Refined result = RefineNonNegative(frame);
    if (result.answer.degenerate.empty()) {
      result.answer.degenerate = "cx_right - cx is above " + std::to_string(kMaxColumns) +
                                 " px, and far points with negative disparities are not looked for";
    }
    return result;
  }
  const auto share_of = [&](const Refined& result) {
    return kMinShare * static_cast<double>(CountsOf(result.answer).all);
  };
  std::optional<Refined> result;
  // Most rigs of this kind look at nothing so far away. That is seen at a tenth of the cost.
  if (!HasPointsBelowZero(frame, kMinShare)) {
    result = RefineNonNegative(frame);
    if (!result->fits ||
        static_cast<double>(refiner_.found().unanswered_cells) <= share_of(*result)) {
      return std::move(*result);
    }
  }
  if (result &&
      refiner_.ShareBelowZero(ToGrey(GreyestLeft(frame), left_grey_),
                              ToGrey(GreyestRight(frame), right_grey_), columns) <= kMinShare / 2) {
    return std::move(*result);
  }
  const Frame wide_frame = Widened(frame, columns);
  refiner_.SetColumns(columns);
  Refined wide = RefineNonNegative(wide_frame);
  refiner_.SetColumns(0);
  Narrow(wide.answer, columns, frame.left.size());
  const SeedCounts counts = CountsOf(wide.answer);
  if (static_cast<double>(counts.negative_tof) > share_of(wide)) return wide;
  if (!result) result = RefineNonNegative(frame);
  const bool is_better =
      static_cast<double>(counts.negative_tof + counts.negative_stereo) > share_of(wide) &&
      counts.all >= CountsOf(result->answer).all;
  return is_better ? std::move(wide) : std::move(*result);
}

// Refines a frame as if no disparity could be negative.
RefineAdapter::Refined RefineAdapter::RefineNonNegative(const Frame& frame) {
  Result<SeedSet> seeds = Refine(frame);
  Refined refined{.answer = {}, .fits = seeds.has_value()};
  StageResult& outcome = refined.answer;
  if (!seeds) {
    outcome.degenerate = seeds.error().text;
    outcome.outputs = {{Part::kSeeds, SeedSet()}, {Part::kLeftSeeds, SeedSet()}};
    return refined;
  }
  const RangeError& error = refiner_.found().range_error;
  outcome.degenerate = DegenerateText(refiner_.found(), *seeds, finds_stereo_seeds_);
  outcome.ranges_refused = error.RejectsAll() || refiner_.found().are_noise;
  outcome.finding = FindingText(refiner_.found());
  outcome.outputs.push_back({Part::kSeeds, *std::move(seeds)});
  outcome.outputs.push_back({Part::kLeftSeeds, refiner_.left_seeds()});
  return refined;
}

StageResult RefineAdapter::ProcessNative(const Frame& frame) {
  Refined refined = RefineAnySign(frame);
  StageResult& outcome = refined.answer;
  if (!refined.fits) return std::move(refined.answer);
  outcome.tof_offset = OffsetOf(frame);
  // The status has the newest line alone, so one of a frame that lacks seeds has the cure, too.
  const auto add_line = [&](const std::string& line) {
    outcome.degenerate = JoinedTexts(outcome.degenerate, line);
  };
  if (CheckInput(frame) || !outcome.degenerate.empty()) add_line(wrong_input_);
  if (check_inputs_every_ > 0) {
    add_line(hang_watch_.Add(frame));
    add_line(range_watch_.Add(*frame.tof, std::get<SeedSet>(outcome.outputs[0].value),
                              std::get<SeedSet>(outcome.outputs[1].value)));
  }
  return std::move(refined.answer);
}

StageResult RefineAdapter::Process(const Frame& frame) {
  std::optional<NativeRanges> native;
  if (CheckTofSize(*frame.rig, *frame.tof)) {
    native = FindNativeRanges(*frame.tof, frame.rig->tof);
  }
  if (!native) return ProcessNative(frame);
  Frame smaller = frame;
  smaller.tof = native->tof;
  smaller.rig->tof = native->camera;
  StageResult result = ProcessNative(smaller);
  for (PartOutput& output : result.outputs) {
    for (Seed& seed : std::get<SeedSet>(output.value).seeds) native->ToEnlarged(seed);
  }
  const std::string enlarged =
      native->tof.depth_m.size() == frame.tof->depth_m.size()
          ? fmt::format(
                "the range image repeats {} points in the pixels around, and is taken as these",
                cv::countNonZero(native->tof.depth_m))
          : fmt::format(
                "the range image of {} pixels is one of {} that was enlarged, and is taken as that",
                SizeText(frame.tof->depth_m.size()), SizeText(native->tof.depth_m.size()));
  result.finding = JoinedTexts(enlarged, result.finding.value_or(""));
  return result;
}

}  // namespace sprout::refine
