#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "common/core/frame.h"

namespace sprout::calibrate {

/// Number of messages on a channel of a log. @throws LogError for a file that is no log.
int64_t CountMessages(const std::filesystem::path& path, const std::string& channel);

/// Reads the frames of a log that have all of `parts`, see WholeFrames.
/// @param prefix  before SPROUT_LEFT and so on.
/// @returns what could not be read, one line, or nothing.
/// @throws LogError for a file that is no log; ConfigError for one without a complete frame, which
///         lists what it has.
std::string ReadFrameLog(const std::filesystem::path& path, const std::string& prefix,
                         PartSet parts, const std::function<void(const Frame&)>& visit);

}  // namespace sprout::calibrate
