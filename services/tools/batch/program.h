#ifndef SPROUT_SERVICES_TOOLS_BATCH_PROGRAM_H_
#define SPROUT_SERVICES_TOOLS_BATCH_PROGRAM_H_

namespace sprout::batch {

/// The whole program. @returns exit code: 0 all is done (or submitted); 1 something is missing; 2 a
/// flag or log that cannot be used; 130 after Ctrl-C.
int BatchMain(int argc, const char* const* argv);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_PROGRAM_H_
