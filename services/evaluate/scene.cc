#include "services/evaluate/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "common/core/image.h"
#include "services/evaluate/score.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

bool IsSynthetic(const std::string& scene) { return scene.starts_with("synthetic:"); }

std::string NameOf(const std::string& scene) {
  if (IsSynthetic(scene)) return scene;
  const fs::path path = fs::absolute(scene).lexically_normal();
  return path.has_filename() ? path.filename() : path.parent_path().filename();
}

// A grid that follows from the rows of the images needs an open source first, to know them.
std::unique_ptr<FrameSource> Open(const std::string& scene, const TofChoice& tof,
                                  CaptureConfig& config) {
  config.set_source(IsSynthetic(scene) ? scene : "middlebury:" + scene);
  config.set_tof("grid");
  config.set_tof_grid_px(1);  // fits every image
  tof.Apply(OpenFrameSource(config)->rig().pair.height, config);
  return OpenFrameSource(config);
}

int LargestDisparity(const cv::Mat1f& truth) {
  float largest = 0;
  for (const float disparity : truth) {
    if (std::isfinite(disparity)) largest = std::max(largest, disparity);
  }
  return static_cast<int>(std::ceil(largest));
}

cv::Mat1b Required(Result<cv::Mat1b> mask) {
  if (!mask) throw ConfigError(mask.error().text);
  return *std::move(mask);
}

}  // namespace

Scene LoadScene(const std::string& scene, const TofChoice& tof, CaptureConfig config) {
  const std::unique_ptr<FrameSource> source = Open(scene, tof, config);
  CapturedFrame frame = source->Get(0);
  const GroundTruth truth = frame.truth;
  return {.name = NameOf(scene),
          .frame = frame,
          .left_grey = ToGrey(frame.left),
          .right_grey = ToGrey(frame.right),
          .projector = TofProjector(source->rig()),
          .nonoccluded = Required(NonOccludedMask(truth.left, truth.right)),
          .occluded = Required(OccludedMask(truth.left, truth.right)),
          .max_disparity_px = LargestDisparity(truth.left)};
}

}  // namespace sprout
