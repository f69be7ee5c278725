
#include <gmock/gmock.h>

#include <cstdlib>

#include "common/ros/ros_node.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using testing::HasSubstr;
using testing::Not;

class RosEnvironment : public testing::Test {
 protected:
  RosEnvironment() {
    for (const char* name : kNames) unsetenv(name);
  }
  ~RosEnvironment() override {
    for (const char* name : kNames) unsetenv(name);
  }
  static std::string With(const char* name, const char* value) {
    setenv(name, value, /*overwrite=*/1);
    return CycloneConfig(1000);
  }
  static constexpr const char* kNames[] = {"ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE",
                                           "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY",
                                           "CYCLONEDDS_URI"};
};

TEST_F(RosEnvironment, WithoutItDiscoveryIsCyclonesOwn) {
  EXPECT_THAT(CycloneConfig(1000), HasSubstr("<MaxSampleSize>1000B<"));
  EXPECT_THAT(CycloneConfig(1000), Not(HasSubstr("Discovery")));
  EXPECT_THAT(CycloneConfig(1000), Not(HasSubstr("Multicast")));
}

TEST_F(RosEnvironment, WhatCycloneIsToldComesLast) {
  EXPECT_TRUE(With("CYCLONEDDS_URI", "<CycloneDDS/>").ends_with("</CycloneDDS>,<CycloneDDS/>"));
}

TEST_F(RosEnvironment, WhatCycloneCannotUseIsNamed) {
  setenv("CYCLONEDDS_URI", "file:///nowhere.xml", 1);
  EXPECT_THAT(Thrown<ConfigError>([] { RosNode({.domain = 7, .name = "x"}); }),
              HasSubstr("DDS: domain 7 with CYCLONEDDS_URI = 'file:///nowhere.xml': "));
}

TEST_F(RosEnvironment, LocalhostIsAPeerWithoutMulticast) {
  const std::string config = With("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
  EXPECT_THAT(config, HasSubstr("<AllowMulticast>false<"));
  EXPECT_THAT(config, HasSubstr("<ParticipantIndex>auto<"));
  EXPECT_THAT(config, HasSubstr("<Peer address=\"localhost\"/>"));
}

TEST_F(RosEnvironment, PeersAreAdded) {
  const std::string config = With("ROS_STATIC_PEERS", "10.0.0.2;robot;");
  EXPECT_THAT(config, HasSubstr("<Peer address=\"10.0.0.2\"/><Peer address=\"robot\"/></Peers>"));
  EXPECT_THAT(config, Not(HasSubstr("AllowMulticast")));
  EXPECT_THROW(With("ROS_STATIC_PEERS", "\"/>"), ConfigError);
}

TEST_F(RosEnvironment, OffFindsNobody) {
  setenv("ROS_STATIC_PEERS", "robot", 1);
  const std::string config = With("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF");
  EXPECT_THAT(config, HasSubstr("<ParticipantIndex>none<"));
  EXPECT_THAT(config, Not(HasSubstr("robot")));
  EXPECT_THROW(With("ROS_AUTOMATIC_DISCOVERY_RANGE", "NEAR"), ConfigError);
}

TEST_F(RosEnvironment, HumblesVariableCounts) {
  const std::string config = With("ROS_LOCALHOST_ONLY", "1");
  EXPECT_THAT(config, HasSubstr("address=\"127.0.0.1\""));
  EXPECT_THAT(With("ROS_LOCALHOST_ONLY", "0"), Not(HasSubstr("127.0.0.1")));
}

TEST_F(RosEnvironment, TheDomainIsANumberUpTo232) {
  EXPECT_EQ(RosDomainOfEnvironment(), std::nullopt);
  setenv("ROS_DOMAIN_ID", "232", 1);
  EXPECT_EQ(RosDomainOfEnvironment(), 232);
  setenv("ROS_DOMAIN_ID", "233", 1);
  EXPECT_THROW(RosDomainOfEnvironment(), ConfigError);
  setenv("ROS_DOMAIN_ID", "seven", 1);
  EXPECT_THROW(RosDomainOfEnvironment(), ConfigError);
}

}  // namespace
}  // namespace sprout
