#ifndef SPROUT_SERVICES_BATCH_FRAME_COMMANDS_H_
#define SPROUT_SERVICES_BATCH_FRAME_COMMANDS_H_

#include <cstdint>
#include <filesystem>
#include <string>

#include "services/batch/manifest.h"

namespace sprout::batch {

/// Lines for a shell that show a frame of a log in sprout-view, and that compute it again with each
/// variant. Names are quoted, whatever they contain.
/// @param programs  folder of sprout-view.
std::string FrameCommands(const BatchFolder& folder, const BatchHead& head, const BatchLog& log,
                          int64_t seq, const std::filesystem::path& programs);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_FRAME_COMMANDS_H_
