#include <cstring>
#include <vector>

#include "common/config/config_error.h"
#include "common/scenes/kitti_calibration.h"
#include "common/scenes/middlebury_calibration.h"
#include "common/scenes/velodyne_scan.h"
#include "tests/fuzz/targets.h"

namespace sprout::fuzz {
namespace {

const cv::Size kImages(30, 20);

constexpr char kKittiText[] =
    "P0: nobody reads this\n"
    "P2: 100 0 20 5 0 100 15 0.1 0 0 1 0.002\n"
    "P3: 100 0 20 -50 0 100 15 0 0 0 1 0\n"
    "R0_rect: 1 0 0 0 1 0 0 0 1\n"
    "Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n";

scenes::KittiCalibration GoodKitti() {
  const MemoryFile file(BytesOf(kKittiText));
  return scenes::ReadKittiCalibration(file.path(), kImages);
}

}  // namespace

void ReadMiddleburyCalibration(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  try {
    const RectifiedPair pair = scenes::CalibrationFromCalib(file.path(), kImages);
    Check(pair.focal_px > 0 && pair.baseline_m > 0, "a camera without extent");
  } catch (const ConfigError&) {
  }
  try {
    scenes::CalibrationFromDmin(file.path(), 0, kImages, 3);
  } catch (const ConfigError&) {
  }
}

std::vector<Bytes> MiddleburySeeds() {
  return {BytesOf("cam0=[100 0 14; 0 100 9; 0 0 1]\ncam1=[100 0 17; 0 100 9; 0 0 1]\n"
                  "doffs=3\nbaseline=193\nwidth=30\nheight=20\nndisp=12\n"),
          BytesOf("85.5\n")};
}

void ReadKitti(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  try {
    const scenes::KittiCalibration calibration = scenes::ReadKittiCalibration(file.path(), kImages);
    scenes::TofImageFromScan({{10, 0, 0}, {20, 1, -2}, {-5, 0, 0}}, calibration.left_from_scanner,
                             calibration.pair);
  } catch (const ConfigError&) {
  }
}

std::vector<Bytes> KittiSeeds() { return {BytesOf(kKittiText)}; }

void ReadScan(std::span<const uint8_t> bytes) {
  static const scenes::KittiCalibration calibration = GoodKitti();
  const MemoryFile file(bytes);
  try {
    const std::vector<Eigen::Vector3d> points = scenes::ReadVelodyneScan(file.path());
    const TofImage tof = scenes::TofImageFromScan(scenes::KeepBeams(points, 16),
                                                  calibration.left_from_scanner, calibration.pair);
    Check(tof.depth_m.size() == kImages, "a range image of another size");
  } catch (const ConfigError&) {
  }
}

std::vector<Bytes> ScanSeeds() {
  const float points[] = {10, 0, 0, 0.5F, 20, 1, -2, 0, -5, 0, 0, 0, 7, -1, -1, 1};
  Bytes seed(sizeof(points));
  std::memcpy(seed.data(), points, sizeof(points));
  return {seed};
}

}  // namespace sprout::fuzz
