#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "common/core/rig.h"
#include "common/scenes/synthetic_scene.h"
#include "common/scenes/tof_grid.h"

namespace sprout::scenes {

/// A camera with lens distortion, anywhere in a synthetic scene: several rays through each pixel.
class LensView {
 public:
  using Rotation = Eigen::Quaternion<double, Eigen::DontAlign>;

  /// @param left_from_camera, position_m  pose in the frame of the scene.
  /// @param rays_per_side  a pixel has the square of this number.
  LensView(const Lens& lens, const Rotation& left_from_camera, const Eigen::Vector3d& position_m,
           int rays_per_side);

  /// Size of the grid of all rays: the image's, times rays_per_side.
  cv::Size size() const { return size_; }

  /// Called for each ray that meets a solid.
  /// @param x, y     of the ray, in the grid of size().
  /// @param depth_m  of the nearest solid, along the camera's axis.
  using Visit = std::function<void(int x, int y, double depth_m, const Vec3& bgr)>;

  /// Casts all rays, rows in parallel.
  /// @param focal_px  textures are as fine as a camera of that focal length resolves.
  void Cast(const std::vector<Solid>& solids, double focal_px, const Visit& visit) const;

 private:
  cv::Size size_;
  Vec3 origin_;
  std::vector<Vec3> directions_;
};

/// Samples of what a ToF camera sees. @pre view has TofSamples::kPerSide rays per side.
TofSamples RenderTof(const LensView& view, const std::vector<Solid>& solids, double focal_px);

/// What one ToF pixel looks at.
struct Footprint {
  int known = 0;        ///< samples with a surface
  double light = 0;     ///< mean light that comes back, in the unit of albedo / m²
  double mixed_m = 0;   ///< depth of all light together
  double middle_m = 0;  ///< depth of the surface that fills most of the pixel
  double spread = 0;    ///< between the nearest and the farthest depth, a share of the nearest
  int samples = 0;      ///< known or not

  bool IsMostlyKnown() const { return 2 * known >= samples; }
};

/// The footprints of all ToF pixels, row by row.
/// @param footprint_px  side of the square that a pixel gathers light from, ToF px, ≥ 1.
std::vector<Footprint> FootprintsOf(const TofSamples& samples, double footprint_px);

}  // namespace sprout::scenes
