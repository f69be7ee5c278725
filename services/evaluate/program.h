#ifndef SPROUT_SERVICES_EVALUATE_PROGRAM_H_
#define SPROUT_SERVICES_EVALUATE_PROGRAM_H_

namespace sprout {

/// The main of sprout-evaluate: flags in, tables on stdout, files where the flags say.
/// @returns exit code: 0; 2 for flags, scenes, configurations and outputs that cannot be used,
/// which
///          is found out before anything is run; 1 for any other failure. Both with one line on
///          stderr.
int EvaluateMain(int argc, const char* const* argv);

}  // namespace sprout

#endif  // SPROUT_SERVICES_EVALUATE_PROGRAM_H_
