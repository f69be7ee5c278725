#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/core/image.h"
#include "common/scenes/dataset.h"
#include "common/scenes/solid_texture.h"

namespace sprout::scenes {

/// Appearance of a surface. It is matt: its colour does not depend on the viewing direction.
struct Material {
  Vec3 dark_bgr;         ///< colour where the texture is 0
  Vec3 light_bgr;        ///< colour where it is 1, and everywhere when there is no texture
  bool textured = true;  ///< without texture: one colour with a slight smooth shading
  uint64_t key = 0;      ///< of the texture
};

/// A solid in the scene, in the frame of the left camera (m; x right, y down, z forward).
struct Solid {
  enum class Shape {
    kWall,   ///< plane with normal −z before rotation
    kFloor,  ///< plane with normal −y
    kBox,
    kSphere,
  };

  Shape shape = Shape::kBox;
  Vec3 centre;
  Vec3 half_size = {};  ///< box: half the edges; sphere: radius in all three; planes: not used
  double cos_yaw = 1;   ///< right-handed rotation about the y axis
  double sin_yaw = 0;
  Material material;
};

/// A viewing ray. Its parameter is the depth (m) along an axis when the direction has the component
/// 1 along it, as direction.z = 1 for the colour cameras, and the camera stands at the origin.
struct Ray {
  Vec3 origin;
  Vec3 direction;
};

/// Parameter > 0 at which the ray meets the solid; infinity when it does not. The cameras are
/// outside.
double Intersect(const Solid& solid, const Ray& ray);

/// Colour of the solid at a point of its surface; the same for both cameras.
/// @param point       of the surface, in the left camera's frame, m.
/// @param focal_px    of the cameras: determines how fine a texture they resolve.
/// @returns BGR, 0 to 255.
Vec3 ColourAt(const Solid& solid, const Vec3& point, double focal_px);

/// A room with moving solids: a textured wall and floor, boxes and a ball, some without texture.
/// Positions, colours and motions follow from the seed.
class SyntheticScene {
 public:
  /// @param floor_m  height of the cameras over the floor, m.
  SyntheticScene(uint32_t seed, double floor_m);

  /// The solids at frame `index` ≥ 0, always the same number in the same order. A pure function.
  /// @param later  how long after it, frames, 0 to 1.
  std::vector<Solid> At(int64_t index, double later = 0) const;

 private:
  // To and fro between −amplitude and amplitude, once in `period` frames.
  struct Swing {
    double amplitude = 0;
    int period = 1;
    int phase = 0;

    double At(int64_t index, double later) const;
  };
  struct Actor {
    Solid solid;
    double yaw_tangent = 0;  // tangent of half the yaw angle: turns without sine and cosine
    Swing x{}, y{}, z{};     // of the centre, m
    Swing yaw{};             // of yaw_tangent
  };

  std::vector<Actor> actors_;
};

inline constexpr int kMinSyntheticSide = 16;        ///< px: below, objects are smaller than a pixel
inline constexpr int kMaxSyntheticSide = kMaxSide;  ///< px: a frame takes 16 bytes a pixel

/// Endless frames of SyntheticScene in colour, seen by a rectified pair whose disparities span
/// about 2 to 15 % of the image width, with exact ground truth at the pixel centres of both views
/// and a simulated ToF camera: config.tof() = grid samples the left truth, sr4000 is rendered from
/// the scene.
///
/// Frame i depends on size, config.seed() and i only: same bytes on every machine, with any
/// number of threads. O(pixels) a frame, in parallel over rows.
///
/// @param size  of the images; each side kMinSyntheticSide to kMaxSyntheticSide px.
/// @throws ConfigError when a grid of config.tof_grid_px() is larger than the image.
std::unique_ptr<Dataset> OpenSynthetic(cv::Size size, const CaptureConfig& config);

}  // namespace sprout::scenes
