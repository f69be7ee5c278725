#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/system/graph.h"
#include "tests/system/ros2_host.h"

// Nodes of ROS 2 on Fast DDS (fastdds/fast_peer.cc).
namespace sprout {

inline std::unique_ptr<Process> Peer(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), SPROUT_FAST_PEER);
  return std::make_unique<Process>(arguments);
}

// Whether a process says something within a time.
inline bool SaysSoon(Process& process, const std::string& text) {
  for (const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
       std::chrono::steady_clock::now() < end;) {
    if (process.Output().find(text) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

// What a peer heard of a topic: "TOPIC 40 messages 12 bytes; 40 stamps, longest pause 0.10 s, age
// p99 ..."
struct Heard {
  long messages = -1;
  double longest_pause_s = 0;
  std::string line;
};

inline Heard HeardOf(const std::string& output, const std::string& topic) {
  std::istringstream lines(output);
  Heard heard;
  while (std::getline(lines, heard.line)) {
    if (!heard.line.starts_with(topic + " ")) continue;
    heard.messages = std::atol(heard.line.c_str() + topic.size());
    const size_t pause = heard.line.find("longest pause ");
    heard.longest_pause_s = std::atof(heard.line.c_str() + pause + 14);
    return heard;
  }
  return {};
}

inline Heard EndOf(Process& peer, const std::string& topic) {
  peer.Signal(SIGTERM);
  EXPECT_EQ(End(peer), 0);
  return HeardOf(peer.Output(), topic);
}

// How long a process takes to end after SIGTERM; its exit code must be 0.
inline std::chrono::milliseconds TimeToEnd(Process& process) {
  const auto begin = std::chrono::steady_clock::now();
  process.Signal(SIGTERM);
  EXPECT_EQ(process.Wait(std::chrono::seconds(10)), 0) << process.Output();
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() -
                                                               begin);
}

inline std::vector<std::string> Source(const std::string& more = "") {
  return {"--source", "ros2:left=/cam/left/image_rect&right=/cam/right/image_rect" + more};
}

inline std::vector<std::string> Camera(const std::string& size, const std::string& seconds,
                                       std::vector<std::string> more = {},
                                       const std::string& hz = "10") {
  std::vector<std::string> arguments = {"send", "0", "/cam", size, hz, seconds};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// The newest status of capture, a second after the last frame.
inline StageStatus StatusOf(Graph& graph) {
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  StageStatus status;
  graph.Look([&](Graph& g) { status = g.statuses["capture"]; });
  return status;
}

}  // namespace sprout
