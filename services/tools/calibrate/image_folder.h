#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

/// Reads the triplets of a folder: left_NAME.png and right_NAME.png (or left-NAME.png), or
/// left01.png and right01.png, or without ToF images those in its folders left and right (or any
/// other of kCameraFormats; grey or colour, 8 or 16 bits), which PairNames() joins, and if there is
/// a ToF camera tof_amplitude_NAME (one channel, any unit) and tof_depth_NAME (see
/// scenes::ReadRangeFile()) of the left one's NAME.
/// @param bits  see EightBits.
/// @returns what a user should know, one line each: images without a partner, how bits were used.
/// @throws ConfigError naming a file that cannot be used, or the folder when there is no triplet.
std::vector<std::string> ReadImageFolder(const std::filesystem::path& folder, int bits,
                                         const std::function<void(const RigImages&)>& visit);

/// Writes a triplet as ReadImageFolder() reads it: left and right as .png, ToF as .tiff.
/// @throws std::runtime_error naming a file that cannot be written, and the reason.
void WriteImages(const std::filesystem::path& folder, const std::string& name,
                 const RigImages& images);

}  // namespace sprout::calibrate
