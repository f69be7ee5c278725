#pragma once

#include <span>

namespace sprout {

struct ProgramSummary {
  const char* name;  ///< without "sprout-"
  const char* text;  ///< what it does, in a line
};

/// All programs that were built together with this one; of sprout_service() in their
/// CMakeLists.txt.
std::span<const ProgramSummary> Programs();

struct LeftOutProgram {
  const char* name;  ///< without "sprout-"
  const char* part;  ///< that was not built: of LeftOut()
};

/// The programs that this build leaves out.
std::span<const LeftOutProgram> LeftOutPrograms();

}  // namespace sprout
