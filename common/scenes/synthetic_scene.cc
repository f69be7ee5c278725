#include "common/scenes/synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sprout::scenes {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

// Towards the light: above, to the left, behind the cameras. A unit vector.
constexpr Vec3 kToLight = {-0.48, -0.64, -0.6};
constexpr double kAmbient = 0.45;

// Widest footprint of a pixel on a slanted surface, in pixels of a surface seen head-on.
constexpr double kMaxSlant = 9;

Vec3 ToLocal(const Solid& solid, const Vec3& v) {
  return {solid.cos_yaw * v.x - solid.sin_yaw * v.z, v.y,
          solid.sin_yaw * v.x + solid.cos_yaw * v.z};
}

Vec3 ToWorld(const Solid& solid, const Vec3& v) {
  return {solid.cos_yaw * v.x + solid.sin_yaw * v.z, v.y,
          solid.cos_yaw * v.z - solid.sin_yaw * v.x};
}

double IfInFront(double depth) { return depth > 0 ? depth : kNothing; }

// Where the ray is between two parallel planes at ±half: from first to second.
std::pair<double, double> Slab(double origin, double direction, double half) {
  const double inverse = 1 / direction;
  const double a = (-half - origin) * inverse;
  const double b = (half - origin) * inverse;
  return a < b ? std::pair{a, b} : std::pair{b, a};
}

double IntersectBox(const Solid& box, const Ray& ray) {
  const Vec3 origin = ToLocal(box, ray.origin - box.centre);
  const Vec3 direction = ToLocal(box, ray.direction);
  const auto [in_x, out_x] = Slab(origin.x, direction.x, box.half_size.x);
  const auto [in_y, out_y] = Slab(origin.y, direction.y, box.half_size.y);
  const auto [in_z, out_z] = Slab(origin.z, direction.z, box.half_size.z);
  const double in = std::max(in_x, std::max(in_y, in_z));
  const double out = std::min(out_x, std::min(out_y, out_z));
  return in <= out ? IfInFront(in) : kNothing;
}

double IntersectSphere(const Solid& sphere, const Ray& ray) {
  const Vec3 to_centre = sphere.centre - ray.origin;
  const double radius = sphere.half_size.x;
  const double a = Dot(ray.direction, ray.direction);
  const double b = Dot(ray.direction, to_centre);
  const double discriminant = b * b - a * (Dot(to_centre, to_centre) - radius * radius);
  return discriminant >= 0 ? IfInFront((b - std::sqrt(discriminant)) / a) : kNothing;
}

Vec3 LocalNormal(const Solid& solid, const Vec3& local) {
  switch (solid.shape) {
    case Solid::Shape::kWall:
      return {0, 0, -1};
    case Solid::Shape::kFloor:
      return {0, -1, 0};
    case Solid::Shape::kSphere:
      return (1 / solid.half_size.x) * local;
    case Solid::Shape::kBox:
      break;
  }
  // The face that the point lies on is the one it sticks out to furthest.
  const Vec3& half = solid.half_size;
  const Vec3 reach = {std::abs(local.x) / half.x, std::abs(local.y) / half.y,
                      std::abs(local.z) / half.z};
  if (reach.x >= reach.y && reach.x >= reach.z) return {local.x < 0 ? -1.0 : 1.0, 0, 0};
  if (reach.y >= reach.z) return {0, local.y < 0 ? -1.0 : 1.0, 0};
  return {0, 0, local.z < 0 ? -1.0 : 1.0};
}

// Random numbers for the layout. <random> is not used: its distributions differ between libraries.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(Scramble(seed + 1)) {}

  uint64_t Bits() { return Scramble(state_ += 0x9e3779b97f4a7c15); }
  double Between(double low, double high) {
    return low + (high - low) * (static_cast<double>(Bits() >> 11) * 0x1p-53);
  }
  int Whole(int low, int high) {
    return low + static_cast<int>(Bits() % static_cast<uint64_t>(high - low + 1));
  }
  double Sign() { return Bits() % 2 == 0 ? 1.0 : -1.0; }

 private:
  uint64_t state_;
};

Material RandomMaterial(Dice& dice, bool textured) {
  Material material;
  material.textured = textured;
  material.key = dice.Bits();
  const Vec3 hue = {dice.Between(0.5, 1), dice.Between(0.5, 1), dice.Between(0.5, 1)};
  const double strongest = std::max(hue.x, std::max(hue.y, hue.z));
  material.light_bgr = (255 / strongest) * hue;
  material.dark_bgr = {dice.Between(10, 60), dice.Between(10, 60), dice.Between(10, 60)};
  return material;
}

}  // namespace

double Intersect(const Solid& solid, const Ray& ray) {
  switch (solid.shape) {
    case Solid::Shape::kWall: {
      const Vec3 normal = ToWorld(solid, {0, 0, -1});
      return IfInFront(Dot(normal, solid.centre - ray.origin) / Dot(normal, ray.direction));
    }
    case Solid::Shape::kFloor:
      return IfInFront((solid.centre.y - ray.origin.y) / ray.direction.y);
    case Solid::Shape::kBox:
      return IntersectBox(solid, ray);
    case Solid::Shape::kSphere:
      return IntersectSphere(solid, ray);
  }
  return kNothing;
}

