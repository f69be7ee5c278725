#include "common/picture/eight_bits.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace sprout {
namespace {

constexpr int kValues = 1 << 16;
constexpr int kLevels = 256;
// Least share of the 256 levels that must be used: with less than 32 little is left to match.
constexpr double kMinUse = 1.0 / 8;
constexpr char kSwapped[] = "no low byte is above 63: are the bytes in the other order?";
constexpr double kIgnored = 0.001;  // at either end: single hot and dead pixels

std::vector<int64_t> Histogram(std::initializer_list<CameraImage*> images) {
  std::vector<int64_t> counts(kValues, 0);
  for (const CameraImage* image : images) {
    if (image->pixels.depth() != CV_16U) continue;
    const cv::Mat values = image->pixels.reshape(1);
    for (int v = 0; v < values.rows; ++v) {
      for (const uint16_t value :
           std::span(values.ptr<uint16_t>(v), static_cast<size_t>(values.cols))) {
        ++counts[value];
      }
    }
  }
  return counts;
}

// The smallest value that at least `share` of all are not above.
int Quantile(const std::vector<int64_t>& counts, int64_t total, double share) {
  const auto wanted = static_cast<int64_t>(share * static_cast<double>(total));
  int64_t below = 0;
  for (int value = 0; value < kValues; ++value) {
    below += counts[static_cast<size_t>(value)];
    if (below > wanted) return value;
  }
  return kValues - 1;
}

int Largest(const std::vector<int64_t>& counts) {
  int value = kValues - 1;
  while (value > 0 && counts[static_cast<size_t>(value)] == 0) --value;
  return value;
}

// Whether low bytes are as high ones of up to 14 bits are, and high ones reach beyond them: bytes
// in the other order, as of PGM files that were written low byte first.
bool LookSwapped(const std::vector<int64_t>& counts, int64_t total) {
  constexpr size_t kMaxHighBytes = (1 << 14) / kLevels;
  int64_t some = 0;  // of the low bytes are not 0
  for (size_t value = 0; value < counts.size(); ++value) {
    const size_t low = value % kLevels;
    if (low >= kMaxHighBytes && counts[value] > 0) return false;
    if (low > 0) some += counts[value];
  }
  return 2 * some > total && Largest(counts) >= 1 << 14;
}

}  // namespace

Result<void> CheckBits(int bits) {
  if (bits == 0 || (bits >= kMinBits && bits <= kMaxBits)) return {};
  return Fail(fmt::format("{}: allowed: {} to {}, or 0", bits, kMinBits, kMaxBits));
}

EightBits::Range EightBits::RangeOf(std::initializer_list<CameraImage*> images) {
  const std::vector<int64_t> counts = Histogram(images);
  int64_t total = 0;
  for (const int64_t count : counts) total += count;
  const int largest = Largest(counts);
  const bool are_swapped = LookSwapped(counts, total);
  int bits = kMinBits;
  while ((1 << bits) <= largest) bits += 2;
  const double all = 1 << bits;
  const double low = Quantile(counts, total, kIgnored);
  const double used = Quantile(counts, total, 1 - kIgnored) - low + 1;
  if (used >= kMinUse * all || bits == kMinBits)
    return {.low = 0, .width = all, .are_swapped = are_swapped};
  const double width = std::max<double>(2 * used, kLevels);
  return {.low = std::max(0.0, low - (width - used) / 2), .width = width};
}

// What the pixels use, unless it is as good as what is known.
void EightBits::LookAt(std::initializer_list<CameraImage*> images) {
  const Range used = RangeOf(images);
  const bool fits = used.low >= range_.low && used.low + used.width <= range_.low + range_.width;
  // A band has room at both ends; what leaves it a little is cut off.
  const bool is_band = range_.low > 0 || used.low > 0;
  const double beyond =
      std::max(range_.low - used.low, used.low + used.width - range_.low - range_.width);
  if (range_.width > 0 && (fits || (is_band && beyond <= range_.width / 2))) return;
  note_ = fmt::format(
      "{}pixels of 16 bits use {:.0f} to {:.0f}, which becomes 0 to 255; if that is wrong: --bits, "
      "or &bits= of a source{}{}",
      range_.width > 0 ? "brightness changes: " : "", used.low, used.low + used.width - 1,
      used.are_swapped ? "; " : "", used.are_swapped ? kSwapped : "");
  range_ = used;
}

void EightBits::NoteBeyond(std::initializer_list<CameraImage*> images) {
  if (said_misfit_) return;
  double beyond = 0;
  double total = 0;
  for (const CameraImage* image : images) {
    const cv::Mat values = image->pixels.reshape(1);
    beyond += cv::countNonZero(values >= (1 << bits_));
    total += static_cast<double>(values.total());
  }
  if (beyond <= kIgnored * total) return;
  said_misfit_ = true;
  note_ = fmt::format(
      "bits = {}: {:.1f} % of the pixels are above {} and become white; allowed: as "
      "many bits as they use, or none, then it is found out",
      bits_, 100 * beyond / total, (1 << bits_) - 1);
}

void EightBits::Convert(std::initializer_list<CameraImage*> images) {
  const auto has_more = [](const CameraImage* image) { return image->pixels.depth() == CV_16U; };
  const bool any_has_more = std::ranges::any_of(images, has_more);
  int by_format = 0;
  for (const CameraImage* image : images) by_format = std::max(by_format, image->largest);
  if (bits_ > kMinBits && !any_has_more && !std::exchange(said_misfit_, true)) {
    note_ = fmt::format("bits = {} changes nothing: images of 8 bits are taken as they are", bits_);
  }
  Range range{.low = 0, .width = by_format + 1.0};
  if (any_has_more && bits_ > 0) {
    range.width = 1 << bits_;
    NoteBeyond(images);
  } else if (any_has_more && (by_format == 0 || by_format == kValues - 1)) {  // any value at all
    LookAt(images);
    range = range_;
  } else if (any_has_more && !said_misfit_ && RangeOf(images).are_swapped) {
    said_misfit_ = true;
    note_ = fmt::format("pixels of 16 bits use more than the format's 0 to {}, and {}", by_format,
                        kSwapped);
  }
  for (CameraImage* image : images) {
    cv::Mat& pixels = image->pixels;
    if (has_more(image)) {
      const double gain = kLevels / range.width;
      pixels.convertTo(pixels, CV_8U, gain, -range.low * gain - 0.499);  // down, as a shift does
    } else if (image->largest > 0 && image->largest < kLevels - 1) {     // PGM of 0 to 100
      pixels.convertTo(pixels, CV_8U, (kLevels - 1.0) / image->largest);
    }
  }
}

std::string EightBits::TakeNote() { return std::exchange(note_, {}); }

}  // namespace sprout
