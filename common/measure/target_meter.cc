#include "common/measure/target_meter.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/core/image.h"
#include "common/core/prior_map.h"
#include "common/core/quantile.h"
#include "common/measure/edge_width.h"

namespace sprout {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kMmPerM = 1000;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kPlaneNumbers = 3;

double Percent(double part, double whole) { return 100 * part / whole; }

std::string RectText(const cv::Rect& rect) {
  return fmt::format("{},{},{},{}", rect.x, rect.y, rect.width, rect.height);
}

Result<cv::Rect> Within(const char* what, const cv::Rect& rect, cv::Size size) {
  const auto inside = [](int begin, int length, int end) {
    return begin >= 0 && length >= TargetMeter::kMinSide && length <= end && begin <= end - length;
  };
  if (inside(rect.x, rect.width, size.width) && inside(rect.y, rect.height, size.height)) {
    return rect;
  }
  return Fail(fmt::format(
      "{} {}: allowed is a rectangle LEFT,TOP,WIDTH,HEIGHT of at least {} px a side inside {} px",
      what, RectText(rect), TargetMeter::kMinSide, SizeText(size)));
}

// The median of the standard deviations of n normal values each is below that of all: the median of
// χ² with k = n − 1 degrees is k (1 − 2/(9k))³ (Wilson and Hilferty 1931), 4 % at 10 frames.
double MedianDeviationShare(int64_t n) {
  const double root = 1 - 2 / (9 * static_cast<double>(n - 1));
  return std::sqrt(root * root * root);
}

// Sums over the frames of one pixel after the other of a row.
struct PixelSums {
  int64_t n = 0;
  double sum = 0;
  double squares = 0;  // of the differences from the mean

  double Mean() const { return sum / static_cast<double>(n); }
  double Deviation() const { return std::sqrt(squares / static_cast<double>(n - 1)); }
};

}  // namespace

Result<TargetMeter> TargetMeter::For(const TargetSettings& settings, const RectifiedPair& pair,
                                     cv::Size size) {
  if (pair.size() != size) {
    return Fail(fmt::format("the calibration is of {} px, the map of {}: allowed is one size",
                            SizeText(pair.size()), SizeText(size)));
  }
  const cv::Rect middle(size.width / 4, size.height / 4, size.width / 2, size.height / 2);
  const auto region = Within("region", settings.region.value_or(middle), size);
  if (!region) return tl::unexpected(region.error());
  if (settings.edge) {
    const auto edge = Within("edge", *settings.edge, size);
    if (!edge) return tl::unexpected(edge.error());
  }
  return TargetMeter(settings, pair, *region);
}

TargetMeter::TargetMeter(TargetSettings settings, const RectifiedPair& pair, cv::Rect region)
    : settings_(std::move(settings)), pair_(pair), region_(region), edge_(settings_.edge) {}

void TargetMeter::Add(const cv::Mat1f& disparity_px, const cv::Mat1b& sigma) {
  Measured frame;
  cv::Mat1f disparity = disparity_px(region_).clone();
  frame.depth_m.create(region_.size());
  for (int v = 0; v < disparity.rows; ++v) {
    for (int u = 0; u < disparity.cols; ++u) {
      const double depth_m = pair_.DepthFromDisparity(disparity(v, u));
      const bool valid = std::isfinite(depth_m) && depth_m > 0;
      if (!valid) disparity(v, u) = kNone;
      frame.depth_m(v, u) = valid ? static_cast<float>(depth_m) : kNone;
      frame.valid += valid ? 1 : 0;
    }
  }
  frame.fit = FitPlane(disparity, region_.tl());
  if (frame.fit) AddResiduals(disparity, sigma.empty() ? cv::Mat1b() : sigma(region_), frame);
  if (edge_) frame.edge_px = MeasureEdge(disparity_px(*edge_)).px;
  frames_.push_back(std::move(frame));
  if (frames_.size() > settings_.count) frames_.pop_front();
}

