#include "services/view/save_frame.h"

#include <span>

#include "common/core/prior_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"

namespace sprout::view {
namespace {

Result<void> SaveImage(const cv::Mat& image, const std::filesystem::path& path) {
  if (image.empty()) return Fail("the frame has no such image");
  return WritePng(path, image);
}

// Saves a map as a picture for people, with a title and a scale.
Result<void> SavePicture(const DisparityImage* map, const std::string& title,
                         const std::filesystem::path& path) {
  if (map == nullptr || map->empty()) return Fail("the frame has no such map");
  return WritePng(path, DisparityPicture(*map, DisparityRange(std::span(map, 1), {}), title));
}

Result<void> SavePfm(const DisparityImage* map, const std::filesystem::path& path) {
  if (map == nullptr || map->empty()) return Fail("the frame has no such map");
  return WritePfm(path, *map);
}

}  // namespace

Result<void> SaveFrame(const Frame& frame, const std::string& what,
                       const std::filesystem::path& path) {
  const DisparityImage* map = frame.disparity ? &*frame.disparity : nullptr;
  const DisparityImage* prior = frame.prior ? &frame.prior->disparity : nullptr;
  if (what == "left.png") return SaveImage(frame.left, path);
  if (what == "right.png") return SaveImage(frame.right, path);
  if (what == "confidence.png") return SaveImage(frame.confidence, path);
  if (what == "disparity.png") return SavePicture(map, "Disparity", path);
  if (what == "prior.png") return SavePicture(prior, "Prior disparity", path);
  if (what == "disparity.pfm") return SavePfm(map, path);
  if (what == "prior.pfm") return SavePfm(prior, path);
  if (what == "sigma.pfm") {
    if (frame.sigma.type() != CV_8UC1 || frame.sigma.empty()) {
      return Fail("the frame has no standard deviations");
    }
    return WritePfm(path, SigmaToPx(cv::Mat1b(frame.sigma)));
  }
  if (what != "cloud.ply") {
    return Fail(
        "what: allowed are left.png, right.png, confidence.png, disparity.png, prior.png, "
        "disparity.pfm, prior.pfm, sigma.pfm, cloud.ply");
  }
  if (map == nullptr || !frame.rig || frame.left.empty()) {
    return Fail("a cloud needs disparity map, left image and calibration");
  }
  return WriteCloudPly(path, frame.rig->pair, *map, frame.left);
}

}  // namespace sprout::view
