#ifndef SPROUT_SERVICES_CALIBRATE_IMAGE_FOLDER_H_
#define SPROUT_SERVICES_CALIBRATE_IMAGE_FOLDER_H_

#include <filesystem>
#include <functional>
#include <string>

#include "services/calibrate/board_view.h"

namespace sprout::calibrate {

/// Reads the triplets of a folder, in the order of their names: left_NAME.png and right_NAME.png
/// (or JPEG, PGM, PPM, BMP, TIFF; also left01.png and right01.png), and if there is a ToF camera
/// tof_amplitude_NAME.png (or .tiff; any unit) and tof_depth_NAME (.png: 16 bits, mm, 0 = no
/// return; .tiff: 32-bit float, m).
/// @throws ConfigError naming a file that cannot be used, or the folder when there is no triplet.
void ReadImageFolder(const std::filesystem::path& folder,
                     const std::function<void(const RigImages&)>& visit);

/// Writes a triplet as ReadImageFolder() reads it: left and right as .png, ToF as .tiff.
/// @throws std::runtime_error naming a file that cannot be written.
void WriteImages(const std::filesystem::path& folder, const std::string& name,
                 const RigImages& images);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_IMAGE_FOLDER_H_
