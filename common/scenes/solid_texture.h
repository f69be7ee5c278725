#pragma once

#include <cstdint>

namespace sprout::scenes {

/// Three numbers: a point (m) or a BGR colour (0 to 255). Not Eigen or cv::Vec: the synthetic scene
/// must have the same bytes everywhere, so the order of every sum is fixed here.
struct Vec3 {
  double x = 0;
  double y = 0;
  double z = 0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double Dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// A hash of a number, the same on every machine; hashes of neighbours are unrelated.
uint64_t Scramble(uint64_t value);

/// Value noise in space: a point has the same value for every camera.
///
/// Three octaves, chosen by the size of a pixel's footprint: features of about 2 to 12 px, fine
/// enough for stereo, but not so fine that they alias. Octaves fade in and out as the distance
/// changes.
///
/// @param point       m, in the coordinates of the object; |coordinate / pixel_m| < 1e9.
/// @param pixel_m     width of a pixel's footprint at the point, m, > 0.
/// @param key         different keys give different noise.
/// @returns 0 to 1, mean about 0.5.
/// O(1), no libm function that rounds differently between machines.
double SolidNoise(const Vec3& point, double pixel_m, uint64_t key);

/// A normal deviate from a key: the sum of twelve uniform numbers less its mean (Irwin and Hall).
/// Variance 1, no value beyond ±6, and no libm function that differs between machines.
inline double NormalDeviate(uint64_t key) {
  uint64_t sum = 0;
  for (uint64_t word = 0; word < 3; ++word) {
    const uint64_t bits = Scramble(key + word);
    for (int part = 0; part < 4; ++part) sum += bits >> (16 * part) & 0xffff;
  }
  return (static_cast<double>(sum) - 12 * 32767.5) / 65536;
}

}  // namespace sprout::scenes
