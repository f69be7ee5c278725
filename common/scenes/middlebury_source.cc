#include <algorithm>
#include <cassert>
#include <cmath>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <utility>

#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/core/read_text.h"
#include "common/scenes/middlebury_calibration.h"
#include "common/scenes/pfm.h"
#include "common/scenes/range_errors.h"
#include "common/scenes/source_options.h"
#include "common/scenes/sr4000.h"
#include "common/scenes/surface_renderer.h"
#include "common/scenes/tof_grid.h"
#include "common/scenes/zone_sensor.h"

namespace sprout::scenes {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImageExtensions[] = {".png", ".jpg", ".ppm", ".pgm"};
// Published values go from 200 to 290 px: what to take where dmin.txt is missing and an error of
// the range sensor is given in metres. Otherwise depths without dmin.txt are not metric.
constexpr double kLikelyDminPx = 250;
constexpr uint8_t kSeenByBoth = 255;  // in mask0nocc.png; 128: by the left camera alone, 0: unknown
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

std::optional<fs::path> FindImage(const fs::path& folder, const std::string& name) {
  for (const char* extension : kImageExtensions) {
    if (fs::path path = folder / (name + extension); IsFile(path)) return path;
  }
  return {};
}

// "view1.png, view1.jpg, view1.ppm, view1.pgm"
std::string Candidates(const std::string& name) {
  return Joined(", ", kImageExtensions, [&](const char* extension) { return name + extension; });
}

fs::path RequireImage(const fs::path& folder, const std::string& name) {
  if (std::optional<fs::path> path = FindImage(folder, name)) return *path;
  throw ConfigError("scene " + folder.string() + ": " + name +
                    " is missing; allowed: " + Candidates(name));
}

// 8-bit codes to px.
cv::Mat1f ReadCodes(const fs::path& path, int scale) {
  const cv::Mat image = ReadImage(path, cv::IMREAD_UNCHANGED);
  if (image.type() != CV_8UC1) {
    throw ConfigError("ground truth " + path.string() +
                      ": not grey with 8 bits; allowed: 8-bit grey disparity codes");
  }
  cv::Mat1f disparity(image.size());
  std::transform(image.begin<uchar>(), image.end<uchar>(), disparity.begin(), [scale](uchar code) {
    return code == 0 ? kUnknown : static_cast<float>(code) / static_cast<float>(scale);
  });
  return disparity;
}

cv::Mat1f ReadPfmDisparity(const fs::path& path) {
  cv::Mat1f disparity = ReadPfm(path);
  for (float& d : disparity) {
    if (!std::isfinite(d)) d = kUnknown;
  }
  return disparity;
}

void RequireLeftTruth(const fs::path& path, const cv::Mat1f& disparity, cv::Size expected) {
  RequireSize(path, disparity.size(), expected);
  if (std::any_of(disparity.begin(), disparity.end(), [](float d) { return !std::isnan(d); })) {
    return;
  }
  throw ConfigError("ground truth " + path.string() +
                    ": no disparity is known; allowed: at least one, the ToF camera is simulated "
                    "from them");
}

struct Scene {
  RectifiedPair pair;
  cv::Mat left;
  cv::Mat right;
  GroundTruth truth;
};

Scene ReadImages(const fs::path& left, const fs::path& right) {
  Scene scene;
  scene.left = ReadImage(left, cv::IMREAD_ANYCOLOR);
  scene.right = ReadImage(right, cv::IMREAD_ANYCOLOR);
  RequireSize(right, scene.right.size(), scene.left.size());
  return scene;
}

// A scene whose truth has 8-bit codes: its files, and how its sizes were published.
struct CodedScene {
  const char *left, *right, *left_truth, *right_truth;
  int full_rows;   // of an image with one code a px
  int most_codes;  // a px, of the smallest one
};
constexpr CodedScene k2005 = {"view1", "view5", "disp1", "disp5", 1110, 255};
constexpr CodedScene k2003 = {"im2", "im6", "disp2", "disp6", 1500, 4};

// The scenes of 2001 have the names of 2003's, eight codes a px, and rows that these do not have.
constexpr int k2001Rows[] = {380, 381, 383};
constexpr int k2001Codes = 8;

int ScaleFromRows(const CodedScene& scene, int rows) {
  if (scene.left == k2003.left && std::ranges::find(k2001Rows, rows) != std::end(k2001Rows)) {
    return k2001Codes;
  }
  return std::clamp(static_cast<int>(std::lround(scene.full_rows / double(rows))), 1,
                    scene.most_codes);
}

Scene ReadCoded(const CodedScene& names, const fs::path& folder, const CaptureConfig& config) {
  Scene scene = ReadImages(RequireImage(folder, names.left), RequireImage(folder, names.right));
  const cv::Size size = scene.left.size();
  const int scale = config.gt_scale() > 0 ? config.gt_scale() : ScaleFromRows(names, size.height);
  const double missing_dmin_px = HasErrorsInMetres(config) ? kLikelyDminPx : 0;
  scene.pair = CalibrationFromDmin(folder / "dmin.txt", missing_dmin_px, size, scale);

  const fs::path left = RequireImage(folder, names.left_truth);
  scene.truth.left = ReadCodes(left, scale);
  RequireLeftTruth(left, scene.truth.left, size);
  if (const std::optional<fs::path> right = FindImage(folder, names.right_truth)) {
    scene.truth.right = ReadCodes(*right, scale);
    RequireSize(*right, scene.truth.right.size(), size);
  }
  return scene;
}

Scene Read2014(const fs::path& folder, const CaptureConfig& config) {
  if (config.gt_scale() > 0) {
    throw ConfigError("capture.gt_scale = " + std::to_string(config.gt_scale()) +
                      ": of no use for " + folder.string() +
                      ", whose ground truth is in px; allowed: 0");
  }
  Scene scene = ReadImages(RequireImage(folder, "im0"), RequireImage(folder, "im1"));
  const cv::Size size = scene.left.size();
  scene.pair = CalibrationFromCalib(folder / "calib.txt", size);

  // The evaluation, version 3, and ETH3D have disp0GT.pfm, and a mask of the pixels that both
  // cameras see.
  const bool is_evaluation = !IsFile(folder / "disp0.pfm");
  const fs::path left = folder / (is_evaluation ? "disp0GT.pfm" : "disp0.pfm");
  if (!IsFile(left)) {
    throw ConfigError("scene " + folder.string() +
                      ": disp0 is missing; allowed: disp0.pfm, disp0GT.pfm");
  }
  scene.truth.left = ReadPfmDisparity(left);
  RequireLeftTruth(left, scene.truth.left, size);
  if (const fs::path mask = folder / "mask0nocc.png"; is_evaluation && IsFile(mask)) {
    const cv::Mat seen = ReadImage(mask, cv::IMREAD_GRAYSCALE);
    RequireSize(mask, seen.size(), size);
    scene.truth.nonoccluded = seen == kSeenByBoth;
  }
  if (const fs::path right = folder / "disp1.pfm"; IsFile(right)) {
    scene.truth.right = ReadPfmDisparity(right);
    RequireSize(right, scene.truth.right.size(), size);
  }
  return scene;
}

Scene ReadScene(const fs::path& folder, const CaptureConfig& config) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    throw BadSource("middlebury:" + folder.string(), "no such folder" + WhyClosed(folder),
                    "the folder of a Middlebury scene");
  }
  if (FindImage(folder, k2005.left)) return ReadCoded(k2005, folder, config);
  if (FindImage(folder, k2003.left)) return ReadCoded(k2003, folder, config);
  if (FindImage(folder, "im0")) return Read2014(folder, config);
  throw ConfigError("scene " + folder.string() + ": no left image" +
                    WhyClosed(folder / k2005.left) + "; allowed: " + Candidates(k2005.left) +
                    " (2005, 2006), " + Candidates(k2003.left) + " (2003) or " + Candidates("im0") +
                    " (2014, 2021, ETH3D)");
}

