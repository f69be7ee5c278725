#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/config/frame_range.h"

namespace sprout {

/// A run over logs instead of the live bus.
struct ReplayOptions {
  std::vector<std::string> logs;  ///< to read, at least one
  std::string record;             ///< log to write
  FrameRange frames;              ///< frames to process
};

/// What the shared main gives to a service.
struct ServiceContext {
  std::string stage;                    ///< "refine", ...
  std::string version = {};             ///< of the program, for statuses and records
  SproutConfig config;                  ///< effective: files, then flags
  std::string lcm_url;                  ///< how to reach the bus
  std::string prefix;                   ///< prepended to every channel name
  std::optional<ReplayOptions> replay;  ///< only after Service::OfferReplay()
  std::stop_token stop;                 ///< requested by SIGINT and SIGTERM
};

}  // namespace sprout
