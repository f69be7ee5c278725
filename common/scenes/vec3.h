#ifndef SPROUT_COMMON_SCENES_VEC3_H_
#define SPROUT_COMMON_SCENES_VEC3_H_

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

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_VEC3_H_
