#include "common/picture/cloud_view.h"

#include <Eigen/Geometry>
#include <cassert>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/geometry/projection.h"
#include "common/picture/color_map.h"

namespace sprout {
namespace {

constexpr double kYaw = 0.35;     // rad to the right
constexpr double kPitch = -0.20;  // rad, negative: up

// Drawn at a third of the size: neighbouring points then touch, also where the new view
// stretches a surface.
constexpr int kReduction = 3;

struct ColoredPoint {
  Eigen::Vector3d in_left;
  cv::Vec3b color;
};

std::vector<ColoredPoint> Points(const RectifiedPair& pair, const DisparityImage& disparity,
                                 const cv::Mat& left) {
  const cv::Mat3b bgr = ToBgr(left);
  std::vector<ColoredPoint> points;
  points.reserve(disparity.counts().total());
  for (int v = 0; v < disparity.height(); ++v) {
    for (int u = 0; u < disparity.width(); ++u) {
      if (!disparity.IsValid(u, v)) continue;
      const Eigen::Vector3d point = PointAt(pair, disparity, u, v);
      if (point.z() > 0 && point.allFinite()) points.push_back({point, bgr(v, u)});
    }
  }
  return points;
}

double MedianDepth(const std::vector<ColoredPoint>& points) {
  std::vector<double> depths;
  for (const ColoredPoint& point : points) depths.push_back(point.in_left.z());
  return Median(depths);
}

}  // namespace

cv::Mat3b CloudView(const RectifiedPair& pair, const DisparityImage& disparity,
                    const cv::Mat& left) {
  assert(disparity.size() == left.size());
  const cv::Size size((left.cols + kReduction - 1) / kReduction,
                      (left.rows + kReduction - 1) / kReduction);
  cv::Mat3b view(size, kNoValueColor);
  const std::vector<ColoredPoint> points = Points(pair, disparity, left);
  if (points.empty()) return view;

  // The camera turns around a point in the middle of the scene and steps back a little.
  const Eigen::Vector3d center(0, 0, MedianDepth(points));
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(kPitch, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(kYaw, Eigen::Vector3d::UnitY()))
                                       .toRotationMatrix();
  const Eigen::Vector3d new_center = 1.15 * center;
  const double focal = pair.focal_px / kReduction;
  cv::Mat1d nearest(size, std::numeric_limits<double>::infinity());
  for (const ColoredPoint& point : points) {
    const Eigen::Vector3d seen = rotation * (point.in_left - center) + new_center;
    if (seen.z() <= 0) continue;
    const double u = focal * seen.x() / seen.z() + size.width / 2.0;
    const double v = focal * seen.y() / seen.z() + size.height / 2.0;
    if (!(u >= 0 && u < size.width && v >= 0 && v < size.height)) continue;
    const cv::Point pixel(static_cast<int>(u), static_cast<int>(v));
    if (seen.z() >= nearest(pixel)) continue;
    nearest(pixel) = seen.z();
    view(pixel) = point.color;
  }
  cv::Mat3b enlarged;
  cv::resize(view, enlarged, left.size(), 0, 0, cv::INTER_CUBIC);
  return enlarged;
}

}  // namespace sprout
