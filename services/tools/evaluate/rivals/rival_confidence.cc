#include "services/tools/evaluate/rivals/rival_confidence.h"

#include <cassert>
#include <cmath>
#include <opencv2/ximgproc/disparity_filter.hpp>

namespace sprout::evaluate {
namespace {

constexpr double kOpenCvCounts = 16;  // of a pixel of disparity

cv::Mat Flipped(const cv::Mat& image) {
  cv::Mat flipped;
  cv::flip(image, flipped, 1);
  return flipped;
}

// As OpenCV's matchers give it; where there is none, below all disparities.
cv::Mat1s ToOpenCv(const cv::Mat1f& map_px, double sign) {
  constexpr int16_t kNone = -(1 << 14);
  cv::Mat1s counts(map_px.size(), kNone);
  for (int v = 0; v < map_px.rows; ++v) {
    for (int u = 0; u < map_px.cols; ++u) {
      if (std::isnan(map_px(v, u))) continue;
      counts(v, u) = static_cast<int16_t>(std::lround(sign * kOpenCvCounts * double{map_px(v, u)}));
    }
  }
  return counts;
}

}  // namespace

Frame Mirrored(const Frame& frame) {
  Frame mirrored;
  mirrored.id = frame.id;
  mirrored.left = Flipped(frame.right);
  mirrored.right = Flipped(frame.left);
  mirrored.tof = frame.tof;
  mirrored.rig = frame.rig;
  RectifiedPair& pair = mirrored.rig->pair;
  const double last = frame.left.cols - 1;
  pair.cx = last - frame.rig->pair.cx_right;
  pair.cx_right = last - frame.rig->pair.cx;
  mirrored.seeds = *frame.seeds;
  for (Seed& seed : mirrored.seeds->seeds) {
    const float u = seed.u;
    seed.u = static_cast<float>(last) - seed.u_right;
    seed.u_right = static_cast<float>(last) - u;
  }
  mirrored.left_seeds = SeedSet();
  return mirrored;
}

cv::Mat1b LeftRightConfidence(const cv::Mat1f& map_px, const cv::Mat1f& mirrored_px) {
  assert(map_px.size() == mirrored_px.size());
  cv::Mat1b confidence(map_px.size(), uint8_t{0});
  for (int v = 0; v < map_px.rows; ++v) {
    for (int u = 0; u < map_px.cols; ++u) {
      const float disparity = map_px(v, u);
      if (std::isnan(disparity)) continue;
      const long right = u - std::lround(disparity);
      if (right < 0 || right >= map_px.cols) continue;
      const float other = mirrored_px(v, map_px.cols - 1 - static_cast<int>(right));
      if (std::isnan(other)) continue;
      confidence(v, u) = static_cast<uint8_t>(
          std::lround(255 / (1 + std::abs(double{disparity} - double{other}))));
    }
  }
  return confidence;
}

cv::Mat1b WlsConfidence(const cv::Mat& left, const cv::Mat1f& map_px,
                        const cv::Mat1f& mirrored_px) {
  const cv::Mat right_px = Flipped(mirrored_px);
  const auto filter = cv::ximgproc::createDisparityWLSFilterGeneric(/*use_confidence=*/true);
  cv::Mat1s filtered;
  filter->filter(ToOpenCv(map_px, 1), left, filtered, ToOpenCv(right_px, -1),
                 cv::Rect({}, map_px.size()));
  cv::Mat1b confidence;
  filter->getConfidenceMap().convertTo(confidence, CV_8U);
  confidence.setTo(0, map_px != map_px);
  return confidence;
}

}  // namespace sprout::evaluate
