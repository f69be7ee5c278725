#include "services/pipeline/pipeline.h"

#include <fmt/format.h>

#include <utility>

#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/geometry/projection.h"
#include "services/depth/map_filter.h"
#include "services/pipeline/chain.h"

namespace sprout {
namespace {

Result<void> CheckImage(const char* name, const cv::Mat& image, cv::Size calibrated) {
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3) {
    return Fail(std::string(name) + ": of OpenCV's type " + cv::typeToString(image.type()) +
                "; allowed: CV_8UC1, CV_8UC3");
  }
  if (image.size() != calibrated) {
    return Fail(std::string(name) + ": " + SizeText(image.size()) +
                "; allowed: the calibrated size " + SizeText(calibrated));
  }
  return {};
}

Result<void> CheckTof(const TofImage& tof, const Rig& rig) {
  if (tof.depth_m.empty()) return {};
  if (!tof.amplitude.empty() && tof.amplitude.size() != tof.depth_m.size()) {
    return Fail("tof.amplitude: " + SizeText(tof.amplitude.size()) + "; allowed: empty, or " +
                SizeText(tof.depth_m.size()) + " as tof.depth_m");
  }
  return CheckTofSize(rig, tof);
}

// Checks that the numbers leave room for those of the next frame.
Result<void> CheckTime(const std::optional<FrameTime>& time, bool uses_poses) {
  constexpr int64_t kMax = int64_t{1} << 62;
  if (!time) return {};
  for (const auto& [name, value] : {std::pair("utime", time->utime), {"seq", time->seq}}) {
    if (value < 0 || value > kMax) {
      return Fail(std::string("time.") + name + ": " + std::to_string(value) +
                  "; allowed: 0 to 2^62");
    }
  }
  if (time->pose && !uses_poses) {
    return Fail(
        "time.pose: given, but the configuration does not use it; allowed: none, or temporal { "
        "in_pipeline: true motion: CHANNEL }");
  }
  return {};
}

Result<void> CheckZonesWanted(const TofZones& zones, bool uses_zones) {
  if (!uses_zones && !zones.views.empty()) {
    return Fail("zones: " + std::to_string(zones.columns) + "x" + std::to_string(zones.rows) +
                ", but refine.zones is false; allowed: 0x0, or refine.zones: true");
  }
  return CheckZones(zones).map_error(
      [](const Error& error) { return Error{"zones: " + error.text}; });
}

Result<void> CheckInput(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                        const Rig& rig, const std::optional<FrameTime>& time, bool uses_poses) {
  return CheckRig(rig)
      .and_then([&] { return CheckImage("left", left, rig.pair.size()); })
      .and_then([&] { return CheckImage("right", right, rig.pair.size()); })
      .and_then([&] { return CheckTof(tof, rig); })
      .and_then([&] { return CheckTime(time, uses_poses); });
}

bool WantsDepthOfFused(const SproutConfig& config) {
  const bool fused = config.depth().input() == DepthConfig::FUSED;
  if (fused && !config.temporal().in_pipeline()) {
    throw ConfigError(
        "depth.input: FUSED, but temporal.in_pipeline is false; allowed: SINGLE, or "
        "temporal.in_pipeline: true");
  }
  return fused;
}

depth::FilterRules RulesOf(const SproutConfig& config) {
  if (depth::HasBox(config.depth())) {
    throw ConfigError(
        "depth.box: the robot's frame is not known here; allowed: none, or sprout-depth");
  }
  if (config.depth().min_confidence() > 0 && !config.grow().publish_confidence()) {
    throw ConfigError(
        "depth.min_confidence = " + std::to_string(config.depth().min_confidence()) +
        ": needs grow.publish_confidence: true (preset default); allowed without it: 0");
  }
  return depth::FilterOf(config.depth(), /*base_from_left=*/{});
}

// How far the range sensor is off, in its ranges and in its pose.
std::string RangeErrorOf(const ChainReport& report) {
  const std::string text = report.range_error.value_or("");
  const TofOffsetStatus& offset = report.tof_offset;
  if (!offset.is_off) return text;
  return JoinedTexts(
      text,
      fmt::format("range points are off by ({:.1f}, {:.1f}) px in the left image: calibrate again",
                  -offset.u_px, -offset.v_px));
}

}  // namespace

Pipeline::Pipeline(const SproutConfig& config)
    : chain_(std::make_unique<Chain>(config)),
      filter_(std::make_unique<depth::MapFilter>(RulesOf(config))),
      depth_of_fused_(WantsDepthOfFused(config)),
      uses_zones_(config.refine().zones()),
      uses_poses_(config.temporal().in_pipeline() &&
                  config.temporal().motion() == TemporalConfig::CHANNEL) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

Result<DepthFrame> Pipeline::Compute(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                                     const Rig& rig, const std::optional<FrameTime>& time,
                                     const TofZones& zones) {
  const Result<void> fits = CheckInput(left, right, tof, rig, time, uses_poses_).and_then([&] {
    return CheckZonesWanted(zones, uses_zones_);
  });
  if (!fits) return tl::unexpected(fits.error());
  last_ = time.value_or(FrameTime{.utime = last_.utime + 1, .seq = last_.seq + 1});
  Frame frame;
  frame.id = {.utime = last_.utime, .seq = last_.seq, .rig_id = RigId(rig)};
  if (last_.pose) frame.odometry.emplace().start_from_left = *last_.pose;
  frame.left = left;
  frame.right = right;
  frame.tof = tof;
  frame.rig = rig;
  if (uses_zones_) frame.tof_zones = zones;
  ChainObserver no_observer;
  DepthFrame result;
  ChainReport report = chain_->Run(frame, no_observer);
  result.warnings = std::move(report.warnings);
  result.range_error = RangeErrorOf(report);
  result.ranges_refused = report.ranges_refused;
  result.disparity = std::move(*frame.disparity);
  if (frame.fused) {
    result.fused = std::move(*frame.fused);
    result.fused_confidence = frame.fused_confidence;
    result.motion = frame.motion;
  }
  result.confidence = frame.confidence;
  result.sigma = frame.sigma;
  result.kept = depth_of_fused_ ? result.fused : result.disparity;
  if (!filter_->IsOff()) {
    DepthCounts counts;
    const cv::Mat& confidence = depth_of_fused_ ? result.fused_confidence : result.confidence;
    result.kept = filter_->Apply(result.kept, rig.pair, confidence, counts);
  }
  result.depth_m = DepthMap(rig.pair, result.kept);
  result.prior = frame.prior.value_or(PriorMap());
  result.seeds = std::move(*frame.seeds);
  result.left_seeds = std::move(*frame.left_seeds);
  return result;
}

void Pipeline::Reset() { chain_->Reset(); }

}  // namespace sprout
