#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <span>

namespace sprout {

/// The time at which a fake camera took an image, written into its first pixels: what a test
/// compares with. µs since 1970, below 2^60.

inline constexpr int kStampPixels8 = 8;   ///< of 8 bit each
inline constexpr int kStampPixels16 = 5;  ///< of 12 bit each, and 1, as 0 is no return

inline void WriteStamp8(int64_t utime, std::span<uint8_t> bytes) {
  std::memcpy(bytes.data(), &utime, sizeof utime);
}

inline int64_t ReadStamp8(const cv::Mat& grey) {
  int64_t utime = 0;
  std::memcpy(&utime, grey.ptr(), sizeof utime);
  return utime;
}

inline void WriteStamp16(int64_t utime, std::span<uint8_t> bytes) {
  std::array<uint16_t, kStampPixels16> numbers{};
  for (uint16_t& number : numbers) {
    number = static_cast<uint16_t>((utime & 0xFFF) + 1);
    utime >>= 12;
  }
  std::memcpy(bytes.data(), numbers.data(), sizeof numbers);
}

/// @param unit_m  metres of one of the camera's numbers.
inline int64_t ReadStamp16(const cv::Mat1f& depth_m, double unit_m) {
  int64_t utime = 0;
  for (int i = kStampPixels16 - 1; i >= 0; --i) {
    utime = (utime << 12) + std::llround(static_cast<double>(depth_m(0, i)) / unit_m) - 1;
  }
  return utime;
}

}  // namespace sprout
