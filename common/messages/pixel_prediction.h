#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sprout {

/// Classes of pixels by how much their neighbours differ: where they differ much, errors are large.
inline constexpr size_t kPixelClasses = 4;

/// Errors of prediction of one channel, class by class.
using ClassedErrors = std::array<std::span<const uint8_t>, kPixelClasses>;

/// Predicts each pixel of an image from its neighbours, as packed_t describes it. Keeps its memory
/// from image to image.
class PixelPredictor {
 public:
  /// @param pixels    rows of `width` pixels of `channels` bytes, 1 or 3.
  /// @returns of each channel; valid until the next call.
  std::vector<ClassedErrors> Predict(std::span<const uint8_t> pixels, size_t width,
                                     size_t channels);

 private:
  void Reserve(size_t pixels, size_t channels);

  size_t reserved_ = 0;                             // bytes of each of the buffers
  std::vector<std::unique_ptr<uint8_t[]>> errors_;  // by channel and class
};

/// The inverse.
/// @param pixels  gets the image: whole rows of `width` pixels.
/// @returns false when a class has too few or too many errors.
bool Reconstruct(std::span<const ClassedErrors> errors, size_t width, std::span<uint8_t> pixels);

}  // namespace sprout
