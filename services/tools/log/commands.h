#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/app/flags.h"

namespace sprout::log {

// The commands of sprout-log, each with its flags. Each reads whole logs in constant memory (except
// for some hundred bytes a frame or message, see README.md), prints to stdout, and returns the
// program's exit code. Output files are written with OutputFile.
// A command throws LogError for a log that cannot be used, ConfigError for flags that cannot be
// used, Interrupted after Ctrl-C.

void AddInfo(Flags& program);
void AddDiff(Flags& program);
void AddCut(Flags& program);
void AddMerge(Flags& program);
void AddRepair(Flags& program);
void AddCompress(Flags& program);
void AddExpand(Flags& program);
void AddImages(Flags& program);
void AddExport(Flags& program);
void AddRank(Flags& program);

// Flags that several commands have.

void AddPrefix(Flags& flags, std::string& prefix);
Flag AddFrames(Flags& flags, std::string& frames);
void AddChannels(Flags& flags, std::vector<std::string>& channels);
void AddForce(Flags& flags, bool& force);

struct InfoOptions {
  std::filesystem::path file;
  std::string prefix;
  bool json = false;
  bool config = false;  ///< also the effective configurations
  bool check = false;   ///< exit code 1 when anything is damaged, undecodable or missing
};

/// What is done with the frames of a log.
struct PicturesOptions {
  std::filesystem::path file;
  std::filesystem::path folder;
  std::string frames;  ///< see ParseFrameRange(); empty: all
  std::string prefix;
};

/// Writes a log as ROS 2's messages in an MCAP file: the topics of sprout-ros2.
int RunMcapExport(const PicturesOptions& options, const std::filesystem::path& out, bool force);

/// Whether a path is an MCAP file, also a compressed one, or a folder with the parts of a bag.
bool IsMcap(const std::filesystem::path& file);
/// The command info for an MCAP file: topics, types, counts.
int RunMcapInfo(const InfoOptions& options);

}  // namespace sprout::log
