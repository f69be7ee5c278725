#include "services/tools/check/program_check.h"

#include <fmt/core.h>

#include <csignal>
#include <cstdlib>
#include <ostream>

#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/messages/codec.h"

namespace sprout::check {
namespace {

constexpr std::chrono::seconds kEndTimeout{5};
constexpr int kCannotBeStarted = 127;

// The last lines that the program wrote.
std::string LastLines(const std::string& output) {
  constexpr int kLines = 8;
  constexpr size_t kMaxBytes = 8000;  // it may have written a line without end
  if (output.size() > kMaxBytes) return LastLines(output.substr(output.size() - kMaxBytes));
  size_t begin = output.size();
  for (int line = 0; line <= kLines && begin != std::string::npos && begin > 0; ++line) {
    begin = output.rfind('\n', begin - 1);
  }
  return begin == std::string::npos || begin == 0 ? output : output.substr(begin + 1);
}

}  // namespace

BusConnection::BusConnection(const std::string& url)
    : publisher_(url, ""),
      receiver_(url, "", {Receiver::kAllChannels},
                [this](std::string_view channel, std::span<const uint8_t> bytes) {
                  const auto now = std::chrono::steady_clock::now();
                  {
                    const std::lock_guard lock(mutex_);
                    heard_.push_back({std::string(channel), {bytes.begin(), bytes.end()}, now});
                  }
                  filled_.notify_one();
                }) {}

void BusConnection::Send(std::string_view channel, std::span<const uint8_t> bytes) {
  if (!publisher_.Publish(channel, bytes)) throw BusError(publisher_.failure());
}

std::optional<Heard> BusConnection::Next(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  if (!filled_.wait_until(lock, deadline, [this] { return !heard_.empty(); })) return std::nullopt;
  Heard first = std::move(heard_.front());
  heard_.pop_front();
  return first;
}

int CheckProgram(const std::vector<std::string>& command, const std::string& lcm_url,
                 std::span<const Rule> rules, const ProgramSteps& steps, std::ostream& out) {
  Findings found;
  setenv("LCM_DEFAULT_URL", lcm_url.c_str(), 1);  // for the program
  Process process(command);
  const std::string figures = steps(process, found);
  if (process.Wait(std::chrono::seconds(0)) == kCannotBeStarted) {
    throw ConfigError("'" + command[0] + "' cannot be started");
  }
  found.Print(rules, out);
  out << figures;
  if (found.empty()) return 0;
  if (const std::string said = LastLines(process.Output()); !said.empty()) {
    out << "what the program wrote last:\n" << said;
  }
  return 1;
}

std::optional<std::string> HowItEnded(Process& process) {
  const std::optional<int> code = process.Wait(std::chrono::seconds(0));
  if (!code) return std::nullopt;
  if (*code > 128) return fmt::format("was killed by signal {}", *code - 128);
  if (*code == kCannotBeStarted) return "could not be started";
  return fmt::format("ended with exit code {}", *code);
}

void CheckEnd(Process& process, Findings& found) {
  found.Checked(Rule::kEnd);
  process.Signal(SIGTERM);
  if (!process.Wait(kEndTimeout)) {
    found.Add(Rule::kEnd, fmt::format("still there after {} s", kEndTimeout.count()));
  }
}

bool CheckReport(const Heard& heard, Findings& found) {
  if (heard.channel == kStatusChannel) {
    const Result<StageStatus> status = DecodeStatus(heard.bytes);
    if (!status) found.Add(Rule::kChannels, heard.channel + ": " + status.error().text);
    return true;
  }
  if (heard.channel == kProcessChannel) {
    const Result<ProcessInfo> info = DecodeProcessInfo(heard.bytes);
    if (!info) found.Add(Rule::kChannels, heard.channel + ": " + info.error().text);
    return true;
  }
  return false;
}

}  // namespace sprout::check
