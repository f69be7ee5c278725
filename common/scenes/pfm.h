#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/result.h"

namespace sprout::scenes {

bool IsFile(const std::filesystem::path& path);

/// Reads a PNG, JPEG, PGM or PPM file.
/// @param flags  cv::imread()'s.
/// @throws ConfigError with the text of DecodeImageFile().
cv::Mat ReadImage(const std::filesystem::path& path, int flags);

/// @throws ConfigError naming the file and both sizes when they differ.
/// @param expected  of the left image.
void RequireSize(const std::filesystem::path& path, cv::Size size, cv::Size expected);

/// Reads a one-channel PFM file ("Pf"), top row first, samples as stored.
///
/// cv::imread divides the samples by the scale in the header. Middlebury writes disparities in px
/// together with a scale that is meant for viewers (0.003922 in the full-size files), so the
/// division would be wrong; of the scale only the sign, the byte order, is used.
///
/// @throws ConfigError naming the file: unreadable, another format, truncated.
cv::Mat1f ReadPfm(const std::filesystem::path& path);

/// What ParseRangeUnit() reads, for messages to people.
inline constexpr char kRangeUnits[] = "mm, cm, m, 1/N or a number: metres a count (1/256, 0.00025)";

/// The unit of a range image, m: "mm", "cm", "m", "1/5000" or a number of metres; 1e-6 to 1000.
/// Nothing for other texts.
std::optional<double> ParseRangeUnit(const std::string& text);

/// Reads a range image: one channel of 16 bits (mm, where no unit is given) in any format of a
/// camera, or of floating point (m), as PFM, whatever its name, or TIFF. Pixels without a return
/// are those that IsReturn() says, in integers 0 and 65535.
/// @param unit_m  of a count, or of the number 1; nothing: as above.
/// @returns depth, m; or what is wrong, with the file's name.
Result<cv::Mat1f> ReadRangeFile(const std::filesystem::path& path,
                                std::optional<double> unit_m = {});

}  // namespace sprout::scenes
