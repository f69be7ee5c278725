#include "services/tools/calibrate/rig_refinement.h"

#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/geometry/lens.h"
#include "services/tools/calibrate/rig_residuals.h"
#include "services/tools/calibrate/robust_solver.h"

namespace sprout::calibrate {
namespace {

using LensBlock = std::array<double, kLensNumbers>;
using PoseBlock = std::array<double, kPoseNumbers>;

// First standard deviation of corners: before the first solution they are some pixels from where
// the model has them.
constexpr double kFirstSigmaPx = 2;
// No corner finder is better; keeps an artificial input without noise from a division by 0.
constexpr double kMinSigmaPx = 0.002;
// First and smallest standard deviation of ranges, as above.
constexpr double kFirstSigmaM = 0.05;
constexpr double kMinSigmaM = 1e-5;
// Solutions until the sigmas stand still, to a percent.
constexpr int kRounds = 4;

LensBlock ToBlock(const Lens& lens) {
  LensBlock block = {lens.fx, lens.fy, lens.cx, lens.cy};
  std::ranges::copy(lens.distortion, block.begin() + 4);
  return block;
}

Lens ToLens(const LensBlock& block, cv::Size size) {
  return {size.width,
          size.height,
          block[0],
          block[1],
          block[2],
          block[3],
          {block[4], block[5], block[6], block[7], block[8]}};
}

PoseBlock ToBlock(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  PoseBlock block;
  ceres::QuaternionToAngleAxis(wxyz, block.data());
  for (int i = 0; i < 3; ++i) block[static_cast<size_t>(3 + i)] = pose.translation_m[i];
  return block;
}

Pose ToPose(const PoseBlock& block) {
  double wxyz[4];
  ceres::AngleAxisToQuaternion(block.data(), wxyz);
  return {.rotation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]),
          .translation_m = {block[3], block[4], block[5]}};
}

class Refinement {
 public:
  Refinement(const Board& board, const std::vector<BoardView>& views,
             const std::vector<RangePoint>& ranges, const RigModel& first)
      : board_(board),
        views_(views),
        ranges_(ranges),
        model_(first),
        bias_{first.range_scale, first.range_offset_m} {
    for (size_t camera = 0; camera < kCameraCount; ++camera) {
      lenses_[camera] = ToBlock(first.lenses[camera]);
      cameras_[camera] = ToBlock(first.left_from_camera[camera]);
    }
    for (const Pose& pose : first.left_from_board) boards_.push_back(ToBlock(pose));
    sigmas_.fill(kFirstSigmaPx);
  }

  Result<RefinedModel> Run() {
    RefinedModel refined;
    for (int round = 0; round < kRounds; ++round) {
      ceres::Problem problem;
      Build(problem);
      if (!FindMinimum(problem)) return Undetermined();
      Update();
      refined.residuals = Residuals();
      refined.range_residuals = RangeResiduals();
      if (round + 1 == kRounds) {
        if (!AddDeviations(problem, refined)) return Undetermined();
      } else {
        for (size_t camera = 0; camera < kCameraCount; ++camera) {
          sigmas_[camera] = CornerSigma(refined.residuals[camera]);
        }
        range_sigma_m_ = RangeSigma(refined.range_residuals);
      }
    }
    refined.model = model_;
    refined.corner_sigma_px = sigmas_;
    refined.range_sigma_m = range_sigma_m_;
    return refined;
  }

 private:
  bool IsThere(size_t camera) const { return !model_.lenses[camera].size().empty(); }

