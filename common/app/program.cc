#include "common/app/program.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string_view>

#include "common/app/help_text.h"
#include "common/app/limits_text.h"
#include "common/config/config_error.h"

namespace sprout {

CLI::Validator NumberIn(double low, double high) {
  std::ostringstream allowed;
  allowed << "a number from " << low << " to " << high;
  return {[=, text_of_allowed = allowed.str()](const std::string& text) -> std::string {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            const bool is_number = end != text.c_str() && *end == '\0';
            if (is_number && value >= low && value <= high) return {};
            return "'" + text + "' is not allowed: " + text_of_allowed;
          },
          allowed.str()};
}

namespace {

// No prefix is a prefix like others; COMMAND is another program's.
constexpr std::array<std::string_view, 2> kMayBeEmpty = {"--channel-prefix", "COMMAND"};

// An empty text means what no flag means, and that is not what `--log "$FILE"` asks for when FILE
// is not set.
void RequireNoEmptyText(const CLI::App& flags) {
  for (const CLI::Option* option : flags.get_options()) {
    const std::string name = option->get_name();
    const std::vector<std::string>& texts = option->results();
    if (std::find(texts.begin(), texts.end(), "") == texts.end()) continue;
    if (std::find(kMayBeEmpty.begin(), kMayBeEmpty.end(), name) != kMayBeEmpty.end()) continue;
    throw ConfigError(name + " '': allowed is a text that is not empty");
  }
  for (const CLI::App* subcommand : flags.get_subcommands()) RequireNoEmptyText(*subcommand);
}

int RunBody(CLI::App& flags, int argc, const char* const* argv, const std::function<int()>& body) {
  try {
    WrapHelp(flags);
    flags.parse(argc, argv);
    RequireNoEmptyText(flags);
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
    std::cerr << flags.get_name() << ": " << e.what() << ReachedLimitText(e) << "\n";
    return 1;
  }
}

}  // namespace

int RunProgram(CLI::App& flags, int argc, const char* const* argv,
               const std::function<int()>& body) {
  const int exit_code = RunBody(flags, argc, argv, body);
  if (std::cout.flush()) return exit_code;
  std::cerr << flags.get_name() << ": cannot write to stdout\n";  // a full disk
  return exit_code == 0 ? 1 : exit_code;
}

}  // namespace sprout
