#include "common/scenes/stray_light.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/core/quantile.h"

namespace sprout::scenes {
namespace {

constexpr int kPatchPx = 8;            // side of a patch
constexpr int kNormalReachPx = 4;      // a plane is fitted to the pixels this far to all sides
constexpr double kSameSurface = 0.05;  // depths within this share belong to one surface
constexpr int kMinForPlane = 8;
constexpr double kMinCosine = 0.1;  // of the ray to the normal: surfaces seen from the side

// A piece of surface in the camera's frame.
struct Piece {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // towards the camera; 0: there is none
  double area_m2 = 0;
  double light = 0;  // mean
};

// The surface at every pixel.
class Pieces {
 public:
  explicit Pieces(const LitView& view) : view_(view) {
    pieces_.resize(view.depth_m.total());
    cv::parallel_for_({0, view.depth_m.rows}, [&](const cv::Range& rows) {
      for (int v = rows.start; v < rows.end; ++v) {
        for (int u = 0; u < view.depth_m.cols; ++u) Fill(u, v);
      }
    });
  }

  const Piece& at(int u, int v) const { return pieces_[Index(u, v)]; }

  // Larger pieces: of each square of pixels, those that belong to its middle surface.
  std::vector<Piece> Patches() const {
    std::vector<Piece> patches;
    for (int v = 0; v < view_.depth_m.rows; v += kPatchPx) {
      for (int u = 0; u < view_.depth_m.cols; u += kPatchPx) {
        const Piece patch =
            PatchOf(cv::Rect(u, v, kPatchPx, kPatchPx) & cv::Rect({0, 0}, view_.depth_m.size()));
        if (patch.light > 0) patches.push_back(patch);
      }
    }
    return patches;
  }

 private:
  size_t Index(int u, int v) const {
    return static_cast<size_t>(v) * static_cast<size_t>(view_.depth_m.cols) +
           static_cast<size_t>(u);
  }

  void Fill(int u, int v) {
    const double z = view_.depth_m(v, u);
    if (std::isnan(z)) return;
    const Eigen::Vector3d& direction = view_.directions[Index(u, v)];
    const Eigen::Vector3d normal = NormalAt(u, v, z);
    const double cosine = std::max(kMinCosine, -normal.dot(direction) / direction.norm());
    pieces_[Index(u, v)] = {
        .position_m = z * direction,
        .normal = normal,
        .area_m2 = z * z / (view_.focal_px * view_.focal_px * direction.norm() * cosine),
        .light = view_.light(v, u)};
  }

  // On the plane n·X = c, 1 / z = (n·direction) / c: least squares for n / c.
  Eigen::Vector3d NormalAt(int u, int v, double z) const {
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    int count = 0;
    const cv::Rect window = cv::Rect(u - kNormalReachPx, v - kNormalReachPx, 2 * kNormalReachPx + 1,
                                     2 * kNormalReachPx + 1) &
                            cv::Rect({0, 0}, view_.depth_m.size());
    for (int y = window.y; y < window.br().y; ++y) {
      for (int x = window.x; x < window.br().x; ++x) {
        const double depth_m = view_.depth_m(y, x);
        if (!(std::abs(depth_m - z) <= kSameSurface * z)) continue;
        const Eigen::Vector3d& direction = view_.directions[Index(x, y)];
        squares += direction * direction.transpose();
        right += direction / depth_m;
        ++count;
      }
    }
    const Eigen::Vector3d towards = -view_.directions[Index(u, v)].normalized();
    if (count < kMinForPlane) return towards;
    const Eigen::Matrix3d inverse = squares.inverse();
    const Eigen::Vector3d normal = inverse * right;
    if (!normal.allFinite() || !(normal.norm() > 0)) return towards;
    const Eigen::Vector3d unit = normal.normalized();
    return unit.dot(towards) > 0 ? unit : Eigen::Vector3d(-unit);
  }

  Piece PatchOf(const cv::Rect& square) const {
    std::vector<double> depths;
    for (int v = square.y; v < square.br().y; ++v) {
      for (int u = square.x; u < square.br().x; ++u) {
        if (!std::isnan(view_.depth_m(v, u))) depths.push_back(view_.depth_m(v, u));
      }
    }
    Piece patch;
    if (depths.empty()) return patch;
    const double middle_m = Median(depths);
    int count = 0;
    for (int v = square.y; v < square.br().y; ++v) {
      for (int u = square.x; u < square.br().x; ++u) {
        if (!(std::abs(view_.depth_m(v, u) - middle_m) <= kSameSurface * middle_m)) continue;
        const Piece& piece = at(u, v);
        patch.position_m += piece.position_m;
        patch.normal += piece.normal;
        patch.area_m2 += piece.area_m2;
        patch.light += piece.light;
        ++count;
      }
    }
    if (count == 0 || !(patch.normal.norm() > 0)) return {};
    patch.position_m /= count;
    patch.normal.normalize();
    patch.light /= count;
    return patch;
  }

