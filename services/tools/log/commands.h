#ifndef SPROUT_SERVICES_TOOLS_LOG_COMMANDS_H_
#define SPROUT_SERVICES_TOOLS_LOG_COMMANDS_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/config/frame_range.h"

// The subcommands of sprout-log. Each reads whole logs in constant memory (except for some hundred
// bytes a frame or message, see README.md), prints to stdout, and returns the program's exit code.
// @throws LogError for a log that cannot be used, ConfigError for flags that cannot be used,
// Interrupted after Ctrl-C. Output files are written with OutputFile.
namespace sprout::log {

struct InfoOptions {
  std::filesystem::path file;
  std::string prefix;
  bool json = false;
  bool config = false;  ///< also the effective configurations
  bool check = false;   ///< exit code 1 when anything is damaged, undecodable or missing
};
int RunInfo(const InfoOptions& options);

struct DiffOptions {
  std::filesystem::path a;
  std::filesystem::path b;
  std::vector<std::string>
      channels;  ///< without prefix; none: all but SPROUT_STATUS and SPROUT_PROCESS
  std::string prefix;
  bool common = false;           ///< messages in only one log are counted, but are no difference
  bool all = false;              ///< a line for every frame, also for equal ones
  std::filesystem::path images;  ///< folder for pictures of differences; empty: none
};
/// @returns 0 equal, 1 different. @throws LogError also when there is nothing to compare.
int RunDiff(const DiffOptions& options);

struct CutOptions {
  std::filesystem::path in;
  std::filesystem::path out;
  std::string frames;                 ///< see ParseFrameRange(); empty: all
  int64_t warm_up = 0;                ///< frames before them that are kept, too
  std::vector<std::string> channels;  ///< without prefix; none: all
  std::string prefix;
  bool force = false;
};
int RunCut(const CutOptions& options);

struct MergeOptions {
  std::vector<std::filesystem::path> in;
  std::filesystem::path out;
  bool replace = false;  ///< a channel of frames is taken from the last log that has it
  bool force = false;
};
/// @throws LogError for two answers for one frame, unless `replace`.
int RunMerge(const MergeOptions& options);

struct RepairOptions {
  std::filesystem::path in;
  std::filesystem::path out;
  bool drop_undecodable = false;
  bool force = false;
};
int RunRepair(const RepairOptions& options);

struct CompressOptions {
  std::filesystem::path in;
  std::filesystem::path out;
  std::optional<int> jpeg_quality;  ///< nothing: without loss
  bool force = false;
};
/// Images, maps, seeds and points in fewer bytes. @throws LogError also for a damaged log.
int RunCompress(const CompressOptions& options);

struct ExpandOptions {
  std::filesystem::path in;
  std::filesystem::path out;
  bool force = false;
};
/// The inverse, to the byte, but for JPEG. @throws LogError also for a damaged log.
int RunExpand(const ExpandOptions& options);

struct PicturesOptions {
  std::filesystem::path file;
  std::filesystem::path folder;
  std::string frames;  ///< see ParseFrameRange(); empty: all
  std::string prefix;
};

struct ImagesOptions : PicturesOptions {
  std::string truth;  ///< the source that capture sent, for its ground truth; empty: none
};
int RunImages(const ImagesOptions& options);

/// @pre `folder` is for the pictures of the worst frames; empty: none.
struct RankOptions : PicturesOptions {
  std::string by = "score";  ///< name of a QualityColumn
  int top = 0;  ///< most frames listed; 0: 20 in the table and as pictures, all in files
  bool csv = false;
  bool json = false;
};
int RunRank(const RankOptions& options);

struct ExportOptions : PicturesOptions {
  bool ply = false;    ///< point clouds
  bool mesh = false;   ///< surfaces
  bool pfm = false;    ///< maps
  bool depth = false;  ///< depth.png, and the intrinsics
  bool npz = false;    ///< depth, disparity, confidence and K for NumPy
};
int RunExport(const ExportOptions& options);

/// A log as ROS 2's messages in an MCAP file: the topics of sprout-ros2.
struct McapExportOptions {
  std::filesystem::path file;
  std::filesystem::path out;
  std::string frames;  ///< see ParseFrameRange(); empty: all
  std::string prefix;
  bool force = false;
};
int RunMcapExport(const McapExportOptions& options);

/// Whether a file is none of LCM's, but MCAP: packed or not, or a folder with the parts of a bag.
bool IsMcap(const std::filesystem::path& file);
/// RunInfo() of such a file: topics, types, counts.
int RunMcapInfo(const InfoOptions& options);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_COMMANDS_H_