Vec3 ColourAt(const Solid& solid, const Vec3& point, double focal_px) {
  const Material& material = solid.material;
  const Vec3 local = ToLocal(solid, point - solid.centre);
  const Vec3 normal = ToWorld(solid, LocalNormal(solid, local));
  const double light = kAmbient + (1 - kAmbient) * std::max(0.0, Dot(normal, kToLight));
  if (!material.textured) {
    const double shade = 1 - 0.12 * std::clamp(local.y / solid.half_size.y, -1.0, 1.0);
    return (0.85 * light * shade) * material.light_bgr;
  }
  // A slanted surface has more of its texture in one pixel. The slant is the one that the left
  // camera sees, for the right one too: a point must have one colour.
  const double towards = std::abs(Dot(normal, point));
  const double slant = std::min(kMaxSlant, std::sqrt(Dot(point, point)) / std::max(towards, 1e-9));
  const double pixel_m = point.z / focal_px * std::sqrt(slant);
  const double tone = SolidNoise(local, pixel_m, material.key);
  return light * (material.dark_bgr + tone * (material.light_bgr - material.dark_bgr));
}

double SyntheticScene::Swing::At(int64_t index, double later) const {
  const auto frames = static_cast<double>((index % period + phase) % period);
  const double turn = std::fmod(frames + later, period) / period;
  const double triangle = turn < 0.5 ? 2 * turn : 2 - 2 * turn;             // 0 to 1 to 0
  return amplitude * (2 * (triangle * triangle * (3 - 2 * triangle)) - 1);  // slow at the ends
}

// All draws are in braces or in statements of their own: the order of function arguments is up to
// the compiler.
SyntheticScene::SyntheticScene(uint32_t seed, double floor_m) {
  using enum Solid::Shape;
  Dice dice(seed);
  const auto swing = [&dice](double amplitude) {
    const int period = dice.Whole(60, 160);
    return Swing{dice.Between(0.7, 1) * amplitude, period, dice.Whole(0, period - 1)};
  };
  const auto add = [this](const Solid& solid) -> Actor& {  // valid until the next call
    return actors_.emplace_back(Actor{.solid = solid});
  };
  const double side = dice.Sign();  // what is on the left with one seed is on the right in others

  Actor& wall = add({.shape = kWall, .centre = {0, 0, 6}, .material = RandomMaterial(dice, true)});
  wall.yaw_tangent = dice.Between(-0.06, 0.06);

  add({.shape = kFloor, .centre = {0, floor_m, 0}, .material = RandomMaterial(dice, true)});

  // A smooth board near the wall, which only the ToF camera can measure.
  Actor& board = add({.shape = kBox,
                      .centre = {side * dice.Between(0.7, 1.2), dice.Between(-0.6, -0.3), 4.7},
                      .half_size = {dice.Between(0.7, 0.9), dice.Between(0.55, 0.75), 0.04},
                      .material = RandomMaterial(dice, false)});
  board.yaw_tangent = dice.Between(-0.2, 0.2);
  board.x = swing(0.3);

  // A crate on the floor, coming and going.
  const double crate_half = dice.Between(0.38, 0.48);
  Actor& crate = add({.shape = kBox,
                      .centre = {-side * dice.Between(0.5, 0.9), floor_m - crate_half, 3.4},
                      .half_size = {crate_half, crate_half, crate_half},
                      .material = RandomMaterial(dice, true)});
  crate.z = swing(0.4);
  crate.yaw = swing(0.35);

  // A thin pole: in small images narrower than a matching window.
  Actor& pole = add({.shape = kBox,
                     .centre = {side * dice.Between(0.15, 0.5), floor_m - 1.1, 3.0},
                     .half_size = {0.04, 1.1, 0.04},
                     .material = RandomMaterial(dice, true)});
  pole.x = swing(0.25);

  // A smaller box in front of it.
  const double box_half = dice.Between(0.18, 0.24);
  Actor& box = add({.shape = kBox,
                    .centre = {side * dice.Between(0.3, 0.6), floor_m - box_half, 2.2},
                    .half_size = {box_half, box_half, box_half},
                    .material = RandomMaterial(dice, true)});
  box.yaw_tangent = dice.Between(-0.4, 0.4);
  box.x = swing(0.3);
  box.yaw = swing(0.3);

  // A smooth box that hangs in the air and turns.
  Actor& lamp = add({.shape = kBox,
                     .centre = {-side * dice.Between(0.2, 0.6), dice.Between(-0.6, -0.35), 2.5},
                     .half_size = {dice.Between(0.2, 0.3), dice.Between(0.12, 0.18), 0.2},
                     .material = RandomMaterial(dice, false)});
  lamp.y = swing(0.12);
  lamp.yaw = swing(0.6);

  // A ball, the nearest of all.
  const double radius = dice.Between(0.17, 0.21);
  Actor& ball = add({.shape = kSphere,
                     .centre = {-side * dice.Between(-0.1, 0.4), dice.Between(0.05, 0.15), 1.5},
                     .half_size = {radius, radius, radius},
                     .material = RandomMaterial(dice, true)});
  ball.x = swing(0.35);
  ball.y = swing(0.15);
  ball.z = swing(0.15);
}

std::vector<Solid> SyntheticScene::At(int64_t index, double later) const {
  std::vector<Solid> solids;
  solids.reserve(actors_.size());
  for (const Actor& actor : actors_) {
    Solid solid = actor.solid;
    solid.centre = solid.centre + Vec3{actor.x.At(index, later), actor.y.At(index, later),
                                       actor.z.At(index, later)};
    const double t = actor.yaw_tangent + actor.yaw.At(index, later);
    solid.cos_yaw = (1 - t * t) / (1 + t * t);
    solid.sin_yaw = 2 * t / (1 + t * t);
    solids.push_back(solid);
  }
  return solids;
}

}  // namespace sprout::scenes
