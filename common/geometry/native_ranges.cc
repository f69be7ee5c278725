#include "common/geometry/native_ranges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "common/geometry/projection.h"

namespace sprout {
namespace {

constexpr int kMinSensorSide = 8;  // columns or rows of a sensor

// Columns at which something of the picture changes: where a pixel differs from the one before, or
// where the slope does. Empty: more than every second column does.
template <typename Changes>
std::vector<int> ChangedColumns(const cv::Mat1f& image, int first, int last, Changes changes) {
  std::vector<uint8_t> changed(static_cast<size_t>(image.cols), 0);
  int count = 0;
  for (int y = 0; y < image.rows; ++y) {
    const float* row = image[y];
    for (int x = first; x <= last; ++x) {
      if (changed[static_cast<size_t>(x)] != 0 || !changes(row + x)) continue;
      changed[static_cast<size_t>(x)] = 1;
      if (2 * ++count > image.cols) return {};
    }
  }
  std::vector<int> columns;
  for (int x = first; x <= last; ++x) {
    if (changed[static_cast<size_t>(x)] != 0) columns.push_back(x);
  }
  return columns;
}

// Where the pixels of a sensor show along a side of an enlarged image.
struct Pattern {
  double phase;        // 0: where parts of equal length meet; 0.5: in their middles
  double shift_px;     // from there to the column that changes
  int most_columns;    // that change at one of them
  int least_px;        // a part
  double least_share;  // of the parts that have such a column
};

// What differs from the pixel before is the first pixel of a part. The slope changes in the middle
// of a part, and where that lies between two pixels, at both. Some rows show that, not each.
constexpr Pattern kRepeated{
    .phase = 0, .shift_px = 0, .most_columns = 1, .least_px = 2, .least_share = 0.5};
constexpr Pattern kInterpolated{
    .phase = 0.5, .shift_px = -0.5, .most_columns = 2, .least_px = 4, .least_share = 0.25};

// The least number of equal parts of `length` of which columns show such a pattern, to less than a
// pixel, which is the rounding of a pixel's place; 0: none.
int PartsOf(const std::vector<int>& columns, int length, const Pattern& pattern) {
  for (int parts = kMinSensorSide; parts <= length / pattern.least_px; ++parts) {
    const double side = static_cast<double>(length) / parts;
    double last = std::numeric_limits<double>::quiet_NaN();
    int used = 0, in_last = 0;
    const bool fit = std::ranges::all_of(columns, [&](int column) {
      const double place = column - pattern.shift_px;
      const double part = std::round(place / side - pattern.phase);
      in_last = part == last ? in_last + 1 : 1;
      if (in_last == 1) ++used;
      last = part;
      return in_last <= pattern.most_columns && std::abs((part + pattern.phase) * side - place) < 1;
    });
    if (fit && used >= std::max<double>(kMinSensorSide - 1, pattern.least_share * parts - 1))
      return parts;
  }
  return 0;
}

// Smallest difference of neighbours in some rows: a count of a file of whole numbers, or what
// rounding makes.
float QuantumOf(const cv::Mat1f& image) {
  constexpr int kRows = 64;
  float quantum = std::numeric_limits<float>::infinity();
  for (int y = 0; y < image.rows; y += std::max(1, image.rows / kRows)) {
    const float* row = image[y];
    for (int x = 1; x < image.cols; ++x) {
      const float difference = std::abs(row[x] - row[x - 1]);
      if (difference > 0) quantum = std::min(quantum, difference);  // false for NaN
    }
  }
  return quantum;
}

// Columns of the sensor that an enlarged image was made of.
struct Columns {
  int count = 0;  // 0: the image is not enlarged
  bool interpolated = false;
};

Columns NativeColumns(const cv::Mat1f& image) {
  const auto bits = [](float value) { return std::bit_cast<uint32_t>(value); };
  const std::vector<int> steps = ChangedColumns(image, 1, image.cols - 1, [&](const float* pixel) {
    return bits(pixel[0]) != bits(pixel[-1]);
  });
  if (!steps.empty()) return {.count = PartsOf(steps, image.cols, kRepeated)};
  // Within a cell of linear interpolation the second difference is at most two counts, and what
  // rounding of single precision adds.
  constexpr float kRounding = 4e-6F;
  std::optional<float> quantum;
  const std::vector<int> kinks = ChangedColumns(image, 1, image.cols - 2, [&](const float* pixel) {
    const float bend = std::abs(pixel[-1] - 2 * pixel[0] + pixel[1]);
    const float rounding =
        kRounding * (std::abs(pixel[-1]) + std::abs(pixel[0]) + std::abs(pixel[1]));
    if (!(bend > rounding)) return false;  // also where there is no number
    if (!quantum) quantum = QuantumOf(image);
    return bend > 2.5F * *quantum + rounding;
  });
  return {.count = PartsOf(kinks, image.cols, kInterpolated), .interpolated = true};
}

// Where the pixel of the sensor lies, px.
double MiddleOf(int column, int columns, int length) {
  return (column + 0.5) * length / columns - 0.5;
}

// The columns of the sensor. Where the middle of an interpolated one lies between two pixels, the
// line from its left leads there.
cv::Mat1f Reduced(const cv::Mat1f& image, const Columns& columns) {
  cv::Mat1f reduced(image.rows, columns.count);
  for (int i = 0; i < columns.count; ++i) {
    const double middle = MiddleOf(i, columns.count, image.cols);
    const int x = static_cast<int>(columns.interpolated ? middle : middle + 0.5);
    const float beyond = columns.interpolated ? static_cast<float>(middle - x) : 0;
    for (int y = 0; y < image.rows; ++y) {
      const float* pixel = image[y] + x;
      reduced(y, i) = beyond > 0 ? pixel[0] + beyond * (pixel[0] - pixel[-1]) : pixel[0];
    }
  }
  return reduced;
}

cv::Mat1f Transposed(const cv::Mat1f& image) {
  cv::Mat1f transposed;
  cv::transpose(image, transposed);
  return transposed;
}

std::vector<int> PixelsOf(int columns, int length) {
  std::vector<int> pixels;
  for (int i = 0; i < columns; ++i) {
    pixels.push_back(static_cast<int>(MiddleOf(i, columns, length) + 0.5));
  }
  return pixels;
}

// Whether most runs of equal returns along rows are longer than a pixel, and meet others of which
// they are far in the order of all values. In images of few steps most are next to each other.
bool RepeatsPoints(const cv::Mat1f& image) {
  constexpr int kStep = 4;
  constexpr size_t kMinRuns = 200;
  constexpr std::ptrdiff_t kMinRanks = 4;
  std::vector<float> runs;  // the longer ones; 0: none, or the end of a row
  size_t returns = 0, longer = 0;
  for (int y = 0; y < image.rows; y += kStep) {
    for (int x = 0, end = 0; x < image.cols; x = end) {
      for (end = x + 1; end < image.cols && image(y, end) == image(y, x);) ++end;
      const bool is_return = IsReturn(image(y, x));
      const bool is_longer = is_return && end - x > 1;
      runs.push_back(is_longer ? image(y, x) : 0);
      returns += is_return ? 1 : 0;
      longer += is_longer ? 1 : 0;
    }
    runs.push_back(0);
  }
  if (returns < kMinRuns || 2 * longer < returns) return false;
  std::vector<float> values = runs;
  std::ranges::sort(values);
  values.erase(std::ranges::unique(values).begin(), values.end());
  const auto rank = [&](float value) { return std::ranges::lower_bound(values, value); };
  int near = 0, far = 0;
  for (size_t i = 1; i < runs.size(); ++i) {
    if (runs[i] == 0 || runs[i - 1] == 0) continue;
    ++(std::abs(rank(runs[i]) - rank(runs[i - 1])) < kMinRanks ? near : far);
  }
  return far > near;
}

// The middle of the smallest rectangle around the pixels that are equal to one and connected with
// it by their sides. Marks them as seen. (cv::floodFill() takes O(rows) for each patch.)
cv::Point MiddleOfPatch(const cv::Mat1f& image, const cv::Point& start, cv::Mat1b& seen,
                        std::vector<cv::Point>& ahead) {
  const cv::Rect inside({0, 0}, image.size());
  cv::Point least = start, most = start;
  const auto visit = [&](const cv::Point& at) {
    if (!inside.contains(at) || seen(at) != 0 || image(at) != image(start)) return;
    seen(at) = 1;
    least = {std::min(least.x, at.x), std::min(least.y, at.y)};
    most = {std::max(most.x, at.x), std::max(most.y, at.y)};
    ahead.push_back(at);
  };
  visit(start);
  while (!ahead.empty()) {
    const cv::Point at = ahead.back();
    ahead.pop_back();
    for (const cv::Point& side : {cv::Point(-1, 0), {1, 0}, {0, -1}, {0, 1}}) visit(at + side);
  }
  return (least + most) / 2;
}

// One pixel in the middle of each patch of equal ones, where that is part of it.
cv::Mat1f MiddlesOfPatches(const cv::Mat1f& image) {
  cv::Mat1f middles(image.size(), 0);
  cv::Mat1b seen(image.size(), uint8_t{0});
  std::vector<cv::Point> ahead;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (!IsReturn(image(y, x)) || seen(y, x) != 0) continue;
      const cv::Point middle = MiddleOfPatch(image, {x, y}, seen, ahead);
      if (image(middle) == image(y, x)) middles(middle) = image(y, x);
    }
  }
  return middles;
}

