#include "common/scenes/velodyne_scan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>

#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/scenes/pfm.h"

namespace sprout::scenes {
namespace {

constexpr int kVelodyneBeams = 64;
constexpr double kTopDegrees = 2;
constexpr double kBottomDegrees = -24.9;

using StoredPoint = std::array<float, 4>;  // x, y, z, reflectance

// One turn is about 130 000 points; ten times as many are no scan.
constexpr uintmax_t kMaxPoints = 1'300'000;
constexpr double kMaxCoordinateM = 1000;  // the scanner sees 120 m far

ConfigError BadScan(const std::filesystem::path& file, const std::string& reason) {
  return ConfigError("scan " + file.string() + ": " + reason + "; allowed: 1 to " +
                     std::to_string(kMaxPoints) +
                     " points of 16 bytes: x, y, z (within 1000 m) and reflectance as float32");
}

// 0 (top) to 63.
int VelodyneBeam(const Eigen::Vector3d& point) {
  const double elevation_degrees =
      std::atan2(point.z(), std::hypot(point.x(), point.y())) * 180 / std::numbers::pi;
  const double step = (kTopDegrees - kBottomDegrees) / kVelodyneBeams;
  const double beam = std::floor((kTopDegrees - elevation_degrees) / step);
  return static_cast<int>(std::clamp(beam, 0.0, kVelodyneBeams - 1.0));
}

}  // namespace

std::vector<Eigen::Vector3d> ReadVelodyneScan(const std::filesystem::path& file) {
  static_assert(std::endian::native == std::endian::little);
  std::error_code ignored;
  const uintmax_t bytes = IsFile(file) ? std::filesystem::file_size(file, ignored) : 0;
  NoteInputFile(file);
  std::ifstream stream(file, std::ios::binary);
  if (!IsFile(file) || !stream) throw BadScan(file, "cannot be read");
  if (bytes == 0) throw BadScan(file, "empty");
  if (bytes % sizeof(StoredPoint) != 0) {
    throw BadScan(file, "ends within a point, at byte " + std::to_string(bytes));
  }
  if (bytes / sizeof(StoredPoint) > kMaxPoints) {
    throw BadScan(file, std::to_string(bytes / sizeof(StoredPoint)) + " points");
  }
  std::vector<StoredPoint> stored(bytes / sizeof(StoredPoint));
  if (!stream.read(reinterpret_cast<char*>(stored.data()), static_cast<std::streamsize>(bytes))) {
    throw BadScan(file, "cannot be read");
  }
  std::vector<Eigen::Vector3d> points;
  points.reserve(stored.size());
  for (size_t i = 0; i < stored.size(); ++i) {
    const Eigen::Vector3d point(stored[i][0], stored[i][1], stored[i][2]);
    if (point.array().isNaN().all()) continue;  // no return, of clouds that keep their rows
    if (!(point.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kMaxCoordinateM)) {
      throw BadScan(file, "point " + std::to_string(i + 1) + " is out of range");
    }
    points.push_back(point);
  }
  if (points.empty()) throw BadScan(file, "all points are NaN");
  return points;
}

std::vector<Eigen::Vector3d> KeepBeams(const std::vector<Eigen::Vector3d>& points, int beams) {
  assert(beams > 0 && kVelodyneBeams % beams == 0);
  const int step = kVelodyneBeams / beams;
  std::vector<Eigen::Vector3d> kept;
  std::ranges::copy_if(points, std::back_inserter(kept), [step](const Eigen::Vector3d& point) {
    return VelodyneBeam(point) % step == step / 2;
  });
  return kept;
}

TofImage TofImageFromScan(const std::vector<Eigen::Vector3d>& points,
                          const Eigen::Isometry3d& left_from_scanner, const RectifiedPair& pair) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  TofImage tof{.depth_m = cv::Mat1f(pair.size(), kNone), .amplitude = {}};
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d in_left = left_from_scanner * point;
    if (!(in_left.z() > 0)) continue;
    const double u = std::round(pair.focal_px * in_left.x() / in_left.z() + pair.cx);
    const double v = std::round(pair.focal_px * in_left.y() / in_left.z() + pair.cy);
    if (!(u >= 0 && u < pair.width && v >= 0 && v < pair.height)) continue;
    float& depth_m = tof.depth_m(static_cast<int>(v), static_cast<int>(u));
    const auto z = static_cast<float>(in_left.z());
    if (!(depth_m <= z)) depth_m = z;  // also where there is none yet
  }
  return tof;
}

}  // namespace sprout::scenes
