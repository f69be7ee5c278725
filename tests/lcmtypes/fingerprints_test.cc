#include <gtest/gtest.h>

#include <cstdint>
#include <lcmtypes/bot_core/image_metadata_t.hpp>
#include <lcmtypes/bot_core/image_t.hpp>
#include <lcmtypes/bot_core/planar_lidar_t.hpp>
#include <lcmtypes/sprout/depth_counts_t.hpp>
#include <lcmtypes/sprout/depth_image_t.hpp>
#include <lcmtypes/sprout/disparity_image_t.hpp>
#include <lcmtypes/sprout/header_t.hpp>
#include <lcmtypes/sprout/image_t.hpp>
#include <lcmtypes/sprout/motion_t.hpp>
#include <lcmtypes/sprout/packed_t.hpp>
#include <lcmtypes/sprout/point_cloud_t.hpp>
#include <lcmtypes/sprout/prior_t.hpp>
#include <lcmtypes/sprout/process_info_t.hpp>
#include <lcmtypes/sprout/rig_change_t.hpp>
#include <lcmtypes/sprout/rig_t.hpp>
#include <lcmtypes/sprout/seeds_t.hpp>
#include <lcmtypes/sprout/stage_status_t.hpp>
#include <lcmtypes/sprout/tof_image_t.hpp>
#include <lcmtypes/sprout/tof_zones_t.hpp>

namespace sprout {
namespace {

// Every message begins with the fingerprint of its type: a hash of its fields' names and types, in
// their order. Whoever changes one of these numbers makes all logs that were recorded before and
// all programs of others unreadable: a reader takes the message for one of an unknown type. So a
// released type never changes (lcmtypes/README.md). Constants and meanings are not in the hash, and
// must not change either.
template <typename Type>
void ExpectFingerprint(uint64_t expected) {
  EXPECT_EQ(static_cast<uint64_t>(Type::getHash()), expected)
      << Type::getTypeName() << " is 0x" << std::hex << Type::getHash()
      << " now: a released type never changes. Undo it, and make a new type or "
      << "channel for what is new (lcmtypes/README.md). Only a type that no tagged version has may "
      << "get a new number here.";
}

TEST(Fingerprints, AreThoseOfTheReleasedTypes) {
  ExpectFingerprint<header_t>(0xa45097a0cb67fa20);
  ExpectFingerprint<image_t>(0x1763136a4e77ebbe);
  ExpectFingerprint<tof_image_t>(0x666b2dedf6120603);
  ExpectFingerprint<rig_t>(0x7ba6f94345940e7a);
  ExpectFingerprint<seeds_t>(0x618da2fc0d3083af);
  ExpectFingerprint<prior_t>(0xab68f57dfc602245);
  ExpectFingerprint<disparity_image_t>(0x7c2bcd9fc2da90ca);
  ExpectFingerprint<depth_image_t>(0x1eda51eb5050532f);
  ExpectFingerprint<point_cloud_t>(0x3a56f4aa266bfe61);
  ExpectFingerprint<motion_t>(0xba6a79476000dc4f);
  ExpectFingerprint<depth_counts_t>(0x1dae7df4f791a1dd);
  ExpectFingerprint<tof_zones_t>(0x7b680fd0ddf84e9f);
  ExpectFingerprint<stage_status_t>(0x70764dd093aba24e);
  ExpectFingerprint<process_info_t>(0x2462780294b2d3dd);
  ExpectFingerprint<rig_change_t>(0x42f9f4c42038504d);
  ExpectFingerprint<packed_t>(0xb7d4a327c5e60edf);
}

// lcm-gen gives these for libbot2's own bot_core_image_t.lcm, bot_core_image_metadata_t.lcm and
// bot_core_planar_lidar_t.lcm: with others no program would show the pictures or read the scans.
TEST(Fingerprints, AreThoseOfLibbot2) {
  ExpectFingerprint<bot_core::image_t>(0x14739ffe13d5f5f0);
  ExpectFingerprint<bot_core::image_metadata_t>(0x9a4b634d0577fb8e);
  ExpectFingerprint<bot_core::planar_lidar_t>(0xe3d17423180b5e8d);
  EXPECT_EQ(bot_core::image_t::PIXEL_FORMAT_MJPEG, 0x47504a4d);
}

}  // namespace
}  // namespace sprout
