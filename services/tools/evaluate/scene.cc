#include "services/tools/evaluate/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/number_text.h"
#include "common/measure/score.h"
#include "common/scenes/kitti_source.h"

namespace sprout::evaluate {
namespace {

constexpr std::string_view kAuto = "grid:auto";
constexpr std::string_view kGrid = "grid:";
constexpr std::string_view kSr4000 = "sr4000";
constexpr double kRowsPerSpacingPx = 111;  // 1110 rows: the paper's 10 px
constexpr double kMaxFactor = 100;
constexpr int kMaxSpacingPx = 1000;

ConfigError BadChoice(const std::string& text, const std::string& reason) {
  return ConfigError("--tof " + text + ": " + reason +
                     "; allowed: grid:auto, grid:auto*K (K above 0, at most 100), grid:N (N from "
                     "1 to 1000 px), sr4000 (with ?blind=P, &wrapped=P, &calibration=PX, "
                     "&every=K), all of them with " +
                     std::string(scenes::kRangeErrorOptions) +
                     "; zones:CxR (with ?mode=mean or nearest, &targets=N), none, and for kitti "
                     "scan, none");
}

namespace fs = std::filesystem;

constexpr std::string_view kKitti = "kitti:";
constexpr std::string_view kMiddlebury = "middlebury:";

bool IsSynthetic(const std::string& scene) { return scene.starts_with("synthetic:"); }

std::string NameOf(const std::string& scene) {
  if (IsSynthetic(scene)) return scene;
  const size_t question = std::min(scene.rfind('?'), scene.size());
  const fs::path path = fs::absolute(scene.substr(0, question)).lexically_normal();
  std::string name = path.has_filename() ? path.filename() : path.parent_path().filename();
  name += scene.substr(question);
  // 000007?beams=16 is no name for a file.
  std::ranges::replace_if(
      name, [](char c) { return c == '?' || c == '&'; }, '_');
  return name;
}

// A grid that follows from the rows of the images needs an open source first, to know them.
std::unique_ptr<scenes::Dataset> Open(const std::string& scene, const TofChoice& tof,
                                      CaptureConfig& config) {
  if (IsKitti(scene) != (tof.text() == TofChoice::kScan) && tof.text() != TofChoice::kNone) {
    throw ConfigError("--tof " + tof.text() + ": " + scene + " has " +
                      (IsKitti(scene) ? "a scan of its own; allowed: scan, none"
                                      : "no scan; allowed: a simulated ToF camera, none"));
  }
  config.set_source(IsSynthetic(scene) || IsKitti(scene) ? scene
                                                         : std::string(kMiddlebury) + scene);
  config.set_tof("grid");
  config.set_tof_grid_px(1);  // fits every image
  tof.Apply(scenes::OpenDataset(config)->rig().pair.height, config);
  return scenes::OpenDataset(config);
}

int LargestDisparity(const cv::Mat1f& truth) {
  float largest = 0;
  for (const float disparity : truth) {
    if (disparity <= kMaxSide) largest = std::max(largest, disparity);
  }
  return static_cast<int>(std::ceil(largest));
}

cv::Mat1b AwayMask(const TofProjector& projector, const TofImage& tof) {
  const cv::Size size = projector.rig().pair.size();
  cv::Mat1b away(size, uchar{255});
  int behind = 0;
  for (const ProjectedPoint& point : projector.Project(tof, behind)) {
    const cv::Point pixel(cvRound(point.seed.u), cvRound(point.seed.v));
    if (cv::Rect({0, 0}, size).contains(pixel)) away(pixel) = 0;
  }
  cv::erode(away, away, cv::Mat1b(5, 5, uchar{1}));  // none of 5×5 is kAwayPx from the middle
  return away;
}

cv::Mat1b Required(Result<cv::Mat1b> mask) {
  if (!mask) throw ConfigError(mask.error().text);
  return *std::move(mask);
}

}  // namespace

TofChoice::TofChoice(const std::string& text) : text_(text) {
  const std::string_view view = text_;
  const size_t question = std::min(view.find('?'), view.size());
  const std::string_view sensor = view.substr(0, question);
  chosen_.set_tof("grid");
  if (view == kScan) return;
  if (sensor == kNone || sensor == kSr4000) {
    chosen_.set_tof(std::string(sensor));
  } else if (!scenes::ApplyZones(sensor, chosen_)) {
    ReadSpacing(sensor);
  }
  if (question == view.size()) return;
  for (const scenes::SourceOption& option : scenes::SourceOptions(view.substr(question + 1))) {
    if (!scenes::ApplyTofOption(option, /*is_scan=*/false, chosen_)) {
      throw BadChoice(text_, "no such option");
    }
  }
}

void TofChoice::ReadSpacing(std::string_view grid) {
  if (grid == kAuto) return;
  if (grid.starts_with("grid:auto*")) {
    const std::optional<double> factor = ParseNumber<double>(grid.substr(kAuto.size() + 1));
    if (!factor || !(*factor > 0 && *factor <= kMaxFactor)) {
      throw BadChoice(text_, "no such factor");
    }
    factor_ = *factor;
  } else if (grid.starts_with(kGrid)) {
    spacing_px_ = ParseNumber<int>(grid.substr(kGrid.size()));
    if (!spacing_px_ || *spacing_px_ < 1 || *spacing_px_ > kMaxSpacingPx) {
      throw BadChoice(text_, "no such spacing");
    }
  } else {
    throw BadChoice(text_, "no such ToF camera");
  }
}

void TofChoice::Apply(int rows, CaptureConfig& config) const {
  config.MergeFrom(chosen_);
  if (config.tof() != "grid") return;
  const double automatic_px = std::max(1.0, std::round(rows / kRowsPerSpacingPx));
  config.set_tof_grid_px(spacing_px_.value_or(
      std::clamp(static_cast<int>(std::lround(automatic_px * factor_)), 1, kMaxSpacingPx)));
}

bool IsKitti(const std::string& scene) { return scene.starts_with(kKitti); }

std::vector<std::string> ScenesOf(const std::string& scene) {
  if (scene.starts_with(kMiddlebury)) return {scene.substr(kMiddlebury.size())};
  if (!IsKitti(scene)) return {scene};
  const size_t question = std::min(scene.rfind('?'), scene.size());
  std::vector<std::string> scenes;
  for (const std::string& place :
       scenes::KittiPlaces(scene.substr(kKitti.size(), question - kKitti.size()))) {
    scenes.push_back(std::string(kKitti) + place + scene.substr(question));
  }
  return scenes;
}

RefineConfig Scene::WithRange(RefineConfig config) const {
  if (config.unambiguous_range_m() == 0) {
    config.set_unambiguous_range_m(frame.unambiguous_range_m);
  }
  return config;
}

Scene LoadScene(const std::string& scene, const TofChoice& tof, CaptureConfig config) {
  const std::unique_ptr<scenes::Dataset> source = Open(scene, tof, config);
  scenes::DatasetFrame frame = source->Get(0);
  const scenes::GroundTruth truth = frame.truth;
  if (truth.left.empty()) {
    throw ConfigError("scene " + scene + ": no ground truth; allowed: a scene with ground truth");
  }
  const Visibility visibility = VisibilityOf(truth);
  const cv::Mat scored = visibility.nonoccluded & (truth.left <= kMaxSide);  // NaN is not
  if (cv::countNonZero(scored) == 0) {
    throw ConfigError("scene " + scene +
                      ": its ground truth has no pixel that both cameras see; "
                      "allowed: at least one");
  }
  TofProjector projector(source->rig());
  const cv::Mat1b away = AwayMask(projector, frame.tof);
  return {.name = NameOf(scene),
          .frame = frame,
          .left_grey = ToGrey(frame.left),
          .right_grey = ToGrey(frame.right),
          .projector = std::move(projector),
          .nonoccluded = visibility.nonoccluded,
          .occluded = visibility.occluded,
          .away = away,
          .truth_is_scan = IsKitti(scene),
          .max_disparity_px = LargestDisparity(truth.left)};
}

Visibility VisibilityOf(const scenes::GroundTruth& truth) {
  if (truth.nonoccluded.empty()) {
    return {Required(NonOccludedMask(truth.left, truth.right)),
            Required(OccludedMask(truth.left, truth.right))};
  }
  // Known, but not seen by the right camera, although within its image.
  cv::Mat1b occluded(truth.left.size(), uchar{0});
  for (int v = 0; v < occluded.rows; ++v) {
    for (int u = 0; u < occluded.cols; ++u) {
      const bool in_right_image = std::round(u - double{truth.left(v, u)}) >= 0;  // NaN is not
      if (in_right_image && truth.nonoccluded(v, u) == 0) occluded(v, u) = 255;
    }
  }
  return {truth.nonoccluded, occluded};
}

}  // namespace sprout::evaluate
