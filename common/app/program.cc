#include "common/app/program.h"

#include <iostream>

#include "common/app/version.h"
#include "common/config/config.h"

namespace sprout {

std::string Version() { return kVersion; }

int RunProgram(CLI::App& flags, int argc, const char* const* argv,
               const std::function<int()>& body) {
  try {
    flags.parse(argc, argv);
    return body();
  } catch (const CLI::Success& e) {  // --help, --version
    return flags.exit(e);
  } catch (const CLI::ParseError& e) {
    std::cerr << flags.get_name() << ": " << e.what() << " (--help lists the flags)\n";
    return 2;
  } catch (const ConfigError& e) {
    std::cerr << flags.get_name() << ": " << e.what() << "\n";
    return 2;
  } catch (const std::exception& e) {
    std::cerr << flags.get_name() << ": " << e.what() << "\n";
    return 1;
  }
}

}  // namespace sprout