void TargetMeter::AddResiduals(const cv::Mat1f& disparity_px, const cv::Mat1b& sigma,
                               Measured& frame) const {
  frame.has_sigma = !sigma.empty();
  for (int v = 0; v < disparity_px.rows; ++v) {
    for (int u = 0; u < disparity_px.cols; ++u) {
      if (std::isnan(disparity_px(v, u))) continue;
      const double plane_px = frame.fit->plane.At(region_.x + u, region_.y + v);
      const double off_px = disparity_px(v, u) - plane_px;
      const bool inlier = std::abs(off_px) <= frame.fit->limit_px;
      if (inlier) {
        const double off_m = frame.depth_m(v, u) - pair_.DepthFromDisparity(plane_px);
        frame.sum_squares_m2 += off_m * off_m;     // (V4)
        frame.sum_squares_px2 += off_px * off_px;  // (V5)
      }
      if (!frame.has_sigma) continue;
      const double sigma_px = SigmaToPx(sigma(v, u));
      if (inlier) frame.sum_sigma_px2 += sigma_px * sigma_px;
      frame.within_1 += std::abs(off_px) <= sigma_px ? 1 : 0;
      frame.within_2 += std::abs(off_px) <= 2 * sigma_px ? 1 : 0;
    }
  }
}

std::optional<DisparityPlane> TargetMeter::MeanPlane() const {
  DisparityPlane mean;
  double planes = 0;
  for (const Measured& frame : frames_) {
    if (!frame.fit) continue;
    mean.du += frame.fit->plane.du;
    mean.dv += frame.fit->plane.dv;
    mean.d0 += frame.fit->plane.d0;
    ++planes;
  }
  if (planes == 0) return std::nullopt;
  return DisparityPlane{.du = mean.du / planes, .dv = mean.dv / planes, .d0 = mean.d0 / planes};
}

TargetQuality TargetMeter::Quality() const {
  TargetQuality quality{.frames = static_cast<int64_t>(frames_.size())};
  if (frames_.empty()) return quality;
  SetPlaneFigures(quality);
  SetSpatialFigures(quality);
  SetTemporalFigures(quality);
  std::vector<float> edge_px;
  for (const Measured& frame : frames_) {
    edge_px.insert(edge_px.end(), frame.edge_px.begin(), frame.edge_px.end());
  }
  if (!edge_px.empty()) quality.edge_width_px = Median(edge_px);  // (V8)
  return quality;
}

void TargetMeter::SetPlaneFigures(TargetQuality& quality) const {
  const auto plane = MeanPlane();
  const auto in_space = plane ? PlaneInSpace(*plane, pair_) : std::nullopt;
  if (!in_space) return;
  const Eigen::Vector3d normal = in_space->normal();
  const double middle_px =
      plane->At(region_.x + (region_.width - 1) / 2.0, region_.y + (region_.height - 1) / 2.0);
  quality.distance_m = pair_.DepthFromDisparity(middle_px);
  quality.plane_distance_m = -in_space->offset();
  quality.tilt_horizontal_deg = kDegrees * std::atan(-normal.x() / normal.z());
  quality.tilt_vertical_deg = kDegrees * std::atan(-normal.y() / normal.z());
  if (!settings_.distance_m) return;
  const double error_m = *quality.plane_distance_m - *settings_.distance_m;
  quality.z_accuracy_percent = Percent(error_m, *settings_.distance_m);  // (V3)
}

void TargetMeter::SetSpatialFigures(TargetQuality& quality) const {
  Measured sum;
  double degrees = 0, inliers = 0, outliers = 0, with_sigma = 0, inliers_with_sigma = 0;
  double squares_px2_with_sigma = 0, valid = 0;
  for (const Measured& frame : frames_) {
    valid += static_cast<double>(frame.valid);
    quality.without_plane += frame.fit ? 0 : 1;
    if (!frame.fit) continue;
    degrees += static_cast<double>(frame.fit->inliers - kPlaneNumbers);
    inliers += static_cast<double>(frame.fit->inliers);
    outliers += static_cast<double>(frame.valid - frame.fit->inliers);
    sum.sum_squares_m2 += frame.sum_squares_m2;
    sum.sum_squares_px2 += frame.sum_squares_px2;
    if (!frame.has_sigma) continue;
    with_sigma += static_cast<double>(frame.valid);
    inliers_with_sigma += static_cast<double>(frame.fit->inliers);
    squares_px2_with_sigma += frame.sum_squares_px2;
    sum.sum_sigma_px2 += frame.sum_sigma_px2;
    sum.within_1 += frame.within_1;
    sum.within_2 += frame.within_2;
  }
  const double pixels = static_cast<double>(region_.area()) * static_cast<double>(frames_.size());
  quality.fill_rate_percent = Percent(valid, pixels);  // (V1)
  if (degrees == 0) return;
  quality.plane_rms_mm = kMmPerM * std::sqrt(sum.sum_squares_m2 / degrees);
  if (quality.distance_m) {
    quality.plane_rms_percent = Percent(*quality.plane_rms_mm / kMmPerM, *quality.distance_m);
  }
  quality.subpixel_rms_px = std::sqrt(sum.sum_squares_px2 / degrees);
  quality.outliers_percent = Percent(outliers, inliers + outliers);
  if (with_sigma == 0) return;
  // (V9)
  quality.sigma_claimed_px = std::sqrt(sum.sum_sigma_px2 / inliers_with_sigma);
  if (squares_px2_with_sigma > 0) {
    quality.sigma_ratio = std::sqrt(sum.sum_sigma_px2 / squares_px2_with_sigma);
  }
  quality.within_1_sigma_percent = Percent(static_cast<double>(sum.within_1), with_sigma);
  quality.within_2_sigma_percent = Percent(static_cast<double>(sum.within_2), with_sigma);
}

