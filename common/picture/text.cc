#include "common/picture/text.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace sprout {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
// OpenCV places strokes on whole pixels, which makes small letters ragged: write larger, then
// shrink.
constexpr int kOversampling = 4;

struct Pen {
  double scale;
  int thickness;
};

/// The pen for letters kOversampling times as high as asked for.
Pen PenFor(int cap_height) {
  const int large_height = kOversampling * cap_height;
  const int thickness = std::max(1, cvRound(0.13 * large_height));
  return {cv::getFontScaleFromHeight(kFont, large_height, thickness), thickness};
}

}  // namespace

int TextWidth(const std::string& text, int cap_height) {
  const Pen pen = PenFor(cap_height);
  int below_baseline = 0;
  const cv::Size large = cv::getTextSize(text, kFont, pen.scale, pen.thickness, &below_baseline);
  return (large.width + kOversampling - 1) / kOversampling;
}

void DrawText(cv::Mat3b& picture, const std::string& text, cv::Point baseline_left, int cap_height,
              const cv::Vec3b& color) {
  const int margin = cap_height;  // room for strokes and descenders
  const cv::Rect box(baseline_left.x - margin, baseline_left.y - 2 * margin,
                     TextWidth(text, cap_height) + 2 * margin, 3 * margin);
  const Pen pen = PenFor(cap_height);
  cv::Mat1b large(box.size() * kOversampling, 0);
  cv::putText(large, text, cv::Point(margin, 2 * margin) * kOversampling, kFont, pen.scale, 255,
              pen.thickness, cv::LINE_AA);
  cv::Mat1b coverage;
  cv::resize(large, coverage, box.size(), 0, 0, cv::INTER_AREA);

  const cv::Rect visible = box & cv::Rect({}, picture.size());
  for (int y = visible.y; y < visible.y + visible.height; ++y) {
    for (int x = visible.x; x < visible.x + visible.width; ++x) {
      const int ink = coverage(y - box.y, x - box.x);
      for (int channel = 0; channel < 3; ++channel) {
        uchar& value = picture(y, x)[channel];
        value = static_cast<uchar>((ink * color[channel] + (255 - ink) * value + 127) / 255);
      }
    }
  }
}

}  // namespace sprout