std::optional<NativeRanges> FindPoints(const TofImage& tof, const TofCamera& camera) {
  if (!RepeatsPoints(tof.depth_m) || !RepeatsPoints(Transposed(tof.depth_m))) return std::nullopt;
  NativeRanges points{.tof = {.depth_m = MiddlesOfPatches(tof.depth_m), .amplitude = tof.amplitude},
                      .camera = camera,
                      .columns = std::vector<int>(static_cast<size_t>(tof.depth_m.cols)),
                      .rows = std::vector<int>(static_cast<size_t>(tof.depth_m.rows))};
  std::iota(points.columns.begin(), points.columns.end(), 0);
  std::iota(points.rows.begin(), points.rows.end(), 0);
  return points;
}

}  // namespace

void NativeRanges::ToEnlarged(Seed& seed) const {
  if (seed.tof_u < 0) return;
  seed.tof_u = static_cast<int16_t>(columns[static_cast<size_t>(seed.tof_u)]);
  seed.tof_v = static_cast<int16_t>(rows[static_cast<size_t>(seed.tof_v)]);
}

std::optional<NativeRanges> FindNativeRanges(const TofImage& tof, const TofCamera& camera) {
  const cv::Size size = tof.depth_m.size();
  if (size.width < 2 * kMinSensorSide || size.height < 2 * kMinSensorSide) return std::nullopt;
  const Columns columns = NativeColumns(tof.depth_m);
  const Columns rows = columns.count == 0 ? columns : NativeColumns(Transposed(tof.depth_m));
  if (rows.count == 0) return FindPoints(tof, camera);
  const auto reduced = [&](const cv::Mat1f& image) {
    return image.empty() ? image : Transposed(Reduced(Transposed(Reduced(image, columns)), rows));
  };
  return NativeRanges{.tof = {.depth_m = reduced(tof.depth_m), .amplitude = reduced(tof.amplitude)},
                      .camera = Resized(camera, {columns.count, rows.count}),
                      .columns = PixelsOf(columns.count, size.width),
                      .rows = PixelsOf(rows.count, size.height)};
}

}  // namespace sprout
