#include "common/picture/picture.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "common/core/image.h"
#include "common/picture/text.h"

namespace sprout {
namespace {

const cv::Vec3b kPaper{255, 255, 255};
const cv::Vec3b kTitleInk{24, 24, 24};

/// Side of a square with as many pixels.
double MeanSide(cv::Size size) { return std::sqrt(static_cast<double>(size.area())); }

constexpr int kLegible = 9;  // height of letters, px

int CapHeight(cv::Size image) { return std::max(kLegible, cvRound(0.024 * MeanSide(image))); }

/// Height of the title's letters, so that it is not wider than the image where it can be.
int TitleCapHeight(const std::string& title, int max_width, int cap_height) {
  while (cap_height > kLegible && TextWidth(title, cap_height) > max_width) --cap_height;
  return cap_height;
}

/// Where the image begins: below the title, and below the units of a scale where the title is so
/// long that it would run into them.
int Top(cv::Size image, const std::string& title) {
  const int cap_height = CapHeight(image);
  return (TextWidth(title, TitleCapHeight(title, image.width, cap_height)) > image.width ? 5 : 3) *
         cap_height;
}

/// Puts an image on paper: margins all around and a title above.
/// @param room  space for a scale to the right of the image, and its height, px.
cv::Mat3b OnPaper(const cv::Mat3b& image, const std::string& title, cv::Size room) {
  const int cap_height = CapHeight(image.size());
  const int margin = cap_height;
  const int title_height = TitleCapHeight(title, image.cols, cap_height);
  const cv::Rect place({margin, Top(image.size(), title)}, image.size());
  const int width = std::max(image.cols + room.width, TextWidth(title, title_height));
  const int height = std::max(image.rows, room.height);
  cv::Mat3b picture(place.y + height + margin, place.x + width + margin, kPaper);
  image.copyTo(picture(place));
  DrawText(picture, title, {margin, 2 * cap_height}, title_height, kTitleInk);
  return picture;
}

/// Marks the end that a value lies beyond; NaN and infinities are no values.
void MarkClipped(ScaleContent& content, float value, const ValueRange& range) {
  if (!std::isfinite(value)) return;
  content.above = content.above || value > range.max;
  content.below = content.below || value < range.min;
}

void MarkClipped(ScaleContent& content, const cv::Mat1f& values, const ValueRange& range) {
  for (const float value : values) MarkClipped(content, value, range);
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
  return OnPaper(ToBgr(image), title, {});
}

cv::Mat3b ScaledPicture(const cv::Mat3b& image, const std::string& title,
                        const ScaleContent& content) {
  assert(!image.empty());
  const int cap_height = CapHeight(image.size());
  const int height = std::max(image.rows, ColorScale::MinHeight(cap_height));
  const ColorScale scale(content, height, cap_height);
  cv::Mat3b picture = OnPaper(image, title, {cap_height + scale.width(), height});
  const int top = Top(image.size(), title);
  scale.Draw(picture, {2 * cap_height + image.cols, top}, top - cap_height);
  return picture;
}

ScaleContent DisparityScale(const ValueRange& range_px, const RectifiedPair* pair) {
  ScaleContent content{.axes = {{range_px, "px"}}};
  if (pair == nullptr) return content;
  // The part of the range that has a depth is the whole of it, but for strange calibrations.
  const std::optional<ValueRange> in_front = InFront(*pair, range_px);
  if (in_front && *in_front == range_px) {
    content.axes.push_back({DepthRange(*pair, range_px), "m", /*is_depth=*/true});
  }
  return content;
}

cv::Mat3b DisparityPicture(const DisparityImage& disparity, const ValueRange& range_px,
                           const std::string& title, const RectifiedPair* pair) {
  assert(!disparity.empty());
  const cv::Mat1f px = ToPx(disparity);
  ScaleContent content = DisparityScale(range_px, pair);
  MarkClipped(content, px, range_px);
  return ScaledPicture(Colorize(px, range_px), title, content);
}

cv::Mat3b SigmaPicture(const PriorMap& prior, const std::string& title) {
  assert(!prior.empty());
  constexpr ValueRange kRangePx{.min = 0, .max = 4};
  cv::Mat1f sigma_px;
  prior.sigma.convertTo(sigma_px, CV_32F, 1.0 / kSigmaCountsPerPx);
  sigma_px.setTo(std::numeric_limits<float>::quiet_NaN(),
                 prior.disparity.counts() == DisparityImage::kInvalid);
  ScaleContent content{.axes = {{kRangePx, "px"}}};
  MarkClipped(content, sigma_px, kRangePx);
  return ScaledPicture(Colorize(sigma_px, kRangePx), title, content);
}

cv::Mat3b ConfidencePicture(const cv::Mat1b& confidence, const std::string& title) {
  return ScaledPicture(ToBgr(confidence), title, {.axes = {{{0, 1}, ""}}, .grey = true});
}

cv::Mat3b ColorizeErrors(const cv::Mat1f& error_px) {
  cv::Mat3b colors(error_px.size());
  std::transform(error_px.begin(), error_px.end(), colors.begin(), [](float error) {
    const double shown = error > kLargestErrorPx ? kLargestErrorPx : error;  // NaN stays
    return ColorOf(shown, {0, kLargestErrorPx});
  });
  return colors;
}

cv::Mat3b ErrorPicture(const cv::Mat1f& error_px, const std::string& title) {
  ScaleContent content{.axes = {{{0, kLargestErrorPx}, "px"}}};
  for (const float error : error_px) content.above = content.above || error > kLargestErrorPx;
  return ScaledPicture(ColorizeErrors(error_px), title, content);
}

cv::Mat3b DepthPicture(const TofImage& tof, cv::Size camera_size, const ValueRange& range_m,
                       const std::string& title) {
  assert(!camera_size.empty());
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat1f depth_m =
      tof.depth_m.empty() ? cv::Mat1f(camera_size, kNone) : ReturnsOnly(tof.depth_m);
  const int factor = std::max(1, cvRound(MeanSide(camera_size) / MeanSide(depth_m.size())));
  const cv::Mat3b small = ColorizeDepth(depth_m, range_m);
  cv::Mat3b large;
  cv::resize(small, large, small.size() * factor, 0, 0, cv::INTER_NEAREST);
  ScaleContent content{.axes = {{range_m, "m", /*is_depth=*/true}}};
  MarkClipped(content, depth_m, range_m);
  std::swap(content.above, content.below);  // near is up
  return ScaledPicture(large, title, content);
}

cv::Mat3b SeedPicture(const cv::Mat& left, std::span<const Seed> seeds, const ValueRange& range_px,
                      const std::string& title, const RectifiedPair* pair) {
  assert(!left.empty());
  constexpr double kDarkening = 0.45;  // the image stays recognisable, the dots stand out
  constexpr int kFractionBits = 4;     // OpenCV draws in fixed point
  cv::Mat3b image = ToBgr(ToGrey(left) * kDarkening);
  const auto fixed = [](double px) { return cvRound(px * (1 << kFractionBits)); };
  const int radius = fixed(DotRadius(left.size(), seeds.size()));
  ScaleContent content = DisparityScale(range_px, pair);
  for (const Seed& seed : seeds) {
    const bool inside = seed.u >= 0 && seed.u <= static_cast<float>(left.cols - 1) && seed.v >= 0 &&
                        seed.v <= static_cast<float>(left.rows - 1);
    if (!inside) continue;
    MarkClipped(content, seed.disparity(), range_px);
    cv::circle(image, {fixed(seed.u), fixed(seed.v)}, radius,
               cv::Scalar(ColorOf(seed.disparity(), range_px)), cv::FILLED, cv::LINE_AA,
               kFractionBits);
  }
  return ScaledPicture(image, title, content);
}

}  // namespace sprout
