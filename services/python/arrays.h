#pragma once

#include <pybind11/numpy.h>

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"
#include "common/picture/read_image.h"

namespace sprout::python {

namespace py = pybind11;

// The border between NumPy's arrays and OpenCV's matrices. In: pixels are shared where the array is
// contiguous and of the type that is worked on, and the matrix keeps the array alive; other arrays
// are converted where no value changes by more than the rounding of a float. Out: the array shares
// the matrix' pixels and keeps them alive; a matrix that came from an array gives that array back.
// What does not fit is a ValueError that names the argument, and type and shape, expected and
// given.

/// repr(), but of an array, too, one line.
std::string ReprInOneLine(const py::handle& given);

/// @throws pybind11::value_error "NAME: expected EXPECTED, given a float64 array of shape (2, 3)".
[[noreturn]] void Refuse(const std::string& name, const std::string& expected,
                         const py::handle& given);

/// The array; of numpy.ma, with NaN for what it masks, or 0 where its numbers are whole.
py::array Unmasked(const py::array& array);

/// An image of one or three (BGR) channels, from uint8 or uint16 (H, W), (H, W, 1) or (H, W, 3);
/// for EightBits.
/// @param size  that it must have; nothing: any.
CameraImage TakeCameraImage(const std::string& name, const py::handle& array,
                            std::optional<cv::Size> size);

/// Depths in m from float32 or float64 in m, or uint16 in mm, (H, W).
cv::Mat1f TakeDepth(const std::string& name, const py::handle& array, std::optional<cv::Size> size);

/// Numbers from float32 or float64, (H, W).
cv::Mat1f TakeFloats(const std::string& name, const py::handle& array,
                     std::optional<cv::Size> size);

/// Disparities from float32 or float64, (H, W), px; NaN or infinite: none.
/// @throws pybind11::value_error also for what no map holds, beyond DisparityImage::kMaxPx.
DisparityImage TakeDisparities(const std::string& name, const py::handle& array,
                               std::optional<cv::Size> size);

/// A standard deviation in px to counts of 1/16 px; NaN: kMaxSigmaCounts.
/// @throws pybind11::value_error for a negative one.
uint8_t TakeSigma(const std::string& name, double sigma_px);

/// Standard deviations as TakeSigma() takes each.
cv::Mat1b TakeSigmas(const std::string& name, const py::handle& array,
                     std::optional<cv::Size> size);

/// Bytes from uint8, or of a mask from bool (True: 255), (H, W).
cv::Mat1b TakeBytes(const std::string& name, const py::handle& array, std::optional<cv::Size> size,
                    bool mask = false);

/// Argument tof: None, an array as TakeDepth() takes it, or a Tof.
/// @param size  of the rig's ToF camera; 0×0: it has none.
TofImage TakeTof(const py::handle& given, cv::Size size);

/// Seeds from an array of SEED, (N,).
std::vector<Seed> TakeSeeds(const std::string& name, const py::handle& array);

/// Pixels of an 8UC1, 8UC3, 16SC1 or 32FC1 matrix, (H, W) or (H, W, 3); None when it is empty.
py::object ToArray(const cv::Mat& image);

/// Disparities in px, NaN: none, (H, W). O(pixels).
py::object ToArray(const DisparityImage& disparity);

/// Structured, (N,) of SEED.
py::array ToArray(const std::vector<Seed>& seeds);

/// Standard deviations in px, (H, W), of counts of 1/16 px. O(pixels).
py::object SigmaArray(const cv::Mat1b& counts);

}  // namespace sprout::python
