#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/app/process.h"

namespace sprout {

/// Cameras that do not exist (fake_camera), each in a network of its own with a cable, a veth pair,
/// to the one that this runs in: two GigE Vision cameras need two addresses. When a camera ends, in
/// whatever way, its network and the cable go with it; nothing is left behind. Needs root in its
/// network, as in_private_network gives it.
class FakeRig {
 public:
  FakeRig() = default;
  FakeRig(const FakeRig&) = delete;
  FakeRig& operator=(const FakeRig&) = delete;
  ~FakeRig();

  /// Starts a camera and waits until it listens.
  /// @param serial  at most 8 characters.
  /// @param flags   of fake_camera.
  /// @throws std::runtime_error with what a command said when it fails.
  void Start(const std::string& serial, const std::vector<std::string>& flags);

  /// The camera is gone from one moment to the next.
  void Kill(const std::string& serial);

  /// Its clock jumps, as its flag --jump says.
  void JumpClock(const std::string& serial);

  /// Pulls its cable and puts it back.
  void Unplug(const std::string& serial);
  void Plug(const std::string& serial);

 private:
  struct Entry {
    int number;  // of its network
    std::unique_ptr<Process> process;
  };
  std::map<std::string, Entry> cameras_;
};

}  // namespace sprout
