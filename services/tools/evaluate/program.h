#pragma once

#include "services/tools/evaluate/log_evaluation.h"

namespace sprout::evaluate {

/// The main of sprout-evaluate: flags in, tables on stdout, files where the flags say.
/// @returns exit code: 0; 2 for flags, scenes, configurations and outputs that cannot be used,
/// which are checked before anything is run; 1 for any other failure. Both with one line on
///          stderr.
/// @param read_log  for --log.
int EvaluateMain(int argc, const char* const* argv, const ReadLog& read_log);

}  // namespace sprout::evaluate
