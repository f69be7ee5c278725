#include "tests/services/tools/calibrate/board_scene.h"

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "common/geometry/lens.h"

namespace sprout::calibrate {
namespace {

constexpr int kTexelsPerModule = 16;
constexpr double kPaperMarginM = 0.02;
constexpr double kInk = 25;  // grey levels
constexpr double kPaper = 215;
constexpr double kWall = 110;

Eigen::Isometry3d ToTransform(const Pose& pose) {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = pose.rotation.toRotationMatrix();
  transform.translation() = pose.translation_m;
  return transform;
}

Pose Turned(double x_deg, double y_deg, double z_deg, const Eigen::Vector3d& translation_m) {
  const double radians = std::numbers::pi / 180;
  return {.rotation = Eigen::AngleAxisd(x_deg * radians, Eigen::Vector3d::UnitX()) *
                      Eigen::AngleAxisd(y_deg * radians, Eigen::Vector3d::UnitY()) *
                      Eigen::AngleAxisd(z_deg * radians, Eigen::Vector3d::UnitZ()),
          .translation_m = translation_m};
}

float Bilinear(const cv::Mat1b& image, double x, double y, float outside) {
  const int column = static_cast<int>(std::floor(x));
  const int row = static_cast<int>(std::floor(y));
  if (column < 0 || row < 0 || column + 1 >= image.cols || row + 1 >= image.rows) return outside;
  const auto a = static_cast<float>(x - column);
  const auto b = static_cast<float>(y - row);
  const uchar* above = image[row] + column;
  const uchar* below = image[row + 1] + column;
  return (1 - b) * ((1 - a) * above[0] + a * above[1]) + b * ((1 - a) * below[0] + a * below[1]);
}

}  // namespace

RawRig SceneRig(cv::Size size) {
  const double f = 0.95 * size.width;
  RawRig rig;
  rig.left = {size.width,
              size.height,
              f,
              f * 1.001,
              0.507 * size.width,
              0.493 * size.height,
              {-0.17, 0.09, 0.0006, -0.0004, -0.02}};
  rig.right = {size.width,
               size.height,
               f * 1.004,
               f * 1.003,
               0.491 * size.width,
               0.508 * size.height,
               {-0.165, 0.08, -0.0005, 0.0007, -0.01}};
  rig.left_from_right = Turned(0.7, -1.2, 0.9, {0.12, 0.0015, -0.002});
  rig.tof = {176, 144, 220, 220.3, 88.8, 70.6, {-0.22, 0.08, 0.0006, -0.0004, -0.01}};
  rig.left_from_tof = Turned(-0.8, 1.1, 0.5, {0.055, -0.04, 0.004});
  rig.range_scale = 0.99;
  rig.range_offset_m = 0.012;
  return rig;
}

BoardScene::BoardScene(const Board& board, const RawRig& rig) : board_(board), rig_(rig) {
  cv::Mat1b modules = board.Modules();
  cv::resize(modules, pattern_, {}, kTexelsPerModule, kTexelsPerModule, cv::INTER_NEAREST);
  const int margin = static_cast<int>(kPaperMarginM / board.size().square_m *
                                      Board::kModulesPerSquare * kTexelsPerModule);
  cv::copyMakeBorder(pattern_, pattern_, margin, margin, margin, margin, cv::BORDER_CONSTANT, 255);
  pattern_.convertTo(pattern_, CV_8U, (kPaper - kInk) / 255, kInk);
  cameras_ = {Camera{rig.left, Eigen::Isometry3d::Identity(), {}},
              Camera{rig.right, ToTransform(rig.left_from_right), {}},
              Camera{rig.tof, ToTransform(rig.left_from_tof), {}}};
  for (Camera& camera : cameras_) {
    camera.directions.create(camera.lens.size() + cv::Size(2, 2));
    for (int v = 0; v < camera.directions.rows; ++v) {
      for (int u = 0; u < camera.directions.cols; ++u) {
        const Eigen::Vector2d d = DirectionOfPixel(camera.lens, {u - 1.0, v - 1.0});
        camera.directions(v, u) = {d.x(), d.y()};
      }
    }
  }
}

cv::Mat1f BoardScene::Brightness(const Camera& camera, const Eigen::Isometry3d& left_from_board,
                                 int rays_per_side) const {
  const Eigen::Isometry3d board_from_camera = left_from_board.inverse() * camera.left_from_camera;
  const Eigen::Matrix3d turn = board_from_camera.linear();
  const Eigen::Vector3d from = board_from_camera.translation();
  const double texels_per_m = kTexelsPerModule * Board::kModulesPerSquare / board_.size().square_m;
  const int margin = static_cast<int>(kPaperMarginM * texels_per_m);
  cv::Mat1f image(camera.lens.size());
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      // Linear between neighbouring pixels, which is exact enough for the lens.
      const auto direction = [&](int row, int column) {
        const cv::Vec2d& d = camera.directions(v + 1 + row, u + 1 + column);
        return Eigen::Vector3d(d[0], d[1], 1);
      };
      const Eigen::Vector3d middle = turn * direction(0, 0);
      const Eigen::Vector3d right = turn * (direction(0, 1) - direction(0, -1)) / 2;
      const Eigen::Vector3d down = turn * (direction(1, 0) - direction(-1, 0)) / 2;
      float sum = 0;
      for (int y = 0; y < rays_per_side; ++y) {
        for (int x = 0; x < rays_per_side; ++x) {
          const Eigen::Vector3d ray = middle + ((x + 0.5) / rays_per_side - 0.5) * right +
                                      ((y + 0.5) / rays_per_side - 0.5) * down;
          const Eigen::Vector3d point = from - from.z() / ray.z() * ray;
          sum += Bilinear(pattern_, point.x() * texels_per_m + margin - 0.5,
                          point.y() * texels_per_m + margin - 0.5, float{kWall});
        }
      }
      image(v, u) = sum / static_cast<float>(rays_per_side * rays_per_side);
    }
  }
  return image;
}

