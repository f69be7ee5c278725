#ifndef SPROUT_COMMON_APP_SERVICE_H_
#define SPROUT_COMMON_APP_SERVICE_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/app/plug.h"
#include "common/app/program.h"
#include "common/config/config.h"
#include "common/config/frame_range.h"

namespace sprout {

/// A run over logs instead of the live bus.
struct ReplayOptions {
  std::vector<std::string> logs;  ///< to read, at least one
  std::string record;             ///< log to write
  FrameRange frames;              ///< frames to work on
};

/// What the shared main hands to a service.
struct ServiceContext {
  std::string stage;                    ///< "refine", ...
  SproutConfig config;                  ///< effective: files, then flags
  std::string lcm_url;                  ///< how to reach the bus
  std::string prefix;                   ///< before every channel name
  std::optional<ReplayOptions> replay;  ///< only after Service::OfferReplay()
  std::stop_token stop;                 ///< requested by SIGINT and SIGTERM
};

/// What every service's main shares: the flags --config --lcm-url --channel-prefix --threads --simd
/// --log-level --version --help, logging to stderr, the effective configuration printed at start,
/// signals, and errors turned into one line and an exit code.
class Service {
 public:
  /// @param stage        name of the service; the program is sprout-STAGE.
  /// @param description  what --help says first.
  Service(std::string stage, const std::string& description);

  /// To add flags of the service's own.
  CLI::App& flags() { return flags_; }

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
  std::vector<std::string> config_files_;
  std::string lcm_url_;
  std::string prefix_;
  std::string log_level_ = "info";
  int threads_ = 0;
  std::string simd_ = "best";
  std::vector<std::string> replay_;
  std::string record_;
  std::string frames_;
  CLI::App flags_;
};

/// Creates the plug of a stage from the effective configuration.
using MakePlug = std::function<std::unique_ptr<Plug>(const SproutConfig&)>;

/// The whole main of a service that is one plug: runs it live until a signal comes, or over logs
/// (--replay).
int RunStage(int argc, char** argv, const std::string& stage, const std::string& description,
             const MakePlug& make_plug);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_SERVICE_H_
