#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <stdexcept>

#include "tests/common/messages/examples.h"

namespace sprout {

/// Sends a value over the wire.
template <typename Value>
Value RoundTrip(Part part, const Value& value,
                DisparityEncoding encoding = DisparityEncoding::kRawInt16) {
  const Result<DecodedPart> decoded =
      DecodePart(part, EncodePart(examples::Id(), part, value, encoding));
  if (!decoded) throw std::runtime_error(decoded.error().text);
  EXPECT_EQ(decoded->id, examples::Id());
  return std::get<Value>(decoded->value);
}

/// Equal type, size and bytes (so that NaN equals NaN).
inline void ExpectSamePixels(const cv::Mat& actual, const cv::Mat& expected) {
  ASSERT_EQ(actual.type(), expected.type());
  ASSERT_EQ(actual.size(), expected.size());
  const size_t row_bytes = static_cast<size_t>(expected.cols) * expected.elemSize();
  for (int v = 0; v < expected.rows; ++v) {
    EXPECT_EQ(std::memcmp(actual.ptr(v), expected.ptr(v), row_bytes), 0) << "row " << v;
  }
}

}  // namespace sprout
