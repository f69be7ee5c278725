#ifndef SPROUT_SERVICES_CALIBRATE_RAW_LOG_H_
#define SPROUT_SERVICES_CALIBRATE_RAW_LOG_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "services/calibrate/board_view.h"

namespace sprout {

/// Reads the triplets of a log of unrectified images, as sprout-capture --raw sends them, in
/// constant memory.
/// @param prefix  before RAW_SPROUT_LEFT and so on.
/// @param visit   gets each triplet and its time, µs.
/// @returns what could not be read, one line, or nothing.
/// @throws LogError for a file that is no log; ConfigError for one without a whole triplet, which
///         says what it has.
std::string ReadRawLog(const std::filesystem::path& path, const std::string& prefix,
                       const std::function<void(const RigImages&, int64_t)>& visit);

}  // namespace sprout

#endif  // SPROUT_SERVICES_CALIBRATE_RAW_LOG_H_
