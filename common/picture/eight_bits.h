#pragma once

#include <initializer_list>
#include <opencv2/core.hpp>
#include <string>

#include "common/core/result.h"
#include "common/picture/read_image.h"

namespace sprout {

/// Bits a pixel that can be asked for; 0: found out.
inline constexpr int kMinBits = 8;
inline constexpr int kMaxBits = 16;

/// Whether bits can be asked for; the error says which.
Result<void> CheckBits(int bits);

/// Makes images of 8 bits a pixel of those with up to 16, the same way for all images of one
/// recording, whatever they came from. Images of 8 bits stay as they are. Otherwise the range of
/// values that becomes 0 to 255 is, in this order:
///   1. what the user says (bits): 0 to 2^bits - 1;
///   2. what the format says (CameraImage::largest);
///   3. what the pixels of the first capture use: 0 to 2^b - 1 for the smallest b of 8, 10, 12, 14
///      and 16 that holds all; or, where 99.8 % of them use less than an eighth of that (thermal
///      cameras), the range of these and half of it more on both sides.
/// A later capture with pixels beyond that is looked at anew, and this is said. So it is once when
/// the user says more than 8 bits of images that have 8, or fewer than pixels use.
class EightBits {
 public:
  /// @param bits  of a pixel, kMinBits to kMaxBits; 0: found out.
  explicit EightBits(int bits = 0) : bits_(bits) {}

  /// Replaces the pixels of the images of one capture (left and right) by those with 8 bits.
  /// O(pixels).
  void Convert(std::initializer_list<CameraImage*> images);

  /// What a user should know since the last call, one line; mostly empty.
  std::string TakeNote();

 private:
  struct Range {
    double low = 0;
    double width = 0;          // number of values; 0: not known yet
    bool are_swapped = false;  // bytes of the pixels, as it seems
    bool operator==(const Range&) const = default;
  };

  static Range RangeOf(std::initializer_list<CameraImage*> images);
  void LookAt(std::initializer_list<CameraImage*> images);
  void NoteBeyond(std::initializer_list<CameraImage*> images);

  int bits_;
  Range range_;
  std::string note_;
  bool said_misfit_ = false;  // of what the user says and the images have
};

}  // namespace sprout
