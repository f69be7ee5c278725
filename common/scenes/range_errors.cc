#include "common/scenes/range_errors.h"

#include <limits>
#include <optional>
#include <utility>

#include "common/geometry/lens.h"
#include "common/scenes/solid_texture.h"
#include "common/scenes/stray_light.h"

namespace sprout::scenes {
namespace {

constexpr int kBumps = 6;
constexpr double kBumpSigma = 0.09;  // standard deviation, a share of the image's height
// (1 − q²/R²)³, which ends at R = 2.59 σ, is half as high where exp(−q²/2σ²) is, and needs no libm.
constexpr double kBumpReach = 2.59 * kBumpSigma;
constexpr double kBorder =
    0.1;  // no bump's middle is this share of the image's side from its border

// A uniform number from 0 to 1.
double Uniform(uint64_t key) { return static_cast<double>(Scramble(key) >> 11) * 0x1p-53; }

// Sum of the bumps at every pixel, 1 = their height.
cv::Mat1d Bumps(cv::Size size, uint32_t seed) {
  cv::Mat1d sum(size, 0.0);
  const double reach = kBumpReach * size.height;
  const uint64_t key = Scramble(Scramble(seed) ^ 0xb0b5);
  for (uint64_t i = 0; i < kBumps; ++i) {
    const auto middle = [&](uint64_t axis, int side) {
      return (kBorder + (1 - 2 * kBorder) * Uniform(key + 2 * i + axis)) * (side - 1);
    };
    const double u = middle(0, size.width);
    const double v = middle(1, size.height);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const double rest = 1 - ((x - u) * (x - u) + (y - v) * (y - v)) / (reach * reach);
        if (rest > 0) sum(y, x) += rest * rest * rest;
      }
    }
  }
  return sum;
}

class DatasetWithErrors : public Dataset {
 public:
  DatasetWithErrors(std::unique_ptr<Dataset> dataset, const RangeErrorsConfig& config,
                    uint32_t seed)
      : dataset_(std::move(dataset)), config_(config) {
    const TofCamera& tof = dataset_->rig().tof;
    if (tof.width == 0) return;
    range_per_depth_ = RangePerDepth(tof.lens());
    bumps_ = Bumps(range_per_depth_.size(), seed);
  }

  const Rig& rig() const override { return dataset_->rig(); }
  std::optional<int64_t> frame_count() const override { return dataset_->frame_count(); }

  DatasetFrame Get(int64_t index) override {
    DatasetFrame frame = dataset_->Get(index);
    cv::Mat1f& depth_m = frame.tof.depth_m;
    for (int i = 0; i < static_cast<int>(depth_m.total()); ++i) {
      const double wrong_m = Bumped(i, OffAlongRay(i, depth_m(i)));
      depth_m(i) = wrong_m > 0 ? static_cast<float>(config_.unit() * wrong_m)
                               : std::numeric_limits<float>::quiet_NaN();
    }
    if (config_.mirrored()) {
      for (cv::Mat* image :
           {static_cast<cv::Mat*>(&depth_m), static_cast<cv::Mat*>(&frame.tof.amplitude)}) {
        if (!image->empty()) cv::flip(*image, *image, 1);
      }
    }
    return frame;
  }

 private:
  double OffAlongRay(int pixel, double depth_m) const {
    const double range_m = depth_m * range_per_depth_(pixel);
    double off_m = config_.offset_m();
    if (config_.wiggle_m() > 0) {
      off_m += config_.wiggle_m() * UnitPhasor(range_m / config_.wiggle_period_m()).imag();
    }
    return depth_m + off_m / range_per_depth_(pixel);
  }

  double Bumped(int pixel, double depth_m) const {
    const RectifiedPair& pair = rig().pair;
    const double less = config_.bumps_px() * bumps_(pixel) / (pair.focal_px * pair.baseline_m);
    return 1 / (1 / depth_m - less);  // disparity is f·b / z, but for a constant
  }

  std::unique_ptr<Dataset> dataset_;
  RangeErrorsConfig config_;
  cv::Mat1d range_per_depth_;
  cv::Mat1d bumps_;
};

}  // namespace

bool HasErrorsInMetres(const CaptureConfig& config) {
  const RangeErrorsConfig& errors = config.range_errors();
  const Sr4000Config& sr4000 = config.sr4000();
  return errors.offset_m() != 0 || errors.wiggle_m() > 0 ||
         (config.tof() == "sr4000" &&
          (sr4000.amplitude_error_m() != 0 || sr4000.multipath() > 0 || sr4000.scatter() > 0));
}

std::unique_ptr<Dataset> WithRangeErrors(std::unique_ptr<Dataset> dataset,
                                         const RangeErrorsConfig& config, uint32_t seed) {
  RequireInRange(config, "capture.range_errors");
  const bool is_right = config.offset_m() == 0 && config.wiggle_m() == 0 &&
                        config.bumps_px() == 0 && config.unit() == 1 && !config.mirrored();
  if (is_right) return dataset;
  return std::make_unique<DatasetWithErrors>(std::move(dataset), config, seed);
}

Eigen::Isometry3d TurnedScanner(const Eigen::Isometry3d& left_from_scanner,
                                const RangeErrorsConfig& config) {
  const auto rotation = [](double degrees, const Eigen::Vector3d& axis) {
    const Phasor half = UnitPhasor(degrees / 720);
    const Eigen::Vector3d part = half.imag() * axis;
    return Eigen::Quaterniond(half.real(), part.x(), part.y(), part.z());
  };
  if (config.yaw_degrees() == 0 && config.pitch_degrees() == 0) return left_from_scanner;
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() = (rotation(config.pitch_degrees(), Eigen::Vector3d::UnitY()) *
                   rotation(config.yaw_degrees(), Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  return left_from_scanner * turn;
}

}  // namespace sprout::scenes
