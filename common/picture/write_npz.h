#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// An array of NumPy: its name in the archive, type ("<f4"), and content in row order.
struct NpzArray {
  std::string name;
  std::string type;
  std::vector<int64_t> shape;  ///< none: a single number
  std::vector<std::byte> bytes;
};

/// A map of one channel: 8 bits, 16 bits or float.
NpzArray NpzOf(const std::string& name, const cv::Mat& map);

NpzArray NpzOf(const std::string& name, std::span<const double> numbers,
               std::vector<int64_t> shape);
NpzArray NpzOf(const std::string& name, int64_t number);

/// Writes what numpy.load() reads: a ZIP archive of arrays, not compressed, the whole file or none
/// (see OutputFile). The same bytes for the same arrays: it names no time.
/// @returns path and reason of a failure; arrays of 4 GB and more are refused.
[[nodiscard]] Result<void> WriteNpz(const std::filesystem::path& path,
                                    const std::vector<NpzArray>& arrays);

}  // namespace sprout
