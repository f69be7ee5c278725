#include "services/grow/growth_band.h"

namespace sprout {

void GrowthBand::Resize(cv::Size size, int first) {
  if (size == image_size && first == first_row) return;
  image_size = size;
  first_row = first;
  rows = std::min(RowsPerBand(size.height), size.height - first);
  stride = size.width + 2 * kPadding;
  // The last row is read and written up to a run behind its end.
  const auto row = static_cast<size_t>(stride);
  const size_t pixels = static_cast<size_t>(rows + 2 * kMargin) * row + 2 * kRunPixels;
  left.assign(pixels, {{SeedQueue::kNone}, 0, LeftPixel::kClosed});
  right.assign(pixels, kNoWindow);
  left_grey.assign(pixels, 0);
  right_grey.assign(pixels, 0);
  steps.assign(pixels, 0);
  has_open.assign(static_cast<size_t>(rows), 0);
}

}  // namespace sprout
