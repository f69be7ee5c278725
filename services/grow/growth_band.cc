#include "services/grow/growth_band.h"

#include <algorithm>

namespace sprout {
namespace {

// For each of the four places that a window can have in a column of eight pixels.
alignas(16) constexpr int16_t kWindowRows[GrowthBand::kRowsPerSet][GrowthBand::kColumnRows] = {
    {-1, -1, -1, -1, -1, 0, 0, 0},
    {0, -1, -1, -1, -1, -1, 0, 0},
    {0, 0, -1, -1, -1, -1, -1, 0},
    {0, 0, 0, -1, -1, -1, -1, -1},
};

template <typename T>
size_t BytesOf(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

void GrowthBand::Resize(cv::Size size, int first_row, const GrowthRule& rule) {
  const bool with_sums = rule.similarity == GrowConfig::MNCC;
  const bool with_steps = rule.two_candidates() && rule.sub_pixel;
  first_row_ = first_row;
  if (size == size_ && with_sums != left_sum.empty() && with_steps != sub_pixel_steps.empty()) {
    return;
  }
  size_ = size;
  rows_ = std::min(kRows, size.height - first_row);
  stride_ = size.width + 2 * kPadding;
  const auto stride = static_cast<size_t>(stride_);
  const auto rows = static_cast<size_t>(rows_);
  const size_t sets = (rows + kRowsPerSet - 1) / kRowsPerSet;
  left.assign((rows + 2) * stride, {{0}, SeedQueue::kNone, 0, LeftPixel::kClosed});
  right_matched.assign((rows + 2) * stride, 0);
  right_energy.assign(rows * stride, kOutside);
  left_columns.assign(sets * stride * kColumnRows, 0);
  right_columns.assign(sets * stride * kColumnRows, 0);
  left_sum.assign(with_sums ? rows * stride : 0, 0);
  right_sum.assign(with_sums ? rows * stride : 0, 0);
  sub_pixel_steps.assign(with_steps ? rows * stride : 0, SubPixelSteps());
  row_scratch.assign(3 * static_cast<size_t>(size.width), 0);
  MakeViews();
}

void GrowthBand::MakeViews() {
  views_.assign(static_cast<size_t>(rows_), GrowthRow{});
  for (size_t row = 0; row < views_.size(); ++row) {
    GrowthRow& view = views_[row];
    const size_t first = row * static_cast<size_t>(stride_) + kPadding;
    const size_t first_column =
        (row / kRowsPerSet * static_cast<size_t>(stride_) + kPadding) * kColumnRows;
    view.left = left.data() + stride_ + first;
    view.right_energy = right_energy.data() + first;
    view.left_columns = left_columns.data() + first_column;
    view.right_columns = right_columns.data() + first_column;
    view.window_rows = kWindowRows[row % kRowsPerSet];
    if (!sub_pixel_steps.empty()) view.sub_pixel_steps = sub_pixel_steps.data() + first;
    if (left_sum.empty()) continue;
    view.left_sum = left_sum.data() + first;
    view.right_sum = right_sum.data() + first;
  }
}

size_t GrowthBand::bytes() const {
  return BytesOf(left) + BytesOf(right_energy) + BytesOf(right_matched) + BytesOf(left_sum) +
         BytesOf(right_sum) + BytesOf(sub_pixel_steps) + BytesOf(left_columns) +
         BytesOf(right_columns) + BytesOf(row_scratch) + BytesOf(views_);
}

}  // namespace sprout