  void Build(ceres::Problem& problem) {
    for (size_t view = 0; view < views_.size(); ++view) {
      for (size_t camera = 0; camera < kCameraCount; ++camera) {
        const BoardCorners& corners = views_[view].corners[camera];
        for (size_t i = 0; i < corners.ids.size(); ++i) {
          AddRobust<2, kLensNumbers, kPoseNumbers, kPoseNumbers>(
              problem,
              CornerError{board_.corner(corners.ids[i]), corners.pixels[i], sigmas_[camera]},
              lenses_[camera].data(), cameras_[camera].data(), boards_[view].data());
        }
      }
    }
    for (size_t camera = 0; camera < kCameraCount; ++camera) {
      if (IsThere(camera)) AddPlain<1, kLensNumbers>(problem, K3Prior(), lenses_[camera].data());
    }
    problem.SetParameterBlockConstant(cameras_[kLeft].data());
    for (const RangePoint& point : ranges_) {
      AddRobust<1, kLensNumbers, kPoseNumbers, kPoseNumbers, 2>(
          problem, RangeError{point, range_sigma_m_}, lenses_[kTof].data(), cameras_[kTof].data(),
          boards_[point.view].data(), bias_.data());
    }
  }

  bool FindMinimum(ceres::Problem& problem) {
    std::vector<double*> boards;
    for (PoseBlock& board : boards_) boards.push_back(board.data());
    std::vector<double*> others;
    for (size_t camera = 0; camera < kCameraCount; ++camera) {
      if (!IsThere(camera)) continue;
      others.push_back(lenses_[camera].data());
      others.push_back(cameras_[camera].data());
    }
    if (!ranges_.empty()) others.push_back(bias_.data());
    return Solve(problem, boards, others, {.iterations = 100, .tolerance = 1e-10});
  }

  void Update() {
    for (size_t camera = 0; camera < kCameraCount; ++camera) {
      model_.lenses[camera] = ToLens(lenses_[camera], model_.lenses[camera].size());
      if (camera != kLeft) model_.left_from_camera[camera] = ToPose(cameras_[camera]);
    }
    for (size_t view = 0; view < boards_.size(); ++view) {
      model_.left_from_board[view] = ToPose(boards_[view]);
    }
    model_.range_scale = bias_[0];
    model_.range_offset_m = bias_[1];
  }

  std::array<std::vector<CornerResidual>, kCameraCount> Residuals() const {
    std::array<std::vector<CornerResidual>, kCameraCount> residuals;
    for (size_t camera = 0; camera < kCameraCount; ++camera) {
      for (size_t view = 0; view < views_.size(); ++view) {
        const BoardCorners& corners = views_[view].corners[camera];
        for (size_t i = 0; i < corners.ids.size(); ++i) {
          const Eigen::Vector2d there = PixelOfCorner(model_, static_cast<CameraIndex>(camera),
                                                      view, board_.corner(corners.ids[i]));
          residuals[camera].push_back(
              {.view = view,
               .pixel = corners.pixels[i],
               .error = corners.pixels[i] - cv::Point2d(there.x(), there.y())});
        }
      }
    }
    return residuals;
  }

  std::vector<RangeResidual> RangeResiduals() const {
    std::vector<RangeResidual> residuals;
    for (const RangePoint& point : ranges_) {
      const RangeError error{point, 1};
      RangeResidual residual;
      error(lenses_[kTof].data(), cameras_[kTof].data(), boards_[point.view].data(), bias_.data(),
            &residual.error_m);
      const Eigen::Vector2d direction =
          DirectionOfPixel(model_.lenses[kTof], {point.pixel.x, point.pixel.y});
      residual.range_m =
          bias_[0] * point.depth_m * direction.homogeneous().norm() + bias_[1] - residual.error_m;
      residuals.push_back(residual);
    }
    return residuals;
  }

  static double Sigma(std::vector<double> errors, double least, double without) {
    return errors.empty() ? without : std::max(least, RobustSigma(std::move(errors)));
  }

  static double CornerSigma(const std::vector<CornerResidual>& residuals) {
    std::vector<double> errors;
    for (const CornerResidual& residual : residuals) {
      errors.push_back(residual.error.x);
      errors.push_back(residual.error.y);
    }
    return Sigma(std::move(errors), kMinSigmaPx, kFirstSigmaPx);
  }

  static double RangeSigma(const std::vector<RangeResidual>& residuals) {
    std::vector<double> errors;
    for (const RangeResidual& residual : residuals) errors.push_back(residual.error_m);
    return Sigma(std::move(errors), kMinSigmaM, kFirstSigmaM);
  }

