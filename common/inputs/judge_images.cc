#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/inputs/judges.h"

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
  /// The same down a column: 0.55 to 0.76, with noise up to 1; of fields of two moments that lie
  /// 10 px aside 1.37 to 3.6.
  static constexpr double kFields = 1.1;
  /// A row that differs from the next one so many times as much as around it may begin a tear.
  static constexpr double kTornFromRest = 2;
  static constexpr double kMinStep = 1;  ///< grey levels, the least difference around it
  static constexpr int kRowsAround = 8;
  static constexpr size_t kTornTried = 8;  ///< rows
  static constexpr int kMinTornPx = 3;     ///< less: slanted edges
  static constexpr int kMaxTornPart = 6;   ///< this part of the width
  /// It differs from the next row moved by so many times of that: 0.9 and more in images, 0.1 to
  /// 0.45 in most torn ones.
  static constexpr double kTornFits = 0.5;
  /// Patterns fit at several places, a tear at one: nowhere else less than so many times, and there
  /// in each part of the width no more.
  static constexpr double kTornElsewhere = 0.7;
  static constexpr int kParts = 4;
  static constexpr int kEnoughColumns = 300;  ///< of a row, for its mean difference
  /// How much neighbours differ in one image over how much in the other, on a level four times
  /// coarser; in good pairs at most 1.28.
  static constexpr double kSharper = 1.5;
  /// And by how much more that is on a level twice as fine; in good pairs at most 1.12, of images
  /// blurred by 4 px and more 1.16 to 1.85.
  static constexpr double kSharperFiner = 1.25;
  static constexpr double kMinSharp = 0.5;  ///< grey levels; less is noise
};

// Every fourth row from this one on, without a copy.
cv::Mat1b SomeRows(const cv::Mat1b& image, int first = 0) {
  return {(image.rows - first + 3) / 4, image.cols, const_cast<uint8_t*>(image.ptr(first)),
          4 * image.step[0]};
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

// The same for rows: in an interlaced image every second row is of another moment.
double FieldsOf(const cv::Mat1b& image) {
  if (image.rows < 3) return 0;
  const cv::Mat1b second = SomeRows(image, 2);
  const cv::Mat1b first = SomeRows(image).rowRange(0, second.rows);
  const cv::Mat1b next = SomeRows(image, 1).rowRange(0, second.rows);
  return cv::norm(first, next, cv::NORM_L1) / std::max(1.0, cv::norm(first, second, cv::NORM_L1));
}

struct Tear {
  int row = 0;      // the first one below it
  int columns = 0;  // that what is below lies further right
};

// The columns that are still inside when moved so far.
cv::Range ColumnsAside(const cv::Mat1b& image, int aside) {
  return {std::max(0, -aside), image.cols - std::max(0, aside)};
}

// Mean difference of columns of a row from those of the next one that lie `aside` further right.
double StepAside(const cv::Mat1b& image, int y, const cv::Range& columns, int aside) {
  const uint8_t* above = image.ptr(y);
  const uint8_t* below = image.ptr(y + 1) + aside;
  const int every = std::max(1, columns.size() / ImageRules::kEnoughColumns);
  int sum = 0;
  int count = 0;
  for (int x = columns.start; x < columns.end; x += every, ++count) {
    sum += std::abs(above[x] - below[x]);
  }
  return static_cast<double>(sum) / std::max(1, count);
}

// Mean differences of each row and the next one, grey levels.
std::vector<double> StepsOf(const cv::Mat1b& image) {
  std::vector<double> steps;
  for (int y = 0; y + 1 < image.rows; ++y) {
    steps.push_back(StepAside(image, y, {0, image.cols}, 0));
  }
  return steps;
}

// Rows that differ most from the next one, against the rows around: {times, row}.
std::vector<std::pair<double, int>> TearCandidates(const std::vector<double>& steps) {
  std::vector<std::pair<double, int>> rows;
  for (int y = ImageRules::kRowsAround; y < std::ssize(steps) - ImageRules::kRowsAround; ++y) {
    const auto at = steps.begin() + y;
    const double around =
        Median(std::vector(at - ImageRules::kRowsAround, at + ImageRules::kRowsAround + 1));
    const double times = steps[static_cast<size_t>(y)] / std::max(around, ImageRules::kMinStep);
    if (times > ImageRules::kTornFromRest) rows.emplace_back(times, y);
  }
  std::ranges::sort(rows, std::greater{});
  rows.resize(std::min(rows.size(), ImageRules::kTornTried));
  return rows;
}

// Whether the next row continues this one at one other place, all over the width.
std::optional<Tear> TearBelow(const cv::Mat1b& image, int y, double step) {
  const int most = image.cols / ImageRules::kMaxTornPart;
  std::vector<double> steps;
  for (int aside = -most; aside <= most; ++aside) {
    steps.push_back(StepAside(image, y, ColumnsAside(image, aside), aside));
  }
  const auto best = std::ranges::min_element(steps);
  const auto columns = static_cast<int>(best - steps.begin()) - most;
  if (*best > ImageRules::kTornFits * step || std::abs(columns) < ImageRules::kMinTornPx) {
    return {};
  }
  for (int aside = -most; aside <= most; ++aside) {
    if (2 * std::abs(aside - columns) > std::abs(columns) &&
        steps[static_cast<size_t>(aside + most)] < ImageRules::kTornElsewhere * step) {
      return {};
    }
  }
  const cv::Range all = ColumnsAside(image, columns);
  for (int part = 0; part < ImageRules::kParts; ++part) {
    const cv::Range range(all.start + all.size() * part / ImageRules::kParts,
                          all.start + all.size() * (part + 1) / ImageRules::kParts);
    if (StepAside(image, y, range, columns) >
        ImageRules::kTornElsewhere * StepAside(image, y, range, 0)) {
      return {};
    }
  }
  return Tear{y + 1, columns};
}

// The row from which on an image is moved sideways: its lower part is of another moment, or bytes
// were lost.
std::optional<Tear> FindTear(const cv::Mat1b& image) {
  if (image.cols < 2 * ImageRules::kMaxTornPart) return {};
  const std::vector<double> steps = StepsOf(image);
  for (const auto& [times, row] : TearCandidates(steps)) {
    if (auto tear = TearBelow(image, row, steps[static_cast<size_t>(row)])) return tear;
  }
  return {};
}

// What is wrong between the rows of an image; empty: nothing.
std::string RowFault(const char* which, const cv::Mat1b& image) {
  if (const double fields = FieldsOf(image); fields > ImageRules::kFields) {
    return fmt::format(
        "rows of the {} image differ {:.1f} times as much from the next as from the second next "
        "one: is it interlaced? give pictures of one field",
        which, fields);
  }
  if (const std::optional<Tear> tear = FindTear(image)) {
    return fmt::format(
        "the {} image is torn: from row {} on it goes on {} px further {}; is its lower part of "
        "another moment, or was a part lost on its way?",
        which, tear->row, std::abs(tear->columns), tear->columns > 0 ? "right" : "left");
  }
  return {};
}

// How much neighbours in a row differ, grey levels.
double SharpnessOf(const cv::Mat1b& image) {
  const int last = image.cols - 1;
  return cv::norm(image.colRange(0, last), image.colRange(1, last + 1), cv::NORM_L1) /
         static_cast<double>(image.total());
}

double BrightestOf(const cv::Mat1b& image) {
  double brightest = 0;
  cv::minMaxLoc(SomeRows(image), nullptr, &brightest);
  return brightest;
}

// What is wrong with images that are not dark; empty: nothing.
std::string FaultOf(const cv::Mat1b& left, const cv::Mat1b& right) {
  const double left_contrast = ContrastOf(left);
  const double right_contrast = ContrastOf(right);
  if (std::min(left_contrast, right_contrast) < kBlankContrast) {
    return fmt::format(
        "the {} image is blank: its grey values differ by {:.1f} from their mean; is the camera "
        "covered, or blinded?",
        left_contrast < right_contrast ? "left" : "right", std::min(left_contrast, right_contrast));
  }
  const double clipped = std::max(ShareClipped(left), ShareClipped(right));
  if (clipped > ImageRules::kMaxClipped) {
    return fmt::format("{:.0f} % of the pixels are white: expose both images shorter",
                       100 * clipped);
  }
  const double mosaic = std::max(MosaicOf(left), MosaicOf(right));
  if (mosaic > ImageRules::kMosaic) {
    return fmt::format(
        "neighbouring pixels differ {:.1f} times as much as every second ones: are these raw "
        "images behind a colour filter (Bayer)? demosaic them, or give their format its name, such "
        "as bayer_rggb8",
        mosaic);
  }
  const std::string of_rows = RowFault("left", left);
  return of_rows.empty() ? RowFault("right", right) : of_rows;
}

}  // namespace

