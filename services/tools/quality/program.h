#pragma once

namespace sprout::quality {

/// The main of sprout-quality: figures on stdout, files where the flags say.
/// @returns exit code: 0; 1 a limit is not kept, nothing could be measured, or any other failure; 2
///          for flags, files and regions that cannot be used. The latter two with one line on
///          stderr.
int QualityMain(int argc, const char* const* argv);

}  // namespace sprout::quality
