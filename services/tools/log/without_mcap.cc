// Takes the place of mcap.cc in a build without ROS 2 and MCAP.
#include "common/config/left_out.h"
#include "services/tools/log/commands.h"

namespace sprout::log {

int RunMcapExport(const PicturesOptions&, const std::filesystem::path&, bool) {
  throw LeftOut("--mcap", "ROS2");
}

bool IsMcap(const std::filesystem::path& file) {
  const std::string name = file.string();
  return name.ends_with(".mcap") || name.ends_with(".mcap.zstd");
}

int RunMcapInfo(const InfoOptions& options) { throw LeftOut(options.file.string(), "ROS2"); }

}  // namespace sprout::log
