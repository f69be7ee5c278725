#include "services/tools/evaluate/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <utility>

#include "common/core/image.h"
#include "common/scenes/kitti_source.h"
#include "services/tools/evaluate/visibility.h"

namespace sprout::evaluate {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kKitti = "kitti:";

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
  config.set_source(IsSynthetic(scene) || IsKitti(scene) ? scene : "middlebury:" + scene);
  config.set_tof("grid");
  config.set_tof_grid_px(1);  // fits every image
  tof.Apply(scenes::OpenDataset(config)->rig().pair.height, config);
  return scenes::OpenDataset(config);
}

int LargestDisparity(const cv::Mat1f& truth) {
  float largest = 0;
  for (const float disparity : truth) {
    if (std::isfinite(disparity)) largest = std::max(largest, disparity);
  }
  return static_cast<int>(std::ceil(largest));
}

cv::Mat1b AwayMask(const TofProjector& projector, const TofImage& tof) {
  const cv::Size size = projector.rig().pair.size();
  cv::Mat1b free_of_points(size, uchar{255});
  int behind = 0;
  for (const ProjectedPoint& point : projector.Project(tof, behind)) {
    const cv::Point pixel(cvRound(point.seed.u), cvRound(point.seed.v));
    if (cv::Rect({0, 0}, size).contains(pixel)) free_of_points(pixel) = 0;
  }
  if (cv::countNonZero(free_of_points) == size.area()) return free_of_points;
  cv::Mat1f distance_px;
  cv::distanceTransform(free_of_points, distance_px, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const cv::Mat away = distance_px >= kAwayPx;
  return away;
}

}  // namespace

bool IsKitti(const std::string& scene) { return scene.starts_with(kKitti); }

std::vector<std::string> ScenesOf(const std::string& scene) {
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
  TofProjector projector(source->rig());
  const cv::Mat1b away = AwayMask(projector, frame.tof);
  const Visibility visibility = VisibilityOf(truth);
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

}  // namespace sprout::evaluate
