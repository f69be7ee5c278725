#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "common/rig/raw_rig.h"

namespace sprout {

/// KITTI's calibration of its unrectified pictures.
using KittiValues = std::map<std::string, std::vector<double>>;

// The "key: numbers" lines of calib_cam_to_cam.txt.
inline KittiValues ReadKittiValues(const std::filesystem::path& path) {
  KittiValues values;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(':');
    std::istringstream numbers(line.substr(colon + 1));
    for (double number = 0; numbers >> number;) values[line.substr(0, colon)].push_back(number);
  }
  return values;
}

inline Lens KittiLens(const KittiValues& values, const std::string& camera) {
  const std::vector<double>& k = values.at("K_" + camera);
  const std::vector<double>& size = values.at("S_" + camera);
  Lens lens{.width = static_cast<int>(size[0]),
            .height = static_cast<int>(size[1]),
            .fx = k[0],
            .fy = k[4],
            .cx = k[2],
            .cy = k[5]};
  std::copy_n(values.at("D_" + camera).begin(), lens.distortion.size(), lens.distortion.begin());
  return lens;
}

// Cameras 0 and 1, whose pictures are grey. KITTI gives camera 0 in camera 1's frame.
inline RawRig KittiRig(const KittiValues& values) {
  RawRig rig;
  rig.left = KittiLens(values, "00");
  rig.right = KittiLens(values, "01");
  const Eigen::Matrix3d right_from_left =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.at("R_01").data());
  const Eigen::Map<const Eigen::Vector3d> translation(values.at("T_01").data());
  rig.left_from_right.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(right_from_left.transpose())).normalized();
  rig.left_from_right.translation_m = -right_from_left.transpose() * translation;
  return rig;
}

}  // namespace sprout
