#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <iosfwd>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/process.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "services/tools/check/contract.h"

namespace sprout::check {

/// A received message of the graph.
struct Heard {
  std::string channel;
  std::vector<uint8_t> bytes;
  std::chrono::steady_clock::time_point when;
};

/// Sends on the bus, and receives all that is on it, its own messages, too. Not thread-safe.
class BusConnection {
 public:
  /// @throws BusError, see OpenLcm().
  explicit BusConnection(const std::string& url);

  /// @throws BusError when LCM refuses the message.
  void Send(std::string_view channel, std::span<const uint8_t> bytes);

  /// The next message, in order of arrival; nothing when none comes before `deadline`.
  std::optional<Heard> Next(std::chrono::steady_clock::time_point deadline);

 private:
  std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Heard> heard_;
  Publisher publisher_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

/// How soon the end of a program is noticed.
inline constexpr std::chrono::milliseconds kPoll{100};

/// Checks a running program, and ends it.
/// @returns figures about it for people, whole lines; may be empty.
using ProgramSteps = std::function<std::string(Process& process, Findings& found)>;

/// Starts a program, runs a check on it, and prints the findings.
///
/// @param command  program and arguments.
/// @param lcm_url  the bus; the program gets it as LCM_DEFAULT_URL.
/// @param rules    to print.
/// @returns exit code: 0; 1 when something is wrong with the program.
/// @throws ConfigError when it cannot be started.
int CheckProgram(const std::vector<std::string>& command, const std::string& lcm_url,
                 std::span<const Rule> rules, const ProgramSteps& steps, std::ostream& out);

/// "ended with exit code 3", "was killed by signal 6"; nothing while the program runs.
std::optional<std::string> HowItEnded(Process& process);

/// Asks the program to end; checks Rule::kEnd.
void CheckEnd(Process& process, Findings& found);

/// Checks a message on SPROUT_STATUS or SPROUT_PROCESS, which every program may send.
/// @returns whether it was one.
bool CheckReport(const Heard& heard, Findings& found);

}  // namespace sprout::check