Finding JudgeBits(const cv::Mat1b& left, const cv::Mat1b& right) {
  const double of_left = BrightestOf(left);
  const double of_right = BrightestOf(right);
  const std::string brightest =
      fmt::format("the brightest grey values are {:.0f} and {:.0f} of 255", of_left, of_right);
  constexpr const char* kCureOfDark =
      ": images of 10 or 12 bits in 16 have to be scaled, dark ones to be exposed longer";
  const bool are_dark = std::min(of_left, of_right) <= ImageRules::kFewLevels;
  const std::string fault = are_dark ? brightest + kCureOfDark : FaultOf(left, right);
  return {.question = Question::kBits,
          .verdict = fault.empty() ? Verdict::kGood : Verdict::kBad,
          .value = 100 * std::min(of_left, of_right) / 255,
          .sigma = 0,
          .text = fault.empty() ? brightest : fault};
}

std::optional<Finding> FindBlur(const cv::Mat1b& left, const cv::Mat1b& right) {
  const cv::Mat1b fine_left = Halved(left);
  const cv::Mat1b fine_right = Halved(right);
  const double of_left = SharpnessOf(Halved(fine_left));
  const double of_right = SharpnessOf(Halved(fine_right));
  if (!(std::min(of_left, of_right) > ImageRules::kMinSharp)) return {};
  const double ratio = of_right / of_left;
  const double finer = SharpnessOf(fine_right) / SharpnessOf(fine_left) / ratio;
  const double side = ratio < 1 ? -1 : 1;
  if (side * std::log(ratio) < std::log(ImageRules::kSharper) ||
      side * std::log(finer) < std::log(ImageRules::kSharperFiner)) {
    return {};
  }
  return Finding{
      .question = Question::kContrast,
      .verdict = Verdict::kBad,
      .value = ratio,
      .text = fmt::format("the {} image is blurred: neighbouring pixels differ {:.2f} times as "
                          "much in the right one as in the left one; is it out of focus, or did it "
                          "move while it was exposed?",
                          ratio < 1 ? "right" : "left", ratio)};
}

}  // namespace sprout::inputs
