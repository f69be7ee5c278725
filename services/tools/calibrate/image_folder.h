#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_IMAGE_FOLDER_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_IMAGE_FOLDER_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/rig/rectifier.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

/// Reads the triplets of a folder: left_NAME.png and right_NAME.png, or left01.png and
/// right01.png (or any other of kCameraFormats; grey or colour, 8 or 16 bits), which PairNames()
/// joins, and if there is a ToF camera tof_amplitude_NAME (one channel, any unit) and
/// tof_depth_NAME (see scenes::ReadRangeFile()) of the left one's NAME.
/// @param bits  see EightBits.
/// @returns what a user should know, one line each: images without a partner, how bits were used.
/// @throws ConfigError naming a file that cannot be used, or the folder when there is no triplet.
std::vector<std::string> ReadImageFolder(const std::filesystem::path& folder, int bits,
                                         const std::function<void(const RigImages&)>& visit);

/// Writes a triplet as ReadImageFolder() reads it: left and right as .png, ToF as .tiff.
/// @throws std::runtime_error naming a file that cannot be written.
void WriteImages(const std::filesystem::path& folder, const std::string& name,
                 const RigImages& images);

/// Number of messages on a channel of a log. @throws LogError for a file that is no log.
int64_t CountMessages(const std::filesystem::path& path, const std::string& channel);

/// Reads the frames of a log that have all of `parts`, see WholeFrames.
/// @param prefix  before SPROUT_LEFT and so on.
/// @returns what could not be read, one line, or nothing.
/// @throws LogError for a file that is no log; ConfigError for one without a complete frame, which
///         lists what it has.
std::string ReadFrameLog(const std::filesystem::path& path, const std::string& prefix,
                         PartSet parts, const std::function<void(const Frame&)>& visit);

/// A triplet as the cameras gave it, rectified, and without the bias of its ranges. O(pixels).
/// @returns an error when sizes do not fit the calibration.
Result<RigImages> RectifyImages(const Rectifier& rectifier, const RigImages& images);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_IMAGE_FOLDER_H_
