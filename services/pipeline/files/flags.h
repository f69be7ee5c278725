#ifndef SPROUT_SERVICES_PIPELINE_FILES_FLAGS_H_
#define SPROUT_SERVICES_PIPELINE_FILES_FLAGS_H_

#include "services/pipeline/files/files.h"

namespace CLI {
class App;  // <CLI/CLI.hpp> takes seconds to compile
}

namespace sprout {

/// Adds the command `files`.
/// @param flags    of a Service that offers replay.
/// @param options  gets the values; must outlive the flags.
/// @returns the command, which converts to true if it was given.
CLI::App& AddFilesCommand(CLI::App& flags, FilesOptions& options);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PIPELINE_FILES_FLAGS_H_
