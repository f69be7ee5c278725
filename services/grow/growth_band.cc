#include "services/grow/growth_band.h"

#include <algorithm>

namespace sprout {
namespace {

template <typename T>
size_t BytesOf(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

void GrowthBand::Resize(cv::Size size, int first_row, const GrowthRule& rule, Kind kind) {
  const bool with_sums = rule.similarity == GrowConfig::MNCC;
  const bool by_row = kind == Kind::kTabled;
  const bool with_steps = kind != Kind::kOpen && rule.sub_pixel;
  first_row_ = first_row;
  if (size == size_ && kind == kind_ && with_sums != left_sum_.empty() &&
      with_steps != sub_pixel_steps_.empty()) {
    return;
  }
  size_ = size;
  kind_ = kind;
  rows_ = std::min(RowsPerBand(size.height), size.height - first_row);
  pair_rows_ = by_row ? kWindow : rows_ + 2 * kWindowRadius;
  stride_ = size.width + 2 * kPadding;
  rows_per_entry_ = (uint64_t{1} << kRowFraction) / static_cast<uint64_t>(stride_) + 1;
  const auto stride = static_cast<size_t>(stride_);
  const auto rows = static_cast<size_t>(rows_);
  const size_t energies = (by_row ? 1 : rows) * stride + 2 * kRunPixels;
  const size_t pairs = static_cast<size_t>(pair_rows_) * stride + 2 * kRunPixels;
  left.assign((rows + 2) * stride, {{SeedQueue::kNone}, 0, LeftPixel::kClosed});
  right_matched.assign((rows + 2) * stride, 0);
  left_energy_.assign(energies, 0);
  right_energy_.assign(energies, kOutside);
  left_pairs_.assign(pairs, 0);
  right_pairs_.assign(pairs, 0);
  left_sum_.assign(with_sums ? rows * stride : 0, 0);
  right_sum_.assign(with_sums ? rows * stride : 0, 0);
  sub_pixel_steps_.assign(with_steps ? rows * stride + kRunPixels : 0, 0);
  row_scratch_.assign(4 * stride, 0);
  prior_scratch_.assign(static_cast<size_t>(size.width) + kRunPixels, 0);
  MakeViews();
}

void GrowthBand::MakeViews() {
  views_.assign(static_cast<size_t>(rows_), GrowthRow{});
  for (size_t row = 0; row < views_.size(); ++row) {
    GrowthRow& view = views_[row];
    const size_t first = row * static_cast<size_t>(stride_) + kPadding;
    const size_t energies = kRunPixels + (kind_ == Kind::kTabled ? kPadding : first);
    view.left = left.data() + stride_ + first;
    view.left_energy = left_energy_.data() + energies;
    view.right_energy = right_energy_.data() + energies;
    for (size_t i = 0; i < view.left_pairs.size(); ++i) {
      const int pair_row = static_cast<int>(row + 2 * i);
      view.left_pairs[i] = LeftPairs(pair_row);
      view.right_pairs[i] = RightPairs(pair_row);
    }
    if (!sub_pixel_steps_.empty()) view.sub_pixel_steps = sub_pixel_steps_.data() + first;
    if (left_sum_.empty()) continue;
    view.left_sum = left_sum_.data() + first;
    view.right_sum = right_sum_.data() + first;
  }
}

void GrowthBand::SetSigma(const cv::Mat1b& sigma) {
  for (int r = 0; r < rows_; ++r) views_[static_cast<size_t>(r)].sigma = sigma[first_row_ + r];
}

size_t GrowthBand::bytes() const {
  return BytesOf(left) + BytesOf(right_matched) + BytesOf(left_energy_) + BytesOf(right_energy_) +
         BytesOf(left_sum_) + BytesOf(right_sum_) + BytesOf(sub_pixel_steps_) +
         BytesOf(left_pairs_) + BytesOf(right_pairs_) + BytesOf(row_scratch_) +
         BytesOf(prior_scratch_) + BytesOf(views_);
}

}  // namespace sprout
