#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/app/flags.h"
#include "common/app/service_context.h"

namespace sprout {

/// What every service's main shares: the flags --config --lcm-url --channel-prefix --threads --simd
/// --log-level --version --help, logging to stderr, the effective configuration logged at start
/// (its digest, or all of it at level debug), signals, and errors turned into one line and an exit
/// code.
class Service {
 public:
  /// @param stage        name of the service.
  /// @param description  what --help says first.
  /// @param program      that works as this stage, when it is not ours: what it logs, and its
  ///                     version in statuses and records, begin with this; empty: sprout-STAGE.
  Service(std::string stage, const std::string& description, const std::string& program = "");

  /// The service's own flags and commands are added here. A command runs without the bus.
  Flags& flags() { return flags_; }

  /// Adds the flags --replay, --record and --frames.
  void OfferReplay();

  /// Puts the service's own flags into the configuration, before it is checked and printed.
  using ApplyFlags = std::function<void(SproutConfig&)>;
  using Body = std::function<int(const ServiceContext&)>;

  /// Runs `body` until it returns.
  /// @returns exit code: what `body` returned; 2 for a flag or configuration that cannot be used
  ///          (ConfigError); 1 when the network cannot be used (BusError) or on any other failure.
  int Run(int argc, char** argv, const Body& body, const ApplyFlags& apply_flags = {});

 private:
  int RunChecked(const Body& body, const ApplyFlags& apply_flags);
  std::optional<ReplayOptions> Replay() const;

  std::string stage_;
  std::string version_;
  std::vector<std::string> config_files_;
  std::string lcm_url_;
  std::string prefix_;
  std::string log_level_ = "info";
  int threads_ = 0;
  std::string simd_ = "best";
  std::vector<std::string> replay_;
  std::string record_;
  std::string frames_;
  Flags flags_;
};

}  // namespace sprout
