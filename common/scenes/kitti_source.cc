#include "common/scenes/kitti_source.h"

#include <algorithm>
#include <cassert>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "common/core/read_text.h"
#include "common/scenes/kitti_calibration.h"
#include "common/scenes/pfm.h"
#include "common/scenes/range_errors.h"
#include "common/scenes/source_options.h"
#include "common/scenes/tof_grid.h"
#include "common/scenes/velodyne_scan.h"

namespace sprout::scenes {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPng = ".png";
constexpr std::string_view kStereoPng = "_10.png";  // the stereo set: image 10 of a sequence of 21
constexpr char kRawCalibration[] = "calib_cam_to_cam.txt";
constexpr double kCodesPerPx = 256;

bool IsFolder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

enum class KittiLayout {
  kSet,       // stereo and object: calib/ID.txt
  kSequence,  // odometry: calib.txt
  kRaw,       // a drive: image_02/data; its day's calibration in the folder above
};

// A folder of frames.
struct KittiFolder {
  fs::path path;
  KittiLayout layout = KittiLayout::kSet;
  bool grey = false;  // only the grey cameras' images are there

  fs::path Images(bool right) const {
    const int camera = (grey ? 0 : 2) + (right ? 1 : 0);
    if (layout == KittiLayout::kRaw) {
      return path / ("image_0" + std::to_string(camera)) / "data";
    }
    return path / ("image_" + std::to_string(camera));
  }
};

// Nothing when there are no images in the folder.
std::optional<KittiFolder> FolderAt(const fs::path& path) {
  for (const bool grey : {false, true}) {
    KittiFolder raw{.path = path, .layout = KittiLayout::kRaw, .grey = grey};
    if (IsFolder(raw.Images(false))) return raw;
    const bool is_sequence = IsFile(path / "calib.txt");
    KittiFolder set{.path = path,
                    .layout = is_sequence ? KittiLayout::kSequence : KittiLayout::kSet,
                    .grey = grey};
    if (IsFolder(set.Images(false))) return set;
  }
  return std::nullopt;
}

// The files of one frame.
struct KittiFiles {
  KittiFiles(const KittiFolder& folder, const std::string& id)
      : image_name(id + std::string(IsFile(folder.Images(false) / (id + std::string(kStereoPng)))
                                        ? kStereoPng
                                        : kPng)),
        left(folder.Images(false) / image_name),
        right(folder.Images(true) / image_name),
        truth(Truth(folder, "disp_occ")),
        seen_truth(Truth(folder, "disp_noc")),
        scan(folder.path / "velodyne" / (id + ".bin")) {
    if (folder.layout == KittiLayout::kSet) {
      const fs::path of_2015 = folder.path / "calib_cam_to_cam" / (id + ".txt");
      calibration = folder.path / "calib" / (id + ".txt");
      if (!IsFile(calibration) && IsFile(of_2015)) calibration = of_2015;
    }
    if (folder.layout == KittiLayout::kSequence) calibration = folder.path / "calib.txt";
    if (folder.layout == KittiLayout::kRaw) {
      const bool is_here = IsFile(folder.path / kRawCalibration);
      calibration = (is_here ? folder.path : folder.path.parent_path()) / kRawCalibration;
      scan = folder.path / "velodyne_points" / "data" / (id + ".bin");
    }
  }

  // The set of 2015 numbers its truths, that of 2012 does not.
  fs::path Truth(const KittiFolder& folder, const std::string& name) const {
    const fs::path of_2012 = folder.path / name / image_name;
    return IsFile(of_2012) ? of_2012 : folder.path / (name + "_0") / image_name;
  }

