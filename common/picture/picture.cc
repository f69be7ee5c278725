#include "common/picture/picture.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/core/image.h"
#include "common/picture/color_scale.h"
#include "common/picture/text.h"

namespace sprout {
namespace {

const cv::Vec3b kPaper{255, 255, 255};
const cv::Vec3b kTitleInk{24, 24, 24};

/// Side of a square with as many pixels.
double MeanSide(cv::Size size) { return std::sqrt(static_cast<double>(size.area())); }

int CapHeight(cv::Size image) { return std::max(9, cvRound(0.024 * MeanSide(image))); }

/// Height of the title's letters, so that it is not wider than the image.
int TitleCapHeight(const std::string& title, int max_width, int cap_height) {
  while (cap_height > 1 && TextWidth(title, cap_height) > max_width) --cap_height;
  return cap_height;
}

/// Puts an image on paper: margins all around and a title above.
/// @param room_right  space between the image and the right margin, px.
cv::Mat3b OnPaper(const cv::Mat3b& image, const std::string& title, int room_right) {
  const int cap_height = CapHeight(image.size());
  const int margin = cap_height;
  const cv::Rect place({margin, 3 * cap_height}, image.size());
  cv::Mat3b picture(place.br().y + margin, place.br().x + room_right + margin, kPaper);
  image.copyTo(picture(place));
  DrawText(picture, title, {margin, 2 * cap_height}, TitleCapHeight(title, image.cols, cap_height),
           kTitleInk);
  return picture;
}

cv::Mat3b OnPaperWithScale(const cv::Mat3b& image, const std::string& title,
                           const ValueRange& range, const std::string& unit) {
  const int cap_height = CapHeight(image.size());
  const ColorScale scale(range, unit, image.rows, cap_height);
  cv::Mat3b picture = OnPaper(image, title, cap_height + scale.width());
  scale.Draw(picture, {2 * cap_height + image.cols, 3 * cap_height}, 2 * cap_height);
  return picture;
}

/// Dots cover up to a third of the image, but are never too small to see nor larger than needed.
double DotRadius(cv::Size image, size_t seeds) {
  const double spacing =
      MeanSide(image) / std::sqrt(static_cast<double>(std::max<size_t>(1, seeds)));
  return std::clamp(0.3 * spacing, 1.0, std::max(2.5, 0.006 * MeanSide(image)));
}

}  // namespace

cv::Mat3b CameraPicture(const cv::Mat& image, const std::string& title) {
  assert(!image.empty());
  return OnPaper(ToBgr(image), title, 0);
}

cv::Mat3b DisparityPicture(const DisparityImage& disparity, const ValueRange& range_px,
                           const std::string& title) {
  assert(!disparity.empty());
  return OnPaperWithScale(Colorize(ToPx(disparity), range_px), title, range_px, "px");
}

cv::Mat3b SigmaPicture(const PriorMap& prior, const std::string& title) {
  assert(!prior.empty());
  constexpr ValueRange kRangePx{.min = 0, .max = 4};
  cv::Mat1f sigma_px(prior.size());
  for (int v = 0; v < sigma_px.rows; ++v) {
    for (int u = 0; u < sigma_px.cols; ++u) {
      sigma_px(v, u) = prior.disparity.IsValid(u, v) ? SigmaToPx(prior.sigma(v, u))
                                                     : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return OnPaperWithScale(Colorize(sigma_px, kRangePx), title, kRangePx, "px");
}

cv::Mat3b DepthPicture(const TofImage& tof, cv::Size camera_size, const ValueRange& range_m,
                       const std::string& title) {
  assert(!camera_size.empty());
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat1f depth_m =
      tof.depth_m.empty() ? cv::Mat1f(camera_size, kNone) : ReturnsOnly(tof.depth_m);
  const int factor = std::max(1, cvRound(MeanSide(camera_size) / MeanSide(depth_m.size())));
  const cv::Mat3b small = Colorize(depth_m, range_m);
  cv::Mat3b large;
  cv::resize(small, large, small.size() * factor, 0, 0, cv::INTER_NEAREST);
  return OnPaperWithScale(large, title, range_m, "m");
}

cv::Mat3b SeedPicture(const cv::Mat& left, std::span<const Seed> seeds, const ValueRange& range_px,
                      const std::string& title) {
  assert(!left.empty());
  constexpr double kDarkening = 0.45;  // the image stays recognisable, the dots stand out
  constexpr int kFractionBits = 4;     // OpenCV draws in fixed point
  cv::Mat3b image = ToBgr(ToGrey(left) * kDarkening);
  const auto fixed = [](double px) { return cvRound(px * (1 << kFractionBits)); };
  const int radius = fixed(DotRadius(left.size(), seeds.size()));
  for (const Seed& seed : seeds) {
    const bool inside = seed.u >= 0 && seed.u <= static_cast<float>(left.cols - 1) && seed.v >= 0 &&
                        seed.v <= static_cast<float>(left.rows - 1);
    if (!inside) continue;
    cv::circle(image, {fixed(seed.u), fixed(seed.v)}, radius,
               cv::Scalar(ColorOf(seed.disparity(), range_px)), cv::FILLED, cv::LINE_AA,
               kFractionBits);
  }
  return OnPaperWithScale(image, title, range_px, "px");
}

}  // namespace sprout
