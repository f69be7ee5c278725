#include "common/app/program.h"

#include <iostream>

#include "common/app/limits_text.h"
#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/printable.h"

namespace sprout {
namespace {

int RunBody(Flags& flags, int argc, const char* const* argv, const std::function<int()>& body) {
  try {
    return flags.Parse(argc, argv) ? body() : 0;
  } catch (const ConfigError& e) {
    std::cerr << flags.program() << ": " << Printable(e.what()) << "\n";
    return 2;
  } catch (const std::exception& e) {
    std::cerr << flags.program() << ": " << Printable(e.what()) << ReachedLimitText(e) << "\n";
    return 1;
  }
}

}  // namespace

int RunProgram(Flags& flags, int argc, const char* const* argv, const std::function<int()>& body) {
  const InputFileGuard guard;
  const int exit_code = RunBody(flags, argc, argv, body);
  if (std::cout.flush()) return exit_code;
  std::cerr << flags.program() << ": cannot write to stdout\n";  // a full disk
  return exit_code == 0 ? 1 : exit_code;
}

}  // namespace sprout
