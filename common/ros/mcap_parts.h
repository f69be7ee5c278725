#ifndef SPROUT_COMMON_ROS_MCAP_PARTS_H_
#define SPROUT_COMMON_ROS_MCAP_PARTS_H_

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sprout {

/// The files of a bag: of a folder those that rosbag2's metadata.yaml in it names or, without one,
/// all *.mcap and *.mcap.zstd; of "a.mcap,b.mcap" both; else the file itself.
/// @throws McapError naming the folder that has none, or what of it is missing.
std::vector<std::filesystem::path> McapParts(std::string_view bag);

/// Which other kind of bag begins with these bytes, and what makes an MCAP file of it, for the end
/// of a line; empty: none that is known.
std::string OtherBag(std::span<const uint8_t> begin);

}  // namespace sprout

#endif  // SPROUT_COMMON_ROS_MCAP_PARTS_H_
