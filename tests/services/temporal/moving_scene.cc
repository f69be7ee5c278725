#include "tests/services/temporal/moving_scene.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace sprout::temporal {
namespace {

constexpr int kTextureSide = 1024;
constexpr double kTexelsPerM = 120;

const cv::Mat1f& Texture() {
  static const cv::Mat1f texture = [] {
    cv::Mat1f noise(kTextureSide, kTextureSide);
    cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(noise, noise, {}, 3);
    cv::normalize(noise, noise, 10, 245, cv::NORM_MINMAX);
    return noise;
  }();
  return texture;
}

double TextureAt(double x_m, double y_m) {
  const double x = x_m * kTexelsPerM + kTextureSide / 2.0;
  const double y = y_m * kTexelsPerM + kTextureSide / 2.0;
  const double left = std::floor(x), top = std::floor(y);
  const auto at = [&](int dx, int dy) {
    return double{Texture()((static_cast<int>(top) + dy) & (kTextureSide - 1),
                            (static_cast<int>(left) + dx) & (kTextureSide - 1))};
  };
  const double right = x - left, below = y - top;
  return (1 - below) * ((1 - right) * at(0, 0) + right * at(1, 0)) +
         below * ((1 - right) * at(0, 1) + right * at(1, 1));
}

}  // namespace

Pose MovedBy(double x_m, double y_m, double z_m, double turn) {
  Pose pose;
  pose.rotation = Eigen::Quaterniond(1, 0, turn / 2, 0).normalized();
  pose.translation_m = {x_m, y_m, z_m};
  return pose;
}

MovingScene SceneFrom(const Pose& world_from_left, cv::Size size) {
  MovingScene scene;
  scene.pair = {.width = size.width,
                .height = size.height,
                .focal_px = 0.9 * size.width,
                .cx = size.width / 2.0 - 3,
                .cy = size.height / 2.0 + 2,
                .cx_right = size.width / 2.0,
                .baseline_m = 0.2};
  scene.left.create(size);
  scene.truth.create(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector3d ray =
          world_from_left.rotation * Eigen::Vector3d((u - scene.pair.cx) / scene.pair.focal_px,
                                                     (v - scene.pair.cy) / scene.pair.focal_px, 1);
      const auto hit = [&](double plane_m) {
        const double z = (plane_m - world_from_left.translation_m.z()) / ray.z();
        return std::pair(z, Eigen::Vector3d(world_from_left.translation_m + z * ray));
      };
      auto [z, point] = hit(2);
      const bool board = std::abs(point.x()) < 0.4 && std::abs(point.y()) < 0.3;
      if (!board) std::tie(z, point) = hit(4);
      const double shift = board ? 3.3 : 0;  // another part of the texture
      scene.left(v, u) = cv::saturate_cast<uint8_t>(TextureAt(point.x() + shift, point.y()));
      scene.truth(v, u) = static_cast<float>(scene.pair.DisparityFromDepth(z));
    }
  }
  return scene;
}

TemporalInput FrameFrom(const MovingScene& scene, int64_t seq, double noise_px) {
  cv::Mat1f noise(scene.truth.size());
  cv::RNG(static_cast<uint64_t>(seq) + 1).fill(noise, cv::RNG::NORMAL, 0, noise_px);
  const cv::Mat1f noisy(cv::Mat(scene.truth + noise));
  return {.id = {.utime = 1'000'000 + 100'000 * seq, .seq = seq, .rig_id = "rig"},
          .left = scene.left,
          .disparity = FromPx(noisy),
          .confidence = cv::Mat1b(scene.truth.size(), uint8_t{230}),
          .pair = scene.pair};
}

double ErrorOf(const DisparityImage& disparity, const MovingScene& scene) {
  constexpr int kBorder = 4;
  double sum = 0;
  int pixels = 0;
  for (int v = kBorder; v < disparity.height() - kBorder; ++v) {
    for (int u = kBorder; u < disparity.width() - kBorder; ++u) {
      const float error = std::abs(disparity.Px(u, v) - scene.truth(v, u));
      sum += std::isfinite(error) ? static_cast<double>(error) : 50;
      ++pixels;
    }
  }
  return sum / pixels;
}

}  // namespace sprout::temporal
