#include "services/grow/growth_band.h"

#include <algorithm>

namespace sprout {
namespace {

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
  rows_per_entry_ = (uint64_t{1} << kRowFraction) / static_cast<uint64_t>(stride_) + 1;
  const auto stride = static_cast<size_t>(stride_);
  const auto rows = static_cast<size_t>(rows_);
  const size_t pairs = static_cast<size_t>(PairRows(rows_)) * stride + 2 * kRunPixels;
  left.assign((rows + 2) * stride, {{0}, SeedQueue::kNone, 0, LeftPixel::kClosed});
  right_matched.assign((rows + 2) * stride, 0);
  right_energy.assign(rows * stride + 2 * kRunPixels, kOutside);
  left_pairs.assign(pairs, 0);
  right_pairs.assign(pairs, 0);
  left_sum.assign(with_sums ? rows * stride : 0, 0);
  right_sum.assign(with_sums ? rows * stride : 0, 0);
  sub_pixel_steps.assign(with_steps ? rows * stride + kRunPixels : 0, 0);
  row_scratch.assign(3 * static_cast<size_t>(size.width), 0);
  MakeViews();
}

void GrowthBand::MakeViews() {
  views_.assign(static_cast<size_t>(rows_), GrowthRow{});
  for (size_t row = 0; row < views_.size(); ++row) {
    GrowthRow& view = views_[row];
    const size_t first = row * static_cast<size_t>(stride_) + kPadding;
    view.left = left.data() + stride_ + first;
    view.right_energy = right_energy.data() + kRunPixels + first;
    for (size_t i = 0; i < view.left_pairs.size(); ++i) {
      const size_t pair = first + 2 * i * static_cast<size_t>(stride_) + kRunPixels;
      view.left_pairs[i] = left_pairs.data() + pair;
      view.right_pairs[i] = right_pairs.data() + pair;
    }
    if (!sub_pixel_steps.empty()) view.sub_pixel_steps = sub_pixel_steps.data() + first;
    if (left_sum.empty()) continue;
    view.left_sum = left_sum.data() + first;
    view.right_sum = right_sum.data() + first;
  }
}

size_t GrowthBand::bytes() const {
  return BytesOf(left) + BytesOf(right_energy) + BytesOf(right_matched) + BytesOf(left_sum) +
         BytesOf(right_sum) + BytesOf(sub_pixel_steps) + BytesOf(left_pairs) +
         BytesOf(right_pairs) + BytesOf(row_scratch) + BytesOf(views_);
}

}  // namespace sprout
