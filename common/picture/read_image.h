#pragma once

#include <filesystem>
#include <initializer_list>
#include <opencv2/core.hpp>

#include "common/core/result.h"

namespace sprout {

enum class ImageFormat { kPng, kJpeg, kPnm, kBmp, kTiff };

/// PNG, JPEG, PGM and PPM: formats of data sets.
inline constexpr std::initializer_list<ImageFormat> kPictureFormats = {
    ImageFormat::kPng, ImageFormat::kJpeg, ImageFormat::kPnm};

/// The same, and formats that cameras' own programs write.
inline constexpr std::initializer_list<ImageFormat> kCameraFormats = {
    ImageFormat::kPng, ImageFormat::kJpeg, ImageFormat::kPnm, ImageFormat::kBmp,
    ImageFormat::kTiff};

/// Decodes an image, with the pixels as in the file. Format and size are read from the first bytes
/// and the header and checked before OpenCV decodes it: a small file may claim any size.
/// @param flags  cv::imread()'s.
/// @returns the image, or "image PATH: " and what is wrong with it: not of the formats, missing,
///          unreadable, cut, larger than kMaxSide or kMaxPixels.
Result<cv::Mat> DecodeImageFile(const std::filesystem::path& path, int flags,
                                std::initializer_list<ImageFormat> formats);

/// An image as a camera gave it, before it has 8 bits a pixel (see EightBits).
struct CameraImage {
  cv::Mat pixels;  ///< grey or BGR, 8 or 16 bits
  int largest =
      0;  ///< value that a pixel can have by the format (PGM's maxval); 0: it does not say
};

/// Reads the image of a camera in any of kCameraFormats; alpha is dropped.
/// @returns as DecodeImageFile(); also an error for floating point.
Result<CameraImage> ReadCameraImage(const std::filesystem::path& path);

}  // namespace sprout
