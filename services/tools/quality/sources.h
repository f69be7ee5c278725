#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/core/frame.h"
#include "services/tools/quality/verdict.h"

namespace sprout::quality {

// Where maps come from. Each takes `count` of the settings of the measurement.

/// Adds the disparity map of a frame, with its calibration, and with its standard deviations when
/// it has some.
/// @pre the frame has a disparity map.
void AddFrame(const Frame& frame, Measurement& measurement);

/// Adds the first maps of a log.
/// @param frames  "A:B", or empty: all.
/// @returns what could not be read, one line, or nothing.
/// @throws LogError; ConfigError for a log without a map that can be measured, which says what it
///         has instead; Interrupted.
std::string MeasureLog(const std::filesystem::path& log, const std::string& prefix,
                       const std::string& frames, Measurement& measurement);

/// Adds the first maps of a folder by name, in px: those that end in disparity.pfm, or, when none
/// does, all *.pfm, or else the disparity.pfm of its folders, as `sprout-pipeline files` writes
/// them.
/// @param calibration  file in Middlebury's format (cam0, cam1, baseline); empty: calib.txt
///                     beside the map, or in the folder.
/// @throws ConfigError naming the file for what cannot be read, and for a folder without maps;
///         Interrupted.
void MeasureFolder(const std::filesystem::path& folder, const std::filesystem::path& calibration,
                   Measurement& measurement);

/// Notes what MeasureFolder() would read as inputs, which nothing may replace. See input_files.h.
void NoteFolderFiles(const std::filesystem::path& folder, const std::filesystem::path& calibration);

struct LiveOptions {
  std::string lcm_url;
  std::string prefix;
  bool once = false;  ///< ends when `count` maps are measured
};

/// Adds the maps of a running graph until SIGINT or SIGTERM; of maps that come faster than they are
/// measured the newest.
/// @param refresh  is called about once a second, when there is something new.
/// @throws BusError; ConfigError for a URL that cannot be used; std::runtime_error when no map
/// came:
///         with `once` in kPatience, else at all.
void MeasureGraph(const LiveOptions& options, Measurement& measurement,
                  const std::function<void()>& refresh);

}  // namespace sprout::quality
