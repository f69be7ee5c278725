#include "services/temporal/temporal_filter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "common/core/parallel.h"
#include "services/temporal/motion_estimator.h"
#include "services/temporal/point_tracker.h"

namespace sprout::temporal {
namespace {

// Points with a larger variance, px², or a smaller ρ, px, say nothing about the translation, so
// they are not used.
constexpr float kMaxPointVariance = 1;
constexpr double kMinPointRho = 0.5;

// (T3): H = K R K⁻¹ and t = K t / (f b).
PixelMotion PixelMotionOf(const Pose& motion, const RectifiedPair& pair) {
  Eigen::Matrix3d camera;
  camera << pair.focal_px, 0, pair.cx, 0, pair.focal_px, pair.cy, 0, 0, 1;
  Eigen::Matrix3d inverse;
  inverse << 1 / pair.focal_px, 0, -pair.cx / pair.focal_px, 0, 1 / pair.focal_px,
      -pair.cy / pair.focal_px, 0, 0, 1;
  const Eigen::Matrix3d h = camera * motion.rotation.toRotationMatrix() * inverse;
  const Eigen::Vector3d t = camera * motion.translation_m / (pair.focal_px * pair.baseline_m);
  PixelMotion result;
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(result.h[0].data()) = h.cast<float>();
  Eigen::Map<Eigen::Vector3f>(result.t.data()) = t.cast<float>();
  return result;
}

// Whether pixels can be moved by it: a finite pose may exceed the range of float.
bool IsUsable(const PixelMotion& motion) {
  const auto finite = [](float number) { return std::isfinite(number); };
  return std::ranges::all_of(motion.t, finite) &&
         std::ranges::all_of(motion.h,
                             [&](const auto& row) { return std::ranges::all_of(row, finite); });
}

// Tracked points with the depths that the memory knows.
std::vector<SeenPoint> WithDepths(const std::vector<TrackedPoint>& points,
                                  const cv::Mat1f& disparity, const cv::Mat1f& variance,
                                  const RectifiedPair& pair) {
  std::vector<SeenPoint> seen;
  seen.reserve(points.size());
  for (const TrackedPoint& point : points) {
    const auto u = static_cast<int>(point.before.x + 0.5);
    const auto v = static_cast<int>(point.before.y + 0.5);
    const auto d = static_cast<double>(disparity(v, u));
    if (!(d + pair.cx_right - pair.cx > kMinPointRho) || !(variance(v, u) <= kMaxPointVariance)) {
      continue;
    }
    const double z = pair.DepthFromDisparity(d);
    seen.push_back({.before_m = Eigen::Vector3d((point.before.x - pair.cx) / pair.focal_px * z,
                                                (point.before.y - pair.cy) / pair.focal_px * z, z),
                    .after_px = {point.after.x, point.after.y}});
  }
  return seen;
}

// (T10): matching errs in the same way until the cameras see the scene from elsewhere.
float SharedBy(const Pose& motion, double baseline_m) {
  constexpr double kFrames = 5;  // that the memory averages, as its gain is at least a fifth
  const double way = kFrames * motion.translation_m.norm() / baseline_m;
  return static_cast<float>(1 - std::min(way, 1.0) / 2);
}

const TemporalConfig& InRange(const TemporalConfig& config) {
  RequireInRange(config, "temporal");
  if (config.gate_min_px() > config.gate_max_px()) {
    throw ConfigError("temporal.gate_min_px: above temporal.gate_max_px; allowed: at most that");
  }
  return config;
}

}  // namespace

TemporalFilter::TemporalFilter(const TemporalConfig& config)
    : config_(InRange(config)), doubt_(config.doubt_grey(), config.drop_grey()) {}

void TemporalFilter::Reset() {
  before_.known = false;
  now_.known = false;
}

// Whether the image and the map are to the bit those of the last call, which was no reset.
bool TemporalFilter::IsAsLast(const TemporalInput& input) const {
  const auto same = [](const cv::Mat& a, const cv::Mat& b) {
    if (a.size() != b.size()) return false;
    for (int y = 0; y < a.rows; ++y) {
      if (std::memcmp(a.ptr(y), b.ptr(y), static_cast<size_t>(a.cols) * a.elemSize()) != 0) {
        return false;
      }
    }
    return true;
  };
  const MemoryReset reset = now_.motion.reset;
  const bool has_gone_on = reset == MemoryReset::kNone || reset == MemoryReset::kFirst;
  return now_.known && has_gone_on && now_.id.rig_id == input.id.rig_id &&
         same(now_.left, input.left) && same(now_.measured, input.disparity.counts());
}

MemoryReset TemporalFilter::ReasonToForget(const TemporalInput& input) const {
  if (!before_.known) return MemoryReset::kFirst;
  if (before_.id.rig_id != input.id.rig_id || before_.left.size() != input.left.size()) {
    return MemoryReset::kOtherRig;
  }
  if (input.id.seq <= last_id_.seq || input.id.utime <= last_id_.utime) {
    return MemoryReset::kBackwards;
  }
  const double gap_s = static_cast<double>(input.id.utime - last_id_.utime) * 1e-6;
  return gap_s > config_.max_gap_s() ? MemoryReset::kGap : MemoryReset::kNone;
}

TemporalOutput TemporalFilter::Compute(const TemporalInput& input) {
  assert(input.left.size() == input.pair.size() && input.disparity.size() == input.pair.size() &&
         input.confidence.size() == input.pair.size());
  // The frame of the last call again is fused with what was known before it.
  const bool is_last = now_.known && now_.id == input.id;
  if (!is_last) {
    last_id_ = now_.id;
    if (!IsAsLast(input)) std::swap(before_, now_);
  }
  now_.known = false;  // until it is complete, since memory may run out
  now_.id = input.id;
  now_.left = input.left;
  now_.measured = input.disparity.counts();
  now_.odometry = input.odometry;
  FindMotionOf(input);
  Renew(now_.disparity, input.left.size());
  Renew(now_.variance, input.left.size());
  TemporalOutput output{.disparity = DisparityImage(cv::Mat1s(input.left.size())),
                        .confidence = cv::Mat1b(input.left.size()),
                        .motion = now_.motion};
  // The memory is interpolated between four pixels, which images of one row or column do not have.
  const bool has_neighbours = std::min(input.left.rows, input.left.cols) > 1;
  const bool is_known = now_.motion.reset == MemoryReset::kNone && has_neighbours;
  is_known ? Fuse(input, output) : Begin(input, output);
  now_.known = true;
  return output;
}

void TemporalFilter::FindMotionOf(const TemporalInput& input) {
  CameraMotion& motion = now_.motion;
  motion = CameraMotion();
  motion.reset = ReasonToForget(input);
  if (config_.motion() == TemporalConfig::CHANNEL) {
    if (motion.reset == MemoryReset::kNone) TakeMotionOf(input);
  } else {
    now_.pyramid = BuildPyramid(input.left);
    if (motion.reset == MemoryReset::kNone) EstimateMotionOf(input);
  }
  motion.last_from_left = now_.left_from_last.Inverse();
  motion.start_from_left = before_.motion.start_from_left * motion.last_from_left;
  if (motion.reset == MemoryReset::kNone && !IsMotionUsable(input.pair)) {
    motion.reset = MemoryReset::kNoAgreement;
  }
  if (motion.reset == MemoryReset::kNone) {
    motion.last_seq = before_.id.seq;
    motion.start_seq = before_.motion.start_seq;
    motion.resets = before_.motion.resets;
    return;
  }
  now_.left_from_last = motion.last_from_left = motion.start_from_left = Pose();
  motion.covariance = {};
  motion.last_seq = motion.start_seq = input.id.seq;
  motion.resets = motion.reset == MemoryReset::kFirst ? 0 : before_.motion.resets + 1;
}

bool TemporalFilter::IsMotionUsable(const RectifiedPair& pair) const {
  const CameraMotion& motion = now_.motion;
  return motion.start_from_left.translation_m.allFinite() &&
         motion.start_from_left.rotation.coeffs().allFinite() &&
         std::ranges::all_of(motion.covariance,
                             [](double value) { return std::isfinite(value); }) &&
         IsUsable(PixelMotionOf(now_.left_from_last, pair)) &&
         IsUsable(PixelMotionOf(motion.last_from_left, pair));
}

void TemporalFilter::EstimateMotionOf(const TemporalInput& input) {
  CameraMotion& motion = now_.motion;
  const std::vector<SeenPoint> points = WithDepths(TrackCorners(before_.pyramid, now_.pyramid),
                                                   before_.disparity, before_.variance, input.pair);
  const MotionRule rule{.inlier_px = config_.inlier_px() * now_.pyramid.scale,
                        .min_inliers = config_.min_inliers(),
                        .min_inlier_share = config_.min_inlier_percent() / 100};
  const MotionEstimate estimate = EstimateMotion(points, input.pair, before_.left_from_last, rule);
  motion.reset = estimate.reset;
  motion.tracked = static_cast<int32_t>(points.size());
  motion.inliers = estimate.inliers;
  now_.left_from_last = estimate.left_from_last;
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(motion.covariance.data()) =
      estimate.covariance;
}

void TemporalFilter::TakeMotionOf(const TemporalInput& input) {
  const auto& last = before_.odometry;
  const auto& now = input.odometry;
  if (!last || !now || last->start_seq != now->start_seq) {
    now_.motion.reset = MemoryReset::kFewPoints;
    return;
  }
  now_.left_from_last = now->start_from_left.Inverse() * last->start_from_left;
  if (now->last_seq == before_.id.seq) now_.motion.covariance = now->covariance;
}

void TemporalFilter::Begin(const TemporalInput& input, TemporalOutput& output) {
  const auto& variances = scale_.variances();
  input.disparity.counts().copyTo(output.disparity.counts());
  for (int v = 0; v < input.left.rows; ++v) {
    for (int u = 0; u < input.left.cols; ++u) {
      const bool known = input.disparity.IsValid(u, v);
      const uint8_t confidence = known ? input.confidence(v, u) : uint8_t{0};
      output.confidence(v, u) = confidence;
      now_.disparity(v, u) = known ? input.disparity.Px(u, v) : kNone;
      now_.variance(v, u) = variances[confidence];
    }
  }
}

void TemporalFilter::Fuse(const TemporalInput& input, TemporalOutput& output) {
  const auto drift_px = static_cast<float>(config_.drift_px());
  const Memory memory{.disparity = ViewOf(before_.disparity),
                      .variance = ViewOf(before_.variance),
                      .grey = ViewOf(before_.left),
                      .now_from_last = PixelMotionOf(now_.left_from_last, input.pair),
                      .last_from_now = PixelMotionOf(now_.left_from_last.Inverse(), input.pair),
                      .offset_px = static_cast<float>(input.pair.cx_right - input.pair.cx),
                      .drift_px2 = drift_px * drift_px};
  // The cells have a border of one.
  const cv::Size cells((input.left.cols + 1) / 2, (input.left.rows + 1) / 2);
  Renew(cells_, {cells.width + 2, cells.height + 2});
  Renew(differences_, cells);
  cells_ = kNone;
  SplatCells(memory, cells_[0]);
  const View<uint8_t> grey = ViewOf(input.left);
  ForRangesParallel(cells.height, cells.height / kRowsPerPart + 1, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      LookUpCells(memory, grey, v, cells_[v + 1] + 1, differences_[v]);
    }
  });
  doubt_.Compute(input.left, differences_, growth_);
  const FusionRule rule{.gate_sigmas = static_cast<float>(config_.gate_sigmas()),
                        .gate_min_px = static_cast<float>(config_.gate_min_px()),
                        .gate_max_px = static_cast<float>(config_.gate_max_px()),
                        .min_gain = static_cast<float>(config_.min_gain()),
                        .shared = SharedBy(now_.left_from_last, input.pair.baseline_m)};
  const int height = input.left.rows;
  ForRangesParallel(height, height / kRowsPerPart + 1, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      FuseRow(memory, rule,
              {.v = v,
               .cells = cells_[v / 2 + 1] + 1,
               .growth = growth_[v / 2],
               .counts = input.disparity.counts()[v],
               .confidence = input.confidence[v],
               .scale = &scale_,
               .fused = now_.disparity[v],
               .fused_variance = now_.variance[v],
               .fused_counts = output.disparity.counts()[v],
               .fused_confidence = output.confidence[v]});
    }
  });
}

}  // namespace sprout::temporal
