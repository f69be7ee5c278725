#ifndef SPROUT_SERVICES_PIPELINE_FILES_FLAGS_H_
#define SPROUT_SERVICES_PIPELINE_FILES_FLAGS_H_

#include "common/app/flags.h"
#include "services/pipeline/files/files.h"

namespace sprout {

/// Adds the command `files`.
/// @param flags    of a Service that offers replay.
/// @param options  gets the values; must outlive the flags.
/// @returns the command.
Flags& AddFilesCommand(Flags& flags, FilesOptions& options);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PIPELINE_FILES_FLAGS_H_
