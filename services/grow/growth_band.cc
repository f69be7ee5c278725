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

void GrowthBand::Resize(cv::Size size, int first_row, bool with_sums) {
  first_row_ = first_row;
  if (size == size_ && with_sums != left_sum.empty()) return;
  size_ = size;
  rows_ = std::min(kRows, size.height - first_row);
  const auto width = static_cast<size_t>(size.width);
  const size_t padded = width + 2 * kPadding;
  const auto rows = static_cast<size_t>(rows_);
  const size_t sets = (rows + kRowsPerSet - 1) / kRowsPerSet;
  left.assign((rows + 2) * width, {0, SeedQueue::kNone, 0, LeftPixel::kClosed});
  right_energy.assign(rows * padded, kOutside);
  right_matched.assign(rows * width, 0);
  left_columns.assign(sets * padded * kColumnRows, 0);
  right_columns.assign(sets * padded * kColumnRows, 0);
  left_sum.assign(with_sums ? rows * width : 0, 0);
  right_sum.assign(with_sums ? rows * padded : 0, 0);
  column_sums.assign(2 * width, 0);
  MakeViews(with_sums);
}

void GrowthBand::MakeViews(bool with_sums) {
  const auto width = static_cast<size_t>(size_.width);
  const size_t padded = width + 2 * kPadding;
  views_.assign(static_cast<size_t>(rows_) + 2, GrowthRow{});
  views_.front().left = left.data();
  views_.back().left = left.data() + (views_.size() - 1) * width;
  for (size_t row = 0; row < static_cast<size_t>(rows_); ++row) {
    GrowthRow& view = views_[row + 1];
    const size_t set = row / kRowsPerSet;
    view.left = left.data() + (row + 1) * width;
    view.right_energy = right_energy.data() + row * padded + kPadding;
    view.right_matched = right_matched.data() + row * width;
    view.left_columns = left_columns.data() + (set * padded + kPadding) * kColumnRows;
    view.right_columns = right_columns.data() + (set * padded + kPadding) * kColumnRows;
    view.window_rows = kWindowRows[row % kRowsPerSet];
    if (!with_sums) continue;
    view.left_sum = left_sum.data() + row * width;
    view.right_sum = right_sum.data() + row * padded + kPadding;
  }
}

size_t GrowthBand::bytes() const {
  return BytesOf(left) + BytesOf(right_energy) + BytesOf(right_matched) + BytesOf(left_sum) +
         BytesOf(right_sum) + BytesOf(left_columns) + BytesOf(right_columns) +
         BytesOf(column_sums) + BytesOf(views_);
}

}  // namespace sprout