class MiddleburyDataset : public Dataset {
 public:
  MiddleburyDataset(const std::string& folder, Scene scene, const CaptureConfig& config) {
    rig_.pair = scene.pair;
    if (config.tof() == "sr4000") {
      if (config.sr4000().motion() > 0) {
        throw ConfigError("capture.sr4000.motion: nothing moves in middlebury:" + folder +
                          "; allowed: 0, or synthetic:WxH");
      }
      sr4000_.emplace(scene.pair, config.sr4000(), config.seed());
      rig_.tof = sr4000_->calibrated();
      samples_.emplace(RenderSurface({scene.pair, sr4000_->actual()}, scene.truth,
                                     ToGrey(scene.left), ToGrey(scene.right)));
    } else if (config.tof() == kZones) {
      zone_sensor_.emplace(scene.pair, config.zones(), config.seed());
      samples_.emplace(RenderSurface({scene.pair, zone_sensor_->camera()}, scene.truth,
                                     ToGrey(scene.left), ToGrey(scene.right)));
    } else if (config.tof() == "grid") {
      rig_.tof = TofGridCamera(scene.pair, config.tof_grid_px());
      frame_.tof = SampleTofGrid(scene.pair, config.tof_grid_px(), scene.truth.left);
    }
    frame_.left = std::move(scene.left);
    frame_.right = std::move(scene.right);
    frame_.truth = std::move(scene.truth);
  }

  const Rig& rig() const override { return rig_; }
  std::optional<int64_t> frame_count() const override { return 1; }

  // An index above 0 is the same scene again, with new noise of the ToF camera.
  DatasetFrame Get(int64_t index) override {
    assert(index >= 0);
    DatasetFrame copy;
    copy.left = frame_.left.clone();
    copy.right = frame_.right.clone();
    copy.truth = {frame_.truth.left.clone(), frame_.truth.right.clone(),
                  frame_.truth.nonoccluded.clone()};
    if (sr4000_) {
      const Sr4000Frame measured = sr4000_->Measure(*samples_, index);
      copy.tof = measured.tof;
      copy.unambiguous_range_m = measured.unambiguous_range_m;
    } else if (zone_sensor_) {
      copy.tof_zones = zone_sensor_->Measure(*samples_, index);
    } else {
      copy.tof = {frame_.tof.depth_m.clone(), frame_.tof.amplitude.clone()};
    }
    return copy;
  }

 private:
  Rig rig_;
  DatasetFrame frame_;
  std::optional<Sr4000> sr4000_;
  std::optional<ZoneSensor> zone_sensor_;
  std::optional<TofSamples> samples_;  // what either of them sees
};

}  // namespace

std::unique_ptr<Dataset> OpenMiddlebury(const std::string& folder, const CaptureConfig& config) {
  return std::make_unique<MiddleburyDataset>(folder, ReadScene(folder, config), config);
}

}  // namespace sprout::scenes
