#include "services/tools/calibrate/quality.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/core/quantile.h"
#include "common/geometry/lens.h"
#include "common/rig/rectifier.h"

namespace sprout::calibrate {
namespace {

constexpr double kOutlierSigmas = 4;

// What a good calibration keeps. Of 2 px of vertical error Sprout loses less than a percent of its
// pixels, of 3 px of ToF points that land elsewhere some three (services/refine/NOTES.md): the
// limits stay well below.
constexpr double kMaxRmsPx = 0.5;
constexpr double kMaxOutlierShare = 0.15;     // small windows on slants have some
constexpr double kMaxEpipolarPx = 0.5;        // of 95 % of the corners
constexpr double kMaxFocalDeviation = 0.001;  // of the focal length of left and right
constexpr double kMaxTofLandingPx = 0.5;
constexpr double kMaxRangeRmsM = 0.02;
constexpr double kMaxRangeSigmaM = 0.005;

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  return OrderStatistic(values,
                        static_cast<size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

CameraQuality QualityOfCamera(const RefinedModel& refined, CameraIndex camera,
                              const std::vector<BoardView>& views) {
  CameraQuality quality{.deviation = refined.deviations[camera],
                        .residuals = refined.residuals[camera]};
  quality.views = static_cast<int>(std::ranges::count_if(
      views, [&](const BoardView& view) { return view.corners[camera].size() > 0; }));
  const cv::Size size = refined.model.lenses[camera].size();
  const double limit_px = kOutlierSigmas * refined.corner_sigma_px[camera];
  double sum = 0;
  for (const CornerResidual& residual : quality.residuals) {
    const double error = cv::norm(residual.error);
    if (error > limit_px) {
      ++quality.outliers;
      continue;
    }
    sum += error * error;
    ++quality.corners_in_ninth[NinthOf(residual.pixel, size)];
  }
  const auto inliers = static_cast<double>(quality.residuals.size()) - quality.outliers;
  if (inliers > 0) quality.rms_px = std::sqrt(sum / inliers);
  return quality;
}

void AddEpipolar(const RawRig& rig, const std::vector<BoardView>& views,
                 CalibrationQuality& quality) {
  const Rectifier rectifier(rig);
  quality.views = rectifier.views();
  std::vector<double> errors;
  for (const BoardView& view : views) {
    const BoardCorners& left = view.corners[kLeft];
    const BoardCorners& right = view.corners[kRight];
    for (size_t i = 0; i < left.ids.size(); ++i) {
      const auto found = std::ranges::lower_bound(right.ids, left.ids[i]);
      if (found == right.ids.end() || *found != left.ids[i]) continue;
      const auto j = static_cast<size_t>(found - right.ids.begin());
      errors.push_back(std::abs(rectifier.LeftPixel(left.pixels[i]).y -
                                rectifier.RightPixel(right.pixels[j]).y));
    }
  }
  quality.epipolar_median_px = Percentile(errors, 0.5);
  quality.epipolar_95_px = Percentile(errors, 0.95);
}

// Pixel of the left image, not rectified, at which a ToF point lands.
Eigen::Vector2d Landing(const Eigen::Vector<double, kLandingNumbers>& numbers, cv::Size left_size,
                        cv::Size tof_size, const Eigen::Vector2d& tof_pixel, double depth_m) {
  const auto lens = [](const auto& n, cv::Size size) {
    return Lens{size.width, size.height, n[0], n[1], n[2], n[3], {n[4], n[5], n[6], n[7], n[8]}};
  };
  const Eigen::Vector<double, kLensNumbers> left = numbers.head<kLensNumbers>();
  const Eigen::Vector<double, kLensNumbers> tof = numbers.segment<kLensNumbers>(kLensNumbers);
  const Eigen::Vector3d turn = numbers.segment<3>(2 * kLensNumbers);
  const Eigen::Vector3d point =
      depth_m * DirectionOfPixel(lens(tof, tof_size), tof_pixel).homogeneous();
  const Eigen::Vector3d in_left =
      Eigen::AngleAxisd(turn.norm(), turn.normalized()) * point + numbers.tail<3>();
  return PixelOfDirection(lens(left, left_size), in_left.hnormalized());
}

// Σ = J C Jᵀ over a grid of ToF pixels at a depth; root of the mean variance of both coordinates.
double LandingSigmaPx(const RefinedModel& refined, double depth_m) {
  constexpr int kGrid = 5;        // pixels a side
  constexpr double kStep = 1e-6;  // of the numerical derivatives: relative where numbers are large
  const Lens& left = refined.model.lenses[kLeft];
  const Lens& tof = refined.model.lenses[kTof];
  const Pose& pose = refined.model.left_from_camera[kTof];
  const Eigen::AngleAxisd turn(pose.rotation);
  Eigen::Vector<double, kLandingNumbers> numbers;
  const auto& k = left.distortion;
  const auto& m = tof.distortion;
  numbers << left.fx, left.fy, left.cx, left.cy, k[0], k[1], k[2], k[3], k[4], tof.fx, tof.fy,
      tof.cx, tof.cy, m[0], m[1], m[2], m[3], m[4], turn.angle() * turn.axis(), pose.translation_m;
  double variance = 0;
  for (int row = 0; row < kGrid; ++row) {
    for (int column = 0; column < kGrid; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * tof.width / kGrid - 0.5,
                                  (row + 0.5) * tof.height / kGrid - 0.5);
      Eigen::Matrix<double, 2, kLandingNumbers> jacobian;
      for (Eigen::Index i = 0; i < kLandingNumbers; ++i) {
        const auto at = [&](double step) {
          auto moved = numbers;
          moved[i] += step;
          return Landing(moved, left.size(), tof.size(), pixel, depth_m);
        };
        const double step = kStep * std::max(1.0, std::abs(numbers[i]));
        jacobian.col(i) = (at(step) - at(-step)) / (2 * step);
      }
      variance += (jacobian * refined.landing_covariance * jacobian.transpose()).trace() / 2;
    }
  }
  return std::sqrt(variance / (kGrid * kGrid));
}

void AddRanges(const RefinedModel& refined, const RawRig& rig, CalibrationQuality& quality) {
  double sum = 0;
  int inliers = 0;
  std::vector<double> ranges;
  for (const RangeResidual& residual : refined.range_residuals) {
    ranges.push_back(residual.range_m);
    if (std::abs(residual.error_m) > kOutlierSigmas * refined.range_sigma_m) continue;
    sum += residual.error_m * residual.error_m;
    ++inliers;
  }
  quality.ranges = static_cast<int>(ranges.size());
  if (inliers == 0) return;
  quality.range_rms_m = std::sqrt(sum / inliers);
  quality.nearest_m = Percentile(ranges, 0.02);
  quality.farthest_m = Percentile(ranges, 0.98);
  for (const double range_m : {quality.nearest_m, quality.farthest_m}) {
    const Eigen::Vector2d by((range_m - rig.range_offset_m) / rig.range_scale, 1);
    quality.range_sigma_m =
        std::max(quality.range_sigma_m, std::sqrt(by.dot(refined.range_covariance * by)));
  }
  for (const double range_m : {quality.nearest_m, quality.farthest_m}) {
    quality.tof_landing_px = std::max(quality.tof_landing_px, LandingSigmaPx(refined, range_m));
  }
}

class Verdict {
 public:
  Verdict(const CalibrationQuality& quality, const RawRig& rig) : quality_(quality), rig_(rig) {}