TargetMeter::PixelNoise TargetMeter::NoiseOfPixels() const {
  PixelNoise noise;
  noise.deviation_m = cv::Mat1f(region_.size(), kNone);
  const auto frames = static_cast<int64_t>(frames_.size());
  std::vector<PixelSums> row(static_cast<size_t>(region_.width));
  for (int v = 0; v < region_.height; ++v) {
    std::fill(row.begin(), row.end(), PixelSums());
    const auto for_each_depth = [&](const auto& act) {
      for (const Measured& frame : frames_) {
        for (int u = 0; u < region_.width; ++u) {
          const float depth_m = frame.depth_m(v, u);
          if (!std::isnan(depth_m)) act(row[static_cast<size_t>(u)], depth_m);
        }
      }
    };
    for_each_depth([](PixelSums& pixel, float depth_m) {
      ++pixel.n;
      pixel.sum += depth_m;
    });
    for_each_depth([](PixelSums& pixel, float depth_m) {
      const double off_m = depth_m - pixel.Mean();
      pixel.squares += off_m * off_m;
    });
    for (int u = 0; u < region_.width; ++u) {
      const PixelSums& pixel = row[static_cast<size_t>(u)];
      noise.never += pixel.n == 0 ? 1 : 0;
      noise.blinking += pixel.n > 0 && pixel.n < frames ? 1 : 0;
      if (pixel.n < 2) continue;
      const double deviation_m = pixel.Deviation();
      if (pixel.n == frames) {
        noise.deviation_m(v, u) = static_cast<float>(deviation_m);
      } else {
        noise.blinking_m.push_back(static_cast<float>(deviation_m / MedianDeviationShare(pixel.n)));
      }
    }
  }
  return noise;
}

void TargetMeter::SetTemporalFigures(TargetQuality& quality) const {
  PixelNoise noise = NoiseOfPixels();
  const auto frames = static_cast<int64_t>(frames_.size());
  quality.never_valid_percent = Percent(static_cast<double>(noise.never), region_.area());
  if (frames < 2) return;
  quality.blinking_percent = Percent(static_cast<double>(noise.blinking), region_.area());
  if (!noise.blinking_m.empty()) quality.blinking_noise_mm = kMmPerM * Median(noise.blinking_m);
  std::vector<float> steady_m;
  for (const float deviation_m : noise.deviation_m) {
    if (!std::isnan(deviation_m)) steady_m.push_back(deviation_m);
  }
  if (steady_m.empty()) return;
  // (V6), (V7)
  quality.temporal_noise_mm = kMmPerM * Median(steady_m) / MedianDeviationShare(frames);
  quality.temporal_noise_95_mm = kMmPerM * Quantile(steady_m, 0.95);
  if (quality.distance_m) {
    quality.temporal_noise_percent =
        Percent(*quality.temporal_noise_mm / kMmPerM, *quality.distance_m);
  }
}

TargetMaps TargetMeter::Maps() const {
  TargetMaps maps{
      .residual_mm = cv::Mat1f(region_.size(), kNone), .noise_mm = {}, .plane = MeanPlane()};
  NoiseOfPixels().deviation_m.convertTo(maps.noise_mm, CV_32F, kMmPerM);
  for (int v = 0; v < region_.height; ++v) {
    for (int u = 0; u < region_.width; ++u) {
      PixelSums pixel;
      for (const Measured& frame : frames_) {
        if (!frame.fit || std::isnan(frame.depth_m(v, u))) continue;
        const double plane_px = frame.fit->plane.At(region_.x + u, region_.y + v);
        ++pixel.n;
        pixel.sum += frame.depth_m(v, u) - pair_.DepthFromDisparity(plane_px);
      }
      if (pixel.n > 0) maps.residual_mm(v, u) = static_cast<float>(kMmPerM * pixel.Mean());
    }
  }
  return maps;
}

}  // namespace sprout