  bool AddDeviations(ceres::Problem& problem, RefinedModel& refined) {
    ceres::Covariance covariance(CovarianceOptions(ceres::EIGEN_SPARSE));
    std::vector<std::pair<const double*, const double*>> blocks;
    for (size_t camera = 0; camera < kCameraCount; ++camera) {
      if (!IsThere(camera)) continue;
      blocks.emplace_back(lenses_[camera].data(), lenses_[camera].data());
      if (camera != kLeft) blocks.emplace_back(cameras_[camera].data(), cameras_[camera].data());
    }
    const auto landing = LandingBlocks();
    for (size_t row = 0; row < landing.size(); ++row) {
      for (size_t column = 0; column < row; ++column) {
        blocks.emplace_back(landing[column].first, landing[row].first);
      }
    }
    if (!ranges_.empty()) blocks.emplace_back(bias_.data(), bias_.data());
    if (!covariance.Compute(blocks, &problem)) return false;
    for (size_t camera = 0; camera < kCameraCount; ++camera) {
      if (!IsThere(camera)) continue;
      CameraDeviation& deviation = refined.deviations[camera];
      deviation.lens = DeviationOf(covariance, lenses_[camera]);
      if (camera != kLeft) deviation.pose = DeviationOf(covariance, cameras_[camera]);
    }
    if (!ranges_.empty()) {
      covariance.GetCovarianceBlock(bias_.data(), bias_.data(), refined.range_covariance.data());
    }
    if (!landing.empty()) refined.landing_covariance = Joint(covariance, landing);
    return true;
  }

  using Block = std::pair<const double*, Eigen::Index>;  // and its size

  std::vector<Block> LandingBlocks() const {
    if (!IsThere(kTof)) return {};
    return {{lenses_[kLeft].data(), kLensNumbers},
            {lenses_[kTof].data(), kLensNumbers},
            {cameras_[kTof].data(), kPoseNumbers}};
  }

  static LandingCovariance Joint(const ceres::Covariance& covariance,
                                 const std::vector<Block>& blocks) {
    LandingCovariance joint;
    Eigen::Index top = 0;
    for (const auto& [row, rows] : blocks) {
      Eigen::Index left = 0;
      for (const auto& [column, columns] : blocks) {
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> part(rows, columns);
        covariance.GetCovarianceBlock(row, column, part.data());
        joint.block(top, left, rows, columns) = part;
        left += columns;
      }
      top += rows;
    }
    return joint;
  }

  template <size_t kSize>
  static std::array<double, kSize> DeviationOf(const ceres::Covariance& covariance,
                                               const std::array<double, kSize>& block) {
    std::array<double, kSize * kSize> matrix;
    covariance.GetCovarianceBlock(block.data(), block.data(), matrix.data());
    std::array<double, kSize> deviations;
    for (size_t i = 0; i < kSize; ++i) deviations[i] = std::sqrt(matrix[i * kSize + i]);
    return deviations;
  }

  static tl::unexpected<Error> Undetermined() {
    return Fail(
        "the views do not determine the calibration: show the board near and far, in all "
        "parts of the images, and tilted in different directions");
  }

  const Board& board_;
  const std::vector<BoardView>& views_;
  const std::vector<RangePoint>& ranges_;
  RigModel model_;
  std::array<LensBlock, kCameraCount> lenses_;
  std::array<PoseBlock, kCameraCount> cameras_;
  std::vector<PoseBlock> boards_;
  std::array<double, 2> bias_;  // scale and offset
  std::array<double, kCameraCount> sigmas_;
  double range_sigma_m_ = kFirstSigmaM;
};

}  // namespace

Result<RefinedModel> RefineModel(const Board& board, const std::vector<BoardView>& views,
                                 const std::vector<RangePoint>& ranges, const RigModel& model) {
  return Refinement(board, views, ranges, model).Run();
}

}  // namespace sprout::calibrate