  const LitView& view_;
  std::vector<Piece> pieces_;
};

double MeanAlbedo(const LitView& view) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < static_cast<int>(view.depth_m.total()); ++i) {
    if (std::isnan(view.depth_m(i))) continue;
    sum += view.light(i) * view.depth_m(i) * view.depth_m(i);
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

// Signal of the second bounce at a pixel, its phase relative to that of light that comes straight
// back; for an albedo of 1 everywhere.
Phasor SecondBounce(const Piece& pixel, const std::vector<Piece>& patches, double turn_m) {
  Phasor sum;
  const double range_m = pixel.position_m.norm();
  for (const Piece& patch : patches) {
    const Eigen::Vector3d way = patch.position_m - pixel.position_m;
    const double there = pixel.normal.dot(way);  // times their distance: cosines
    const double back = -patch.normal.dot(way);
    if (there <= 0 || back <= 0) continue;
    const double square = way.squaredNorm();
    const double form =
        there * back / square * patch.area_m2 / (std::numbers::pi * square + patch.area_m2);
    const double later_m = (patch.position_m.norm() + std::sqrt(square) - range_m) / 2;
    sum += form * patch.light * UnitPhasor(later_m / turn_m);
  }
  return sum;
}

}  // namespace

cv::Mat1d StrayLightErrorM(const LitView& view, const StrayLight& stray) {
  assert(view.directions.size() == view.depth_m.total());
  const double turn_m = stray.unambiguous_range_m;
  const cv::Size size = view.depth_m.size();
  const auto range_m = [&](int i) {
    return view.depth_m(i) * view.directions[static_cast<size_t>(i)].norm();
  };
  // Signal of each pixel, its phase relative to that of its own range.
  std::vector<Phasor> signals(view.depth_m.total());
  for (int i = 0; i < size.area(); ++i) {
    if (!std::isnan(view.depth_m(i))) signals[static_cast<size_t>(i)] = view.light(i);
  }
  const double albedo = MeanAlbedo(view);
  if (stray.multipath > 0 && albedo > 0) {
    const Pieces pieces(view);
    const std::vector<Piece> patches = pieces.Patches();
    cv::parallel_for_({0, size.height}, [&](const cv::Range& rows) {
      for (int v = rows.start; v < rows.end; ++v) {
        for (int u = 0; u < size.width; ++u) {
          const double z = view.depth_m(v, u);
          if (std::isnan(z)) continue;
          // The pixel's own albedo, and the patches' such that their mean is multipath.
          const double factor = view.light(v, u) * z * z * stray.multipath / albedo;
          signals[static_cast<size_t>(v * size.width + u)] +=
              factor * SecondBounce(pieces.at(u, v), patches, turn_m);
        }
      }
    });
  }
  Phasor mean;
  if (stray.scatter > 0) {
    for (int i = 0; i < size.area(); ++i) {
      if (std::isnan(view.depth_m(i))) continue;
      mean += signals[static_cast<size_t>(i)] * UnitPhasor(range_m(i) / turn_m) /
              static_cast<double>(size.area());
    }
  }
  cv::Mat1d error_m(size, 0.0);
  for (int i = 0; i < size.area(); ++i) {
    if (std::isnan(view.depth_m(i))) continue;
    Phasor signal = signals[static_cast<size_t>(i)];
    if (stray.scatter > 0) {
      signal += stray.scatter * (mean * UnitPhasor(-range_m(i) / turn_m) - signal);
    }
    error_m(i) = TurnsOf(signal) * turn_m;
  }
  return error_m;
}

Phasor UnitPhasor(double turns) {
  const double quarters = std::round(4 * turns);
  const double angle = 2 * std::numbers::pi * (turns - quarters / 4);  // −π/4 to π/4
  const double square = angle * angle;
  double sine = 0;  // Taylor's series by Horner's rule
  double cosine = 0;
  for (int k = 12; k > 0; k -= 2) {
    sine = (1 - sine) * square / (k * (k + 1));
    cosine = (1 - cosine) * square / (k * (k - 1));
  }
  sine = angle * (1 - sine);
  cosine = 1 - cosine;
  switch (static_cast<int64_t>(quarters) & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

double TurnsOf(const Phasor& phasor) {
  // std::abs() and std::arg() round differently from machine to machine.
  const double amplitude = std::sqrt(std::norm(phasor));
  if (!(amplitude > 0)) return 0;
  // Behind the imaginary axis: the angle to the negative real one.
  if (phasor.real() < 0) {
    const double turned = TurnsOf(-phasor);
    return turned > 0 ? turned - 0.5 : turned + 0.5;
  }
  double tangent = phasor.imag() / (amplitude + phasor.real());  // of half the angle, |x| <= 1
  double halves = 2;
  for (int i = 0; i < 2; ++i) {  // of an eighth: |x| <= 0.2
    tangent /= 1 + std::sqrt(1 + tangent * tangent);
    halves *= 2;
  }
  double angle = 0;  // arctangent by Horner's rule
  for (int k = 15; k > 1; k -= 2) angle = (1.0 / k - angle) * tangent * tangent;
  return halves * tangent * (1 - angle) / (2 * std::numbers::pi);
}

}  // namespace sprout::scenes
