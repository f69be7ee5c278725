#include "services/depth/depth_adapter.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/rig/rig_file.h"
#include "services/depth/cloud.h"
#include "services/depth/depth_map.h"
#include "services/depth/preview.h"

namespace sprout::depth {
namespace {

void RequireSomething(const DepthConfig& config) {
  if (config.publish_depth() || config.publish_cloud() || config.publish_preview() ||
      config.publish_sigma() || config.publish_scan() || !config.target().empty()) {
    return;
  }
  throw ConfigError(
      "depth.publish_depth, depth.publish_cloud, depth.publish_preview, depth.publish_sigma, "
      "depth.publish_scan = false, depth.target empty: nothing to publish; allowed: at least one "
      "of them");
}

void RequireSigma(const DepthConfig& config) {
  if (!config.publish_sigma() || config.input() != DepthConfig::FUSED) return;
  throw ConfigError(
      "depth.publish_sigma = true: fused maps have no standard deviation; allowed: false with "
      "input: FUSED");
}

std::string NamesOf(const RigPlaces& places) {
  if (places.others.empty()) return "none, the rig file has no others";
  return Joined(", ", places.others, [](const auto& other) { return other.first; });
}

View TargetOf(const std::string& target, const RigPlaces& places) {
  const auto found = places.others.find(target);
  if (found == places.others.end()) {
    throw ConfigError("depth.target = '" + target + "': allowed: " + NamesOf(places));
  }
  return ViewOf(found->second.lens, found->second.left_from_camera);
}

DepthOptions OptionsOf(const DepthConfig& config) {
  RequireInRange(config, "depth");
  if (config.scale() == 3) throw ConfigError("depth.scale = 3: allowed: 1, 2, 4");
  RequireSomething(config);
  RequireSigma(config);
  RigPlaces places;
  if (!config.rig().empty()) places = PlacesOf(LoadRigFile(config.rig()), config.rig());
  if (config.rig().empty() && !config.target().empty()) {
    throw ConfigError("depth.target = '" + config.target() +
                      "': needs depth.rig, a rig file with others");
  }
  DepthOptions options{.filter = FilterOf(config, places.base_from_left),
                       .base_from_left = places.base_from_left,
                       .target = std::nullopt,
                       .scan = std::nullopt,
                       .pair = places.pair};
  if (!config.target().empty()) options.target = TargetOf(config.target(), places);
  if (config.publish_scan()) {
    RequireOrder("scan_min_height_m", config.scan_min_height_m(), "scan_max_height_m",
                 config.scan_max_height_m());
    options.scan = ScanBand{.min_height_m = config.scan_min_height_m(),
                            .max_height_m = config.scan_max_height_m(),
                            .step_deg = config.scan_step_deg()};
  }
  return options;
}

// Names a calibration that is not the rig file's, so that results that need both would be wrong;
// empty if it is.
std::string RigProblem(const DepthOptions& options, const RectifiedPair& pair) {
  // Larger than the difference between rectifications of one file by two compilers.
  constexpr double kTolerance = 1e-6;
  if (!options.pair) return "";
  const auto numbers = [](const RectifiedPair& p) {
    return std::array{double(p.width), double(p.height), p.focal_px, p.cx, p.cy,
                      p.cx_right,      p.baseline_m};
  };
  const auto expected = numbers(*options.pair);
  const auto found = numbers(pair);
  const bool same =
      std::equal(expected.begin(), expected.end(), found.begin(), [](double a, double b) {
        return std::abs(a - b) <= kTolerance * std::max(std::abs(a), std::abs(b));
      });
  return same
             ? ""
             : "RIG is not the calibration in depth.rig; allowed is the rig file that capture uses";
}

// The map that the configuration chooses, with its confidence.
struct Input {
  Part part, confidence_part;
  const char* name;
  std::optional<DisparityImage> Frame::*map;
  cv::Mat Frame::*confidence;
};
constexpr Input kSingle{Part::kDisparity, Part::kConfidence, "DISPARITY", &Frame::disparity,
                        &Frame::confidence};
constexpr Input kFused{Part::kFused, Part::kFusedConfidence, "FUSED", &Frame::fused,
                       &Frame::fused_confidence};

const Input& InputOf(const DepthConfig& config) {
  return config.input() == DepthConfig::FUSED ? kFused : kSingle;
}

std::string SizeProblem(const Frame& frame, const Input& input) {
  const cv::Size size = (frame.*input.map)->size();
  const cv::Mat& confidence = frame.*input.confidence;
  const std::string name = input.name;
  if (const auto fits = CheckImageSize(name, size, frame.rig->pair.size()); !fits) {
    return fits.error().text;
  }
  if (frame.left.size() != size) {
    return "LEFT of " + SizeText(frame.left.size()) + ": allowed is " + name + "'s " +
           SizeText(size);
  }
  for (const auto& [part, image] :
       {std::pair("SIGMA", &frame.sigma), {"CONFIDENCE", &confidence}}) {
    if (image->empty() || (image->size() == size && image->type() == CV_8UC1)) continue;
    return std::string(part) + " of " + SizeText(image->size()) + " and " +
           std::to_string(image->channels()) + " bytes a pixel: allowed is " + name + "'s " +
           SizeText(size) + ", in grey";
  }
  return "";
}

// Reports a map of which no pixel has min_confidence. The likely cause is not the scene, but a grow
// whose confidence is 0 to 1, or always 0.
std::string UnlikelyConfidenceText(const DepthCounts& counts, const cv::Mat& confidence,
                                   int min_confidence) {
  if (counts.unsure == 0 || counts.unsure < counts.pixels) return "";
  double largest = 0;
  cv::minMaxLoc(confidence, nullptr, &largest);
  return fmt::format(
      "nothing is left: no pixel has a confidence of depth.min_confidence, {}; the largest is {} "
      "of 255",
      min_confidence, largest);
}

void AddCloud(Part part, PointCloud cloud, StageResult& result) {
  if (cloud.points.size() == kMaxCloudPoints && result.degenerate.empty()) {
    result.degenerate = "the cloud ends at " + std::to_string(kMaxCloudPoints) +
                        " points; allowed is a cloud_stride or cloud_voxel_m that leaves fewer";
  }
  result.outputs.push_back({part, std::move(cloud)});
}

}  // namespace

DepthAdapter::DepthAdapter(const DepthConfig& config)
    : config_(config), options_(OptionsOf(config)), filter_(options_.filter) {}

PartSet DepthAdapter::Inputs() const {
  const Input& input = InputOf(config_);
  PartSet inputs{input.part, Part::kRig, Part::kLeft};
  const bool has_points = config_.publish_cloud() || config_.min_confidence() > 0;
  if (has_points && config_.confidence()) inputs.Add(input.confidence_part);
  if (config_.publish_sigma()) inputs.Add(Part::kSigma);
  return inputs;
}

StageResult DepthAdapter::Process(const Frame& frame) {
  StageResult result;
  if (frame.id.seq % config_.every() != 0) return result;
  const Input& input = InputOf(config_);
  result.degenerate = SizeProblem(frame, input);
  if (!result.degenerate.empty()) return result;
  const RectifiedPair& pair = frame.rig->pair;
  result.degenerate = RigProblem(options_, pair);
  const bool is_placed = result.degenerate.empty();
  if (is_placed && filter_.RegionIsOutside(pair.size())) {
    result.degenerate = "nothing is left: depth.region lies outside the image of " +
                        SizeText(pair.size()) + "; allowed is one of which some pixel is inside";
  }
  if (!is_placed && options_.filter.box) return result;
  Seen seen{*(frame.*input.map), pair, frame.left, frame.*input.confidence, frame.sigma};
  if (!filter_.IsOff()) {
    DepthCounts counts;
    seen.disparity = filter_.Apply(seen.disparity, pair, seen.confidence, counts);
    if (result.degenerate.empty()) {
      result.degenerate =
          UnlikelyConfidenceText(counts, seen.confidence, options_.filter.min_confidence);
    }
    result.outputs.push_back({Part::kDepthCounts, counts});
  }
  AddDepths(seen, result);
  if (config_.publish_cloud()) AddClouds(seen, is_placed, result);
  if (is_placed) AddOfOtherPlaces(seen, result);
  if (config_.publish_preview()) result.preview = PreviewOf(frame.left, seen.disparity, pair);
  return result;
}

void DepthAdapter::AddDepths(const Seen& seen, StageResult& result) const {
  if (!config_.publish_depth() && !config_.publish_sigma()) return;
  const RectifiedPair& pair = seen.pair;
  const int scale = std::min({config_.scale(), pair.width, pair.height});
  DepthImage depth = DepthOf(seen.disparity, pair, config_.mm_per_count() / 1000, scale);
  if (config_.publish_sigma()) {
    result.outputs.push_back(
        {Part::kDepthSigma, DepthSigmaOf(depth, seen.disparity, seen.sigma, pair, scale)});
  }
  if (!config_.publish_depth()) return;
  result.outputs.push_back({Part::kDepth, std::move(depth)});
  const double farthest_m = FarthestDepthM(config_.mm_per_count() / 1000);
  const int too_far = CountTooFar(seen.disparity, pair, farthest_m);
  result.finding = "";
  if (too_far == 0) return;
  result.finding = fmt::format(
      "SPROUT_DEPTH leaves out {} of {} pixels, which are farther than {:.1f} m; a larger depth {{ "
      "mm_per_count }} has them",
      too_far, seen.disparity.CountValid(), farthest_m);
}

void DepthAdapter::AddClouds(const Seen& seen, bool is_placed, StageResult& result) const {
  PointCloud cloud = CloudOf(seen.disparity, seen.pair, seen.left, seen.confidence, Thinning());
  std::optional<PointCloud> in_base;
  if (is_placed && options_.base_from_left) in_base = Moved(cloud, *options_.base_from_left);
  AddCloud(Part::kCloud, std::move(cloud), result);
  if (in_base) AddCloud(Part::kBaseCloud, *std::move(in_base), result);
}

void DepthAdapter::AddOfOtherPlaces(const Seen& seen, StageResult& result) const {
  const RectifiedPair& pair = seen.pair;
  if (options_.target) {
    const View& view = *options_.target;
    DepthImage depth = DepthInView(seen.disparity, pair, view, config_.mm_per_count() / 1000);
    if (config_.publish_cloud()) {
      AddCloud(Part::kTargetCloud,
               CloudInView(depth, view, pair, seen.left, seen.confidence, Thinning()), result);
    }
    result.outputs.push_back({Part::kTargetDepth, std::move(depth)});
  }
  if (!options_.scan) return;
  Result<PlanarScan> scan = ScanOf(
      seen.disparity, pair, options_.base_from_left.value_or(LevelFromLeft()), *options_.scan);
  if (scan) {
    result.scan = std::move(*scan);
  } else {
    result.degenerate = scan.error().text;
  }
}

}  // namespace sprout::depth
