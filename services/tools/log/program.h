#pragma once

namespace sprout::log {

/// The main of sprout-log.
/// @returns exit code: 0; 1 when a diff finds differences or info --check something wrong, and for
///          any other failure; 2 for flags and logs that cannot be used, with one line on stderr;
///          130 after Ctrl-C.
int LogMain(int argc, const char* const* argv);

}  // namespace sprout::log