TofImage BoardScene::RenderTof(const Eigen::Isometry3d& left_from_board, int rays_per_side,
                               uint32_t seed) const {
  constexpr double kDepthNoiseM = 0.004;
  // Of what white paper at 1 m gives: the noise of the phase that 4 mm are at 30 MHz, 2π · 4 mm /
  // 5 m, is that of the amplitude too.
  constexpr double kAmplitudeNoise = 0.005;
  constexpr double kWallM = 3;
  const Camera& camera = cameras_[kTof];
  const Eigen::Isometry3d board_from_tof = left_from_board.inverse() * camera.left_from_camera;
  const cv::Mat1d range_per_depth = RangePerDepth(camera.lens);
  cv::Mat1f light = Brightness(camera, left_from_board, rays_per_side);
  cv::GaussianBlur(light, light, {0, 0}, 0.4);
  cv::RNG noise(seed);
  TofImage tof{.depth_m = cv::Mat1f(camera.lens.size()),
               .amplitude = cv::Mat1f(camera.lens.size())};
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) {
      const cv::Vec2d& d = camera.directions(v + 1, u + 1);
      const Eigen::Vector3d ray = board_from_tof.linear() * Eigen::Vector3d(d[0], d[1], 1);
      const double to_plane = -board_from_tof.translation().z() / ray.z();
      const Eigen::Vector3d point = board_from_tof.translation() + to_plane * ray;
      const Eigen::Vector2d extent = board_.extent_m();
      const bool is_paper = point.x() > -kPaperMarginM && point.y() > -kPaperMarginM &&
                            point.x() < extent.x() + kPaperMarginM &&
                            point.y() < extent.y() + kPaperMarginM;
      const double range_m = (is_paper ? to_plane : kWallM) * range_per_depth(v, u);
      const double measured_m = (range_m - rig_.range_offset_m) / rig_.range_scale;
      tof.depth_m(v, u) =
          static_cast<float>(measured_m / range_per_depth(v, u) + noise.gaussian(kDepthNoiseM));
      tof.amplitude(v, u) = static_cast<float>(
          10000 * (light(v, u) / kPaper / (range_m * range_m) + noise.gaussian(kAmplitudeNoise)));
    }
  }
  return tof;
}

RigImages BoardScene::Render(const Pose& left_from_board, uint32_t seed) const {
  const Eigen::Isometry3d pose = ToTransform(left_from_board);
  const auto image = [&](CameraIndex camera, uint32_t camera_seed) {
    cv::Mat1f grey = Brightness(cameras_[camera], pose, 2);
    cv::GaussianBlur(grey, grey, {0, 0}, 0.7);
    cv::Mat1f noise(grey.size());
    cv::RNG(camera_seed).fill(noise, cv::RNG::NORMAL, 0, 3);
    cv::Mat bytes;
    cv::Mat(grey + noise).convertTo(bytes, CV_8U);
    return bytes;
  };
  return {.left = image(kLeft, 3 * seed + 1),
          .right = image(kRight, 3 * seed + 2),
          .tof = RenderTof(pose, 8, 3 * seed + 3)};
}

BoardView BoardScene::Project(const Pose& left_from_board, double noise_px, uint32_t seed) const {
  const Eigen::Isometry3d pose = ToTransform(left_from_board);
  cv::RNG noise(seed);
  BoardView view{.corners = {}, .tof = RenderTof(pose, 3, seed)};
  for (size_t i = 0; i < kCameraCount; ++i) {
    const Camera& camera = cameras_[i];
    for (int id = 0; id < board_.corner_count(); ++id) {
      const Eigen::Vector3d point = camera.left_from_camera.inverse() * (pose * board_.corner(id));
      const Eigen::Vector2d pixel = PixelOfDirection(camera.lens, point.hnormalized());
      if (!cv::Rect2d({0, 0}, cv::Size2d(camera.lens.size())).contains({pixel.x(), pixel.y()})) {
        continue;
      }
      view.corners[i].ids.push_back(id);
      view.corners[i].pixels.emplace_back(pixel.x() + noise.gaussian(noise_px),
                                          pixel.y() + noise.gaussian(noise_px));
    }
  }
  return view;
}

std::vector<Pose> BoardPoses(const Board& board, int count) {
  cv::RNG random(7);
  const Eigen::Vector2d middle = board.extent_m() / 2;
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    // A third of the poses near and in the middle, the others further off all around.
    const double depth_m = i % 3 == 0 ? random.uniform(0.65, 0.8) : random.uniform(0.9, 1.3);
    const double angle = 2.4 * i;  // radians: successive ones lie far apart, all of them everywhere
    const double reach = i % 3 == 0 ? random.uniform(0., 0.1) : random.uniform(0.2, 0.38);
    const Eigen::Vector3d centre(depth_m * reach * std::cos(angle) + 0.05,
                                 depth_m * reach * std::sin(angle) * 0.75 - 0.01, depth_m);
    Pose pose =
        Turned(random.uniform(-35., 35.), random.uniform(-35., 35.), random.uniform(-25., 25.), {});
    pose.translation_m = centre - pose.rotation * Eigen::Vector3d(middle.x(), middle.y(), 0);
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace sprout::calibrate
