#include "services/tools/calibrate/rig_model.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <optional>
#include <string>

#include "common/core/quantile.h"
#include "common/geometry/lens.h"

namespace sprout::calibrate {
namespace {

// Coarse, since the refinement moves the result by more.
const cv::TermCriteria kFirstSteps(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 1e-5);

using BoardPoses = std::vector<std::optional<Eigen::Isometry3d>>;  // camera from board, each view

struct SingleCamera {
  Lens lens;
  BoardPoses camera_from_board;
};

Eigen::Isometry3d ToTransform(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  cv::Mat1d matrix;
  cv::Rodrigues(rotation_vector, matrix);
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
  cv::cv2eigen(matrix, rotation);
  cv::cv2eigen(translation, position);
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = rotation;
  transform.translation() = position;
  return transform;
}

Result<SingleCamera> CalibrateAlone(const Board& board, CameraIndex camera, cv::Size size,
                                    const std::vector<BoardView>& views) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  std::vector<size_t> used;
  for (size_t i = 0; i < views.size(); ++i) {
    const BoardCorners& corners = views[i].corners[camera];
    if (corners.size() < kMinCorners || IsOneLine(board, corners)) continue;
    used.push_back(i);
    points.emplace_back();
    pixels.emplace_back();
    for (size_t j = 0; j < corners.ids.size(); ++j) {
      points.back().emplace_back(
          cv::Point3d(board.corner(corners.ids[j]).x(), board.corner(corners.ids[j]).y(), 0));
      pixels.back().emplace_back(corners.pixels[j]);
    }
  }
  if (used.size() < kMinViews) {
    return Fail("the " + std::string(kCameraNames[camera]) + " camera sees " +
                std::to_string(kMinCorners) + " corners of the board in " +
                std::to_string(used.size()) + " views: " + std::to_string(kMinViews) +
                " are needed at least, 20 are good" +
                (camera == kTof ? "; there a square has to be 12 px wide: come nearer, or print "
                                  "larger squares"
                                : ""));
  }
  cv::Mat matrix;
  cv::Mat1d distortion;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  // Few corners cannot tell the coefficients apart; the refinement can, with what others see.
  const int flags = camera == kTof
                        ? cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST
                        : cv::CALIB_FIX_K3;
  try {
    cv::calibrateCamera(points, pixels, size, matrix, distortion, rotations, translations, flags,
                        kFirstSteps);
  } catch (const cv::Exception&) {  // a singular system
    return Fail("the views of the " + std::string(kCameraNames[camera]) +
                " camera do not determine its lens: tilt the board in different directions");
  }
  SingleCamera result{
      .lens = {size.width, size.height, matrix.at<double>(0, 0), matrix.at<double>(1, 1),
               matrix.at<double>(0, 2), matrix.at<double>(1, 2)},
      .camera_from_board = BoardPoses(views.size())};
  std::copy_n(distortion.begin(), result.lens.distortion.size(), result.lens.distortion.begin());
  for (size_t i = 0; i < used.size(); ++i) {
    result.camera_from_board[used[i]] = ToTransform(rotations[i], translations[i]);
  }
  return result;
}

// Pose from the views that both cameras see: the rotation that is nearest to all of them, and the
// median of the positions.
std::optional<Eigen::Isometry3d> Relative(const BoardPoses& left, const BoardPoses& other) {
  std::vector<Eigen::Quaterniond> rotations;
  std::array<std::vector<double>, 3> positions;
  for (size_t i = 0; i < left.size(); ++i) {
    if (!left[i] || !other[i]) continue;
    const Eigen::Isometry3d left_from_other = *left[i] * other[i]->inverse();
    rotations.emplace_back(left_from_other.linear());
    for (size_t axis = 0; axis < positions.size(); ++axis) {
      positions[axis].push_back(left_from_other.translation()[static_cast<Eigen::Index>(axis)]);
    }
  }
  if (rotations.empty()) return std::nullopt;
  const auto away = [&](const Eigen::Quaterniond& rotation) {
    double sum = 0;
    for (const Eigen::Quaterniond& each : rotations) sum += rotation.angularDistance(each);
    return sum;
  };
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = std::ranges::min_element(rotations, {}, away)->toRotationMatrix();
  transform.translation() =
      Eigen::Vector3d(Median(positions[0]), Median(positions[1]), Median(positions[2]));
  return transform;
}

}  // namespace

bool IsOneLine(const Board& board, const BoardCorners& corners) {
  const auto same = [&](auto coordinate) {
    return std::ranges::all_of(corners.ids, [&](int id) {
      return coordinate(board.corner(id)) == coordinate(board.corner(corners.ids.front()));
    });
  };
  return same([](const Eigen::Vector3d& p) { return p.x(); }) ||
         same([](const Eigen::Vector3d& p) { return p.y(); });
}

Eigen::Isometry3d ToTransform(const Pose& pose) {
  return Eigen::Translation3d(pose.translation_m) * pose.rotation;
}

Pose ToPose(const Eigen::Isometry3d& transform) {
  return {.rotation = Eigen::Quaterniond(transform.linear()).normalized(),
          .translation_m = transform.translation()};
}

Eigen::Vector2d PixelOfCorner(const RigModel& model, CameraIndex camera, size_t view,
                              const Eigen::Vector3d& corner) {
  const Eigen::Vector3d point_in_left = ToTransform(model.left_from_board[view]) * corner;
  const Eigen::Vector3d point =
      ToTransform(model.left_from_camera[camera]).inverse() * point_in_left;
  return PixelOfDirection(model.lenses[camera], point.hnormalized());
}

Result<RigModel> InitialModel(const Board& board, const std::array<cv::Size, kCameraCount>& sizes,
                              const std::vector<BoardView>& views) {
  RigModel model;
  std::array<SingleCamera, kCameraCount> cameras;
  for (const CameraIndex camera : {kLeft, kRight, kTof}) {
    if (sizes[camera].empty()) continue;
    Result<SingleCamera> alone = CalibrateAlone(board, camera, sizes[camera], views);
    if (!alone) return tl::unexpected(alone.error());
    cameras[camera] = std::move(*alone);
    model.lenses[camera] = cameras[camera].lens;
    if (camera == kLeft) continue;
    const auto left_from_camera =
        Relative(cameras[kLeft].camera_from_board, cameras[camera].camera_from_board);
    if (!left_from_camera) {
      return Fail("left and " + std::string(kCameraNames[camera]) +
                  " camera never see the board at the same time");
    }
    model.left_from_camera[camera] = ToPose(*left_from_camera);
  }
  for (size_t i = 0; i < views.size(); ++i) {
    Eigen::Isometry3d left_from_board = Eigen::Isometry3d::Identity();
    for (const CameraIndex camera : {kTof, kRight, kLeft}) {  // the best one last
      if (cameras[camera].camera_from_board.empty() || !cameras[camera].camera_from_board[i]) {
        continue;
      }
      left_from_board =
          ToTransform(model.left_from_camera[camera]) * *cameras[camera].camera_from_board[i];
    }
    model.left_from_board.push_back(ToPose(left_from_board));
  }
  return model;
}

}  // namespace sprout::calibrate
