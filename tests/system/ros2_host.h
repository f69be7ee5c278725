#pragma once

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/app/process.h"

// Where ros2_peer runs, which speaks ROS 2 with an IDL of its own and shares nothing with us.
namespace sprout {

/// How long the streams are, s; 60 by hand: SPROUT_ROS2_SECONDS.
inline int Seconds() {
  const char* const text = std::getenv("SPROUT_ROS2_SECONDS");
  return text != nullptr ? std::atoi(text) : 4;
}

inline bool Shell(const std::string& command) {
  return std::system((command + " 2> /dev/null").c_str()) == 0;
}

/// Where the peer runs: this one.
class Host {
 public:
  virtual ~Host() = default;
  virtual bool is_there() const { return true; }

  std::unique_ptr<Process> Run(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command = enter_;
    command.push_back(SPROUT_ROS2_PEER);
    command.insert(command.end(), arguments.begin(), arguments.end());
    return std::make_unique<Process>(command);
  }

 protected:
  std::vector<std::string> enter_;  // goes before a command that runs there
};

/// Another one, at the other end of a cable.
class OtherHost : public Host {
 public:
  OtherHost() : process_({"unshare", "--net", "sleep", "1000"}) {
    const std::string pid = std::to_string(process_.pid());
    const auto network = [](const std::string& of) {
      std::error_code ignored;
      return std::filesystem::read_symlink("/proc/" + of + "/ns/net", ignored);
    };
    for (int i = 0; i < 1000 && network(pid) == network("self"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    enter_ = {"nsenter", "--net=/proc/" + pid + "/ns/net"};
    const std::string inside = enter_[0] + " " + enter_[1] + " ";
    is_there_ = Shell("ip link add cable type veth peer name cable netns " + pid) &&
                Shell("ip addr add 10.97.0.1/24 dev cable && ip link set cable up") &&
                Shell(inside + "ip addr add 10.97.0.2/24 dev cable") &&
                Shell(inside + "ip link set cable up");
  }
  ~OtherHost() override { Shell("ip link del cable"); }

  bool is_there() const override { return is_there_; }

 private:
  Process process_;
  bool is_there_ = false;
};

#define REQUIRE_HOST(host) \
  if (!(host).is_there()) GTEST_SKIP() << "no cable to another host here"

/// Waits for the end of a peer. @returns its exit code.
inline std::optional<int> End(Process& process) {
  return process.Wait(std::chrono::seconds(2 * Seconds() + 30));
}

}  // namespace sprout
