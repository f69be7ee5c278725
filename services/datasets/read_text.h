#ifndef SPROUT_SERVICES_DATASETS_READ_TEXT_H_
#define SPROUT_SERVICES_DATASETS_READ_TEXT_H_

#include <filesystem>
#include <optional>
#include <string>

namespace sprout::datasets {

/// Text of a calibration; nothing when it is no file (but a folder, a FIFO, a device, a link to
/// itself), cannot be read, or is larger than 1 MB.
std::optional<std::string> ReadText(const std::filesystem::path& path);

}  // namespace sprout::datasets

#endif  // SPROUT_SERVICES_DATASETS_READ_TEXT_H_
