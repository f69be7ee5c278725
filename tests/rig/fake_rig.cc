#include "tests/rig/fake_rig.h"

#include <fmt/core.h>
#include <net/if.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <thread>

namespace sprout {
namespace {

void Do(const std::string& command) {
  Process process({"sh", "-c", command});
  if (process.Wait() != 0) throw std::runtime_error(command + ": " + process.Output());
}

bool WaitFor(const std::function<bool()>& condition) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

std::string NetworkOf(const std::string& process) {
  std::error_code error;  // the process may not have begun
  return std::filesystem::read_symlink("/proc/" + process + "/ns/net", error).string();
}

}  // namespace

FakeRig::~FakeRig() {
  // Waits for the networks, whose names the next rig may want.
  for (const auto& [serial, entry] : cameras_) Kill(serial);
}

void FakeRig::Start(const std::string& serial, const std::vector<std::string>& flags) {
  Kill(serial);
  const auto known = cameras_.find(serial);
  const int number =
      known == cameras_.end() ? static_cast<int>(cameras_.size()) + 1 : known->second.number;
  std::vector<std::string> command = {"unshare", "--net",       FAKE_CAMERA,   "--serial",
                                      serial,    "--interface", "to_" + serial};
  command.insert(command.end(), flags.begin(), flags.end());
  auto process = std::make_unique<Process>(command);
  const std::string pid = std::to_string(process->pid());
  // Waits until unshare has made the network: before, the camera would use this one.
  const std::string here = NetworkOf("self");
  if (!WaitFor([&] { return NetworkOf(pid) != here && !NetworkOf(pid).empty(); })) {
    throw std::runtime_error("no network of its own: " + process->Output());
  }
  // Packets as long as real networks for cameras have them.
  Do(fmt::format(
      "ip link add at_{0} mtu 9000 type veth peer name to_{0} mtu 9000 && ip link set to_{0} netns "
      "{1} && ip addr add 10.77.{2}.1/24 dev at_{0} && ip link set at_{0} up && nsenter -t {1} -n "
      "ip addr add 10.77.{2}.2/24 dev to_{0} && nsenter -t {1} -n ip link set to_{0} up",
      serial, pid, number));
  if (!WaitFor([&] { return process->Output().find("running") != std::string::npos; })) {
    throw std::runtime_error("fake_camera does not start: " + process->Output());
  }
  cameras_[serial] = {number, std::move(process)};
}

void FakeRig::Kill(const std::string& serial) {
  const auto camera = cameras_.find(serial);
  if (camera == cameras_.end() || !camera->second.process) return;
  camera->second.process->Signal(SIGKILL);
  camera->second.process->Wait();
  camera->second.process.reset();
  // The kernel takes the network down a moment later. Not asked of /sys, which shows the network
  // that it was mounted in.
  WaitFor([&] { return if_nametoindex(("at_" + serial).c_str()) == 0; });
}

void FakeRig::JumpClock(const std::string& serial) { cameras_.at(serial).process->Signal(SIGUSR1); }

void FakeRig::Unplug(const std::string& serial) { Do("ip link set at_" + serial + " down"); }

void FakeRig::Plug(const std::string& serial) { Do("ip link set at_" + serial + " up"); }

}  // namespace sprout
