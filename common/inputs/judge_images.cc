#include "common/inputs/judge_images.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>

namespace sprout::inputs {
namespace {

struct ImageRules {
  /// 12 bits in 16 without a shift use as many of 8.
  static constexpr double kFewLevels = 15;
  /// Share of the pixels; at most 0.33 were seen, the sky of a street (KITTI).
  static constexpr double kMaxClipped = 0.45;
  static constexpr double kWhite = 253;  ///< brighter ones are clipped; JPEG changes 255 a little
  /// Neighbours of a row differ by so many times what every second pixel does: 0.55 to 0.73 in
  /// images, also in strongly compressed ones, 1 where all is noise, 0.97 (pale) to 25 in raw
  /// mosaics.
  static constexpr double kMosaic = 1.1;
};

// Every fourth row, without a copy.
cv::Mat1b SomeRows(const cv::Mat1b& image) {
  return {(image.rows + 3) / 4, image.cols, const_cast<uint8_t*>(image.data), 4 * image.step[0]};
}

// Standard deviation of the grey values.
double ContrastOf(const cv::Mat1b& image) {
  cv::Scalar mean, sigma;
  cv::meanStdDev(SomeRows(image), mean, sigma);
  return sigma[0];
}

double ShareClipped(const cv::Mat1b& image) {
  const cv::Mat1b rows = SomeRows(image);
  return cv::countNonZero(rows > ImageRules::kWhite) / static_cast<double>(rows.total());
}

// How many times as much as every second pixel of a row neighbours differ: behind a colour filter
// every second pixel has another colour.
double MosaicOf(const cv::Mat1b& image) {
  const cv::Mat1b rows = SomeRows(image);
  if (rows.cols < 3) return 0;
  const cv::Mat1b first = rows.colRange(0, rows.cols - 2);
  const double next = cv::norm(first, rows.colRange(1, rows.cols - 1), cv::NORM_L1);
  const double second = cv::norm(first, rows.colRange(2, rows.cols), cv::NORM_L1);
  return next / std::max(1.0, second);
}

}  // namespace

Finding JudgeBits(const cv::Mat1b& left, const cv::Mat1b& right) {
  Finding finding{.question = Question::kBits, .sigma = 0};
  double of_left = 0;
  double of_right = 0;
  cv::minMaxLoc(SomeRows(left), nullptr, &of_left);
  cv::minMaxLoc(SomeRows(right), nullptr, &of_right);
  const double brightest = std::min(of_left, of_right);
  finding.value = 100 * brightest / 255;
  const double left_contrast = ContrastOf(left);
  const double right_contrast = ContrastOf(right);
  const double clipped = std::max(ShareClipped(left), ShareClipped(right));
  const double mosaic = std::max(MosaicOf(left), MosaicOf(right));
  if (brightest > ImageRules::kFewLevels &&
      std::min(left_contrast, right_contrast) < kBlankContrast) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "the {} image is blank: its grey values differ by {:.1f} from their mean; is the camera "
        "covered, or blinded?",
        left_contrast < right_contrast ? "left" : "right", std::min(left_contrast, right_contrast));
  } else if (brightest <= ImageRules::kFewLevels) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "the brightest grey values are {:.0f} and {:.0f} of 255: images of 10 or 12 bits in 16 "
        "have to be scaled, dark ones to be exposed longer",
        of_left, of_right);
  } else if (clipped > ImageRules::kMaxClipped) {
    finding.verdict = Verdict::kBad;
    finding.text =
        fmt::format("{:.0f} % of the pixels are white: expose both images shorter", 100 * clipped);
  } else if (mosaic > ImageRules::kMosaic) {
    finding.verdict = Verdict::kBad;
    finding.text = fmt::format(
        "neighbouring pixels differ {:.1f} times as much as every second ones: are these raw "
        "images behind a colour filter (Bayer)? demosaic them, or give their format its name, such "
        "as bayer_rggb8",
        mosaic);
  } else {
    finding.verdict = Verdict::kGood;
    finding.text =
        fmt::format("the brightest grey values are {:.0f} and {:.0f} of 255", of_left, of_right);
  }
  return finding;
}

}  // namespace sprout::inputs
