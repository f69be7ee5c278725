#pragma once

#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>

#include "common/core/disparity_image.h"
#include "common/core/image.h"
#include "common/core/result.h"

namespace sprout {

/// A series of checks on the fields of a message or a calibration; keeps the first error, which
/// names field, value and what is allowed.
class Checks {
 public:
  template <typename Value>
  Checks& Require(bool holds, const char* field, Value value, const std::string& allowed) {
    if (!holds && error_.text.empty()) {
      std::ostringstream text;
      text << field << " = " << value << ": allowed is " << allowed;
      error_.text = text.str();
    }
    return *this;
  }

  Checks& Side(const char* field, int32_t value) {
    return Require(value >= 1 && value <= kMaxSide, field, value,
                   "1 to " + std::to_string(kMaxSide));
  }

  /// Requires both sides to be at least 1, or both to be 0.
  Checks& SidesOrNone(const char* columns, int32_t width, const char* rows, int32_t height) {
    if (width == 0 && height == 0) return *this;
    return Side(columns, width).Side(rows, height);
  }

  /// The fields that every message with a disparity map has.
  template <typename Message>
  Checks& DisparityMap(const Message& message, size_t data_bytes) {
    return Side("width", message.width)
        .Side("height", message.height)
        .Pixels("width × height", message.width, message.height)
        .Require(message.counts_per_px == DisparityImage::kCountsPerPixel, "counts_per_px",
                 message.counts_per_px, std::to_string(DisparityImage::kCountsPerPixel))
        .Require(message.invalid == DisparityImage::kInvalid, "invalid", message.invalid,
                 std::to_string(DisparityImage::kInvalid))
        .Require(message.size >= 0 && static_cast<size_t>(message.size) == data_bytes, "size",
                 message.size, "the number of bytes in data");
  }

  Checks& Pixels(const char* fields, int32_t width, int32_t height) {
    const int64_t pixels = int64_t{width} * height;
    return Require(pixels <= kMaxPixels, fields, pixels,
                   "up to " + std::to_string(kMaxPixels) + " pixels");
  }

  Checks& Length(const std::string& field, const std::string& value, size_t longest) {
    return Require(value.size() <= longest, (field + " length").c_str(), value.size(),
                   "0 to " + std::to_string(longest));
  }

  Checks& Positive(const char* field, double value) {
    return Require(std::isfinite(value) && value > 0, field, value, "a finite number > 0");
  }

  Checks& Finite(const char* field, double value) {
    return Require(std::isfinite(value), field, value, "a finite number");
  }

  Checks& Within(const std::string& field, double value, double low, double high,
                 const char* unit) {
    std::ostringstream allowed;
    allowed << low << " to " << high << ' ' << unit;
    return Require(value >= low && value <= high, field.c_str(), value, allowed.str());
  }

  Checks& NotNegative(const char* field, int64_t value) {
    return Require(value >= 0, field, value, ">= 0");
  }

  bool ok() const { return error_.text.empty(); }
  tl::unexpected<Error> error() const { return tl::unexpected<Error>(error_); }

 private:
  Error error_;
};

}  // namespace sprout
