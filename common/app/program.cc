#include "common/app/program.h"

#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <new>
#include <optional>
#include <string_view>
#include <system_error>

#include "common/app/version.h"
#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/printable.h"
#include "common/logfile/log_error.h"

namespace sprout {
namespace {

int RunBody(Flags& flags, int argc, const char* const* argv, const std::function<int()>& body) {
  flags.AddVersion(Version());
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

constexpr uint64_t kMegabyte = uint64_t{1} << 20;

// A stack of a thread, or a large picture.
constexpr uint64_t kLargePiece = 16 * kMegabyte;

std::optional<uint64_t> LimitOf(decltype(RLIMIT_AS) which) {
  rlimit limit{};
  if (getrlimit(which, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

// The largest address space so far: by now the threads and pictures of what failed are gone.
uint64_t MostAddressSpaceBytes() {
  std::ifstream status("/proc/self/status");
  std::string name;
  while (status >> name && name != "VmPeak:") status.ignore(1 << 10, '\n');
  uint64_t kilobytes = 0;
  status >> kilobytes;
  return kilobytes << 10;
}

std::optional<std::string> AddressSpaceText() {
  const std::optional<uint64_t> limit = LimitOf(RLIMIT_AS);
  const uint64_t used = MostAddressSpaceBytes();
  if (!limit || used + kLargePiece < *limit) return std::nullopt;
  return ": its address space is limited to " + std::to_string(*limit / kMegabyte) +
         " MB (ulimit -v), of which it had " + std::to_string(used / kMegabyte);
}

}  // namespace

int RunProgram(Flags& flags, int argc, const char* const* argv, const std::function<int()>& body) {
  std::signal(SIGXFSZ, SIG_IGN);  // beyond `ulimit -f`: a failed write, not the end of the process
  const InputFileGuard guard;
  const int exit_code = RunBody(flags, argc, argv, body);
  if (std::cout.flush()) return exit_code;
  std::cerr << flags.program() << ": cannot write to stdout\n";  // a full disk
  return exit_code == 0 ? 1 : exit_code;
}

void RequireChannelPrefix(const std::string& prefix) {
  if (IsChannelPrefix(prefix)) return;
  throw ConfigError("--channel-prefix '" + prefix + "': allowed are " + AllowedChannelPrefix());
}

int RefusingLogs(const std::function<int()>& body) {
  try {
    return body();
  } catch (const LogError& e) {
    throw ConfigError(e.what());
  }
}

std::string ReachedLimitText(const std::exception& failure) {
  // Recognised by its text, since each library has an exception type of its own for it.
  const bool no_thread =
      std::string_view(failure.what()).find(std::generic_category().message(EAGAIN)) !=
      std::string::npos;
  const bool no_memory = dynamic_cast<const std::bad_alloc*>(&failure) != nullptr;
  if (!no_thread && !no_memory) return "";
  if (const auto text = AddressSpaceText()) return *text;
  if (no_memory) return ": out of memory";
  const std::optional<uint64_t> tasks = LimitOf(RLIMIT_NPROC);
  const std::string own = tasks ? std::to_string(*tasks) + " of this user (ulimit -u), or " : "";
  return ": no thread can be started: allowed are " + own +
         "as many as its service or container says";
}

}  // namespace sprout
