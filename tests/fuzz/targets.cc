#include "tests/fuzz/targets.h"

#include <algorithm>
#include <stdexcept>

namespace sprout::fuzz {
namespace {

constexpr Target kTargets[] = {
    {"message", DecodeMessage, MessageSeeds},
    {"frames", JoinMessages, FrameSeeds, 8192},
    {"log", ReadWholeLog, LogSeeds, 16384},
    {"config", ReadConfig, ConfigSeeds},
    {"rig", ReadRig, RigSeeds},
    {"middlebury", ReadMiddleburyCalibration, MiddleburySeeds, 1024},
    {"kitti", ReadKitti, KittiSeeds, 2048},
    {"scan", ReadScan, ScanSeeds, 1024},
    {"pfm", ReadPfmFile, PfmSeeds, 1024},
    {"image", ReadImageFile, ImageSeeds},
    {"payload", ReadPayload, PayloadSeeds, 1024},
    {"ros2", ReadRosMessage, RosSeeds},
    {"mcap", ReadMcapFile, McapSeeds, 8192},
    {"http", AnswerHttp, HttpSeeds, 1024},
    {"page", AnswerPage, PageSeeds, 1024},
};

}  // namespace

std::span<const Target> Targets() { return kTargets; }

const Target& TargetNamed(std::string_view name) {
  const auto* found = std::ranges::find(kTargets, name, &Target::name);
  if (found != std::end(kTargets)) return *found;
  std::string names;
  for (const Target& target : kTargets) names += " " + std::string(target.name);
  throw std::invalid_argument("no target '" + std::string(name) + "'; allowed:" + names);
}

}  // namespace sprout::fuzz
