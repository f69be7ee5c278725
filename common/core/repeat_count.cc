#include "common/core/repeat_count.h"

#include <string_view>

#include "common/core/digest.h"

namespace sprout {
namespace {

// An image that differs from the last one is hashed only at every so many rows.
constexpr int kSparseRows = 16;

uint64_t HashOf(const cv::Mat& image, int step) {
  uint64_t hash = 0;
  for (int y = 0; y < image.rows; y += step) {
    const std::string_view row(image.ptr<char>(y),
                               static_cast<size_t>(image.cols) * image.elemSize());
    hash = hash * 31 + Hash(row);
  }
  return hash;
}

}  // namespace

int RepeatCount::Add(const cv::Mat& image) {
  const uint64_t sparse = HashOf(image, kSparseRows);
  std::optional<uint64_t> whole;
  if (same_ > 0 && sparse == sparse_) whole = HashOf(image, 1);
  const bool is_same = whole && (!whole_ || whole_ == whole);
  same_ = is_same ? same_ + 1 : 1;
  sparse_ = sparse;
  whole_ = whole;
  return same_;
}

}  // namespace sprout