  std::string image_name;
  fs::path left, right;
  fs::path truth;       // also of what only the left camera sees
  fs::path seen_truth;  // of what both see
  fs::path calibration;
  fs::path scan;
};

// @param with_scan  otherwise the pair is enough: the stereo sets have no scans, nor their pose.
KittiCalibration ReadCalibration(const KittiFolder& folder, const KittiFiles& files, cv::Size size,
                                 bool with_scan) {
  if (!with_scan) return {.pair = ReadKittiPair(files.calibration, size, folder.grey)};
  if (folder.layout == KittiLayout::kSet && !IsFile(files.scan)) {
    throw ConfigError("scan " + files.scan.string() +
                      ": not there; allowed: that of a Velodyne, or ?tof=none");
  }
  switch (folder.layout) {
    case KittiLayout::kSequence:
      return ReadKittiSequenceCalibration(files.calibration, size, folder.grey);
    case KittiLayout::kRaw:
      return ReadKittiRawCalibration(files.calibration.parent_path(), size, folder.grey);
    default:
      return ReadKittiCalibration(files.calibration, size);
  }
}

ConfigError BadPlace(const std::string& place, const std::string& reason) {
  return BadSource("kitti:" + place, reason,
                   "FOLDER or FOLDER/ID with image_2/ID_10.png, image_2/ID.png, "
                   "image_0/ID.png or image_02/data/ID.png, as KITTI has them");
}

// In the stereo set the neighbours in time, ID_11.png, are no frames of their own.
std::set<std::string> FrameIds(const fs::path& images) {
  std::set<std::string> all;
  std::set<std::string> stereo;
  for (const fs::directory_entry& entry : fs::directory_iterator(images)) {
    const std::string name = entry.path().filename();
    if (name.starts_with('.')) continue;  // hidden, as macOS leaves beside each file
    if (name.ends_with(kStereoPng)) stereo.insert(name.substr(0, name.size() - kStereoPng.size()));
    if (name.ends_with(kPng)) all.insert(name.substr(0, name.size() - kPng.size()));
  }
  return stereo.empty() ? all : stereo;
}

cv::Mat1f ReadTruth(const fs::path& path, cv::Size expected) {
  const cv::Mat image = ReadImage(path, cv::IMREAD_UNCHANGED);
  if (image.type() != CV_16UC1) {
    throw ConfigError("ground truth " + path.string() +
                      ": not grey with 16 bits; allowed: 16-bit grey disparities, 256 codes a px");
  }
  RequireSize(path, image.size(), expected);
  cv::Mat1f disparity(image.size());
  std::transform(image.begin<uint16_t>(), image.end<uint16_t>(), disparity.begin(),
                 [](uint16_t code) {
                   return code == 0 ? std::numeric_limits<float>::quiet_NaN()
                                    : static_cast<float>(code / kCodesPerPx);
                 });
  return disparity;
}

GroundTruth ReadTruth(const KittiFiles& files, cv::Size size) {
  const bool has_all = IsFile(files.truth);
  const bool has_seen = IsFile(files.seen_truth);
  GroundTruth truth;
  if (!has_all && !has_seen) return truth;
  truth.left = ReadTruth(has_all ? files.truth : files.seen_truth, size);
  const cv::Mat1f seen = has_seen ? ReadTruth(files.seen_truth, size) : truth.left;
  truth.nonoccluded = seen > 0;  // unknown is NaN
  return truth;
}

class KittiDataset : public Dataset {
 public:
  KittiDataset(const std::string& place, const CaptureConfig& config)
      : uses_scan_(config.tof() != "none"), beams_(config.beams()) {
    for (const std::string& frame : KittiPlaces(place)) {
      const fs::path path(frame);
      folder_ = *FolderAt(path.parent_path());
      frames_.emplace_back(folder_, path.filename());
    }
    const cv::Size size = ReadImage(frames_.front().left, cv::IMREAD_ANYCOLOR).size();
    const KittiCalibration calibration =
        ReadCalibration(folder_, frames_.front(), size, uses_scan_);
    rig_.pair = calibration.pair;
    if (uses_scan_) rig_.tof = TofGridCamera(rig_.pair, 1);
    left_from_scanner_ = calibration.left_from_scanner;
    actual_left_from_scanner_ = TurnedScanner(left_from_scanner_, config.range_errors());
    if (folder_.layout == KittiLayout::kSet) {
      for (const KittiFiles& files : frames_) RequireThisCalibration(files);
    }
    Get(0);
  }