  std::vector<std::string> Reasons() {
    Camera(kLeft, rig_.left);
    Camera(kRight, rig_.right);
    if (quality_.epipolar_95_px > kMaxEpipolarPx) {
      Add("rows of the rectified pair differ by up to {:.2f} px (95 %; {} are allowed): are the "
          "cameras synchronised, and did the board stand still?",
          quality_.epipolar_95_px, kMaxEpipolarPx);
    }
    if (rig_.tof.width > 0) {
      Camera(kTof, rig_.tof);
      Tof();
    }
    return reasons_;
  }

 private:
  template <typename... Values>
  void Add(fmt::format_string<Values...> text, Values&&... values) {
    reasons_.push_back(fmt::format(text, std::forward<Values>(values)...));
  }

  void Camera(CameraIndex index, const Lens& lens) {
    const CameraQuality& camera = quality_.cameras[index];
    const char* name = kCameraNames[index];
    if (camera.views < kMinViewsOfCamera) {
      Add("the {} camera sees the board in {} views only: show it in {} or more", name,
          camera.views, kMinViewsOfCamera);
    }
    for (std::string& line : MissingNinths(name, camera.corners_in_ninth)) {
      reasons_.push_back(std::move(line));
    }
    if (camera.rms_px > kMaxRmsPx) {
      Add("corners of the {} image are {:.2f} px from where the calibration has them ({} are "
          "allowed): is the board flat, and was it held still?",
          name, camera.rms_px, kMaxRmsPx);
    }
    const auto corners = static_cast<double>(camera.residuals.size());
    if (camera.outliers > kMaxOutlierShare * corners) {
      Add("{} of {} corners of the {} image are far from where the calibration has them: was the "
          "board moved between the cameras' exposures, or are there two boards?",
          camera.outliers, camera.residuals.size(), name);
    }
    if (index == kTof) return;
    const double deviation =
        std::max(camera.deviation.lens[0] / lens.fx, camera.deviation.lens[1] / lens.fy);
    if (deviation > kMaxFocalDeviation) {
      Add("the {} focal length is known to {:.2f} % only ({} % are allowed): tilt the board more, "
          "in different directions",
          name, 100 * deviation, 100 * kMaxFocalDeviation);
    }
  }

