#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <string>
#include <string_view>

#include "common/app/flags.h"
#include "common/app/program.h"
#include "common/config/left_out.h"
#include "services/sprout/programs.h"

namespace sprout {
namespace {

constexpr char kDescription[] =
    "Finds the other programs: `sprout log info run.lcm` runs `sprout-log info run.lcm`";

constexpr char kFooter[] = R"(
Examples
  sprout pipeline files left.png right.png --focal-px 1733 --baseline-m 0.11 --out out
  sprout log info run.lcm
  sprout log --help         what a program does, its commands and flags
)";

bool IsProgram(const std::string& name) {
  return std::ranges::find(kPrograms, name, &ProgramSummary::name) != std::end(kPrograms);
}

// Becomes the program beside this one. @returns exit code if there is none.
int Become(const std::string& name, char** arguments) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string path = (self.parent_path() / ("sprout-" + name)).string();
  std::string as_called = "sprout-" + name;
  arguments[0] = as_called.data();
  execv(path.c_str(), arguments);
  std::cerr << "sprout: cannot run " << path << ": " << std::strerror(errno) << "\n";
  return 1;
}

int Main(int argc, char** argv) {
  if (argc > 1 && IsProgram(argv[1])) return Become(argv[1], argv + 1);
  for (const LeftOutProgram& one : kLeftOutPrograms) {
    if (argc < 2 || one.name != std::string_view(argv[1])) continue;
    std::cerr << LeftOut(std::string("sprout: ") + one.name, one.part).what() << "\n";
    return 2;
  }
  Flags flags("sprout", kDescription);
  for (const ProgramSummary& one : kPrograms) flags.AddCommand(one.name, one.text);
  flags.SetFooter(kFooter);
  const char* const help[] = {"sprout", "--help"};
  return argc > 1 ? RunProgram(flags, argc, argv, [] { return 0; })
                  : RunProgram(flags, 2, help, [] { return 0; });
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