  const Rig& rig() const override { return rig_; }
  std::optional<int64_t> frame_count() const override { return std::ssize(frames_); }

  DatasetFrame Get(int64_t index) override {
    assert(index >= 0 && index < std::ssize(frames_));
    const KittiFiles& files = frames_[static_cast<size_t>(index)];
    DatasetFrame frame;
    frame.left = ReadView(files.left);
    frame.right = ReadView(files.right);
    if (uses_scan_) frame.tof = ReadTof(files.scan);
    frame.truth = ReadTruth(files, rig_.pair.size());
    return frame;
  }

 private:
  // A rig has one calibration, and KITTI's recordings have several.
  void RequireThisCalibration(const KittiFiles& files) const {
    const KittiCalibration other = ReadCalibration(folder_, files, rig_.pair.size(), uses_scan_);
    const Rig rig{.pair = other.pair, .tof = rig_.tof};
    if (RigId(rig) == RigId(rig_) &&
        other.left_from_scanner.matrix() == left_from_scanner_.matrix()) {
      return;
    }
    throw ConfigError("calibration " + files.calibration.string() + ": not that of " +
                      frames_.front().calibration.string() +
                      "; allowed: frames of one calibration, or one frame (kitti:FOLDER/ID)");
  }

  cv::Mat ReadView(const fs::path& path) const {
    cv::Mat image = ReadImage(path, cv::IMREAD_ANYCOLOR);
    RequireSize(path, image.size(), rig_.pair.size());
    return image;
  }

  TofImage ReadTof(const fs::path& file) const {
    const std::vector<Eigen::Vector3d> points = ReadVelodyneScan(file);
    const TofImage all = TofImageFromScan(points, actual_left_from_scanner_, rig_.pair);
    if (cv::countNonZero(all.depth_m > 0) == 0) {
      throw ConfigError("scan " + file.string() +
                        ": no point falls into the left image; allowed: the scan of this "
                        "calibration, or ?tof=none");
    }
    return TofImageFromScan(KeepBeams(points, beams_), actual_left_from_scanner_, rig_.pair);
  }

  bool uses_scan_;
  int beams_;
  KittiFolder folder_;
  std::vector<KittiFiles> frames_;
  Rig rig_;
  Eigen::Isometry3d left_from_scanner_ = Eigen::Isometry3d::Identity();  // by the calibration
  Eigen::Isometry3d actual_left_from_scanner_ = Eigen::Isometry3d::Identity();
};

}  // namespace

std::vector<std::string> KittiPlaces(const std::string& place) {
  fs::path path = place;
  if (!path.has_filename()) path = path.parent_path();  // FOLDER/
  if (const std::optional<KittiFolder> folder = FolderAt(path)) {
    std::vector<std::string> places;
    for (const std::string& id : FrameIds(folder->Images(false))) places.push_back(path / id);
    if (places.empty()) throw BadPlace(place, "no frame");
    return places;
  }
  const std::optional<KittiFolder> folder = FolderAt(path.parent_path());
  if (!folder || !IsFile(KittiFiles(*folder, path.filename()).left)) {
    throw BadPlace(place, "no such frame" + WhyClosed(path / "image_2"));
  }
  return {path.string()};
}

std::unique_ptr<Dataset> OpenKitti(const std::string& place, const CaptureConfig& config) {
  if (config.tof() == "sr4000" || config.tof() == kZones) {
    throw ConfigError("capture.tof = " + config.tof() + ": kitti:" + place +
                      " has a scan of its own; allowed: the scan (grid, the default), none");
  }
  return std::make_unique<KittiDataset>(place, config);
}

}  // namespace sprout::scenes