  void Tof() {
    if (quality_.ranges == 0) {
      Add("no range of the board was measured: the range's bias and the ToF camera's rotation are "
          "open");
      return;
    }
    if (quality_.tof_landing_px > kMaxTofLandingPx) {
      Add("the position of ToF points in the left image is known to {:.2f} px only ({} are "
          "allowed): show the board to the ToF camera in more views, also near",
          quality_.tof_landing_px, kMaxTofLandingPx);
    }
    if (quality_.range_rms_m > kMaxRangeRmsM) {
      Add("ranges on the board scatter by {:.0f} mm ({:.0f} are allowed): is the board shiny, or "
          "the exposure wrong?",
          1000 * quality_.range_rms_m, 1000 * kMaxRangeRmsM);
    }
    if (quality_.range_sigma_m > kMaxRangeSigmaM) {
      Add("the bias of the ranges is known to {:.1f} mm only ({:.0f} are allowed): show the board "
          "in more views",
          1000 * quality_.range_sigma_m, 1000 * kMaxRangeSigmaM);
    }
    if (quality_.farthest_m < kMinRangeRatio * quality_.nearest_m) {
      Add("all boards are {:.2f} to {:.2f} m from the ToF camera: show it nearer and farther too, "
          "over the ranges that you need",
          quality_.nearest_m, quality_.farthest_m);
    }
  }

  const CalibrationQuality& quality_;
  const RawRig& rig_;
  std::vector<std::string> reasons_;
};

}  // namespace

CalibrationQuality QualityOf(const RefinedModel& refined, const RawRig& rig,
                             const std::vector<BoardView>& views) {
  CalibrationQuality quality;
  for (const CameraIndex camera : {kLeft, kRight, kTof}) {
    if (refined.model.lenses[camera].size().empty()) continue;
    quality.cameras[camera] = QualityOfCamera(refined, camera, views);
  }
  AddEpipolar(rig, views, quality);
  AddRanges(refined, rig, quality);
  quality.reasons = Verdict(quality, rig).Reasons();
  return quality;
}

}  // namespace sprout::calibrate
