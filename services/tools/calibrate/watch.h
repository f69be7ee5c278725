#pragma once

#include <filesystem>
#include <string>

#include "services/tools/calibrate/board.h"

namespace sprout::calibrate {

struct WatchOptions {
  std::filesystem::path out;  ///< folder; views already in it count
  std::string prefix;         ///< of the graph's channels
  std::string lcm_url;
};

/// Searches the raw images on the bus for the board. At every view that it keeps it prints what the
/// views cover and what is missing, and writes them to a folder for `estimate`. Ends with SIGINT or
/// SIGTERM, or when nothing is missing.
/// @returns exit code: 0 nothing is missing; 1 something is.
/// @throws ConfigError for a URL or a folder that cannot be used, BusError.
int RunWatch(const Board& board, const WatchOptions& options);

/// What to do with the views: a line for a shell that works when pasted. It names the rig file of
/// this folder only if there is one.
std::string EstimateCommand(const Board& board, const std::filesystem::path& folder);

}  // namespace sprout::calibrate
