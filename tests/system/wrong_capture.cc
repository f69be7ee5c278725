// A small capture process with one fault at choice, to see that check_stage finds it; with "none"
// it has none. usage: wrong_capture FAULT
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <set>
#include <string>
#include <thread>

#include "common/bus/channels.h"
#include "common/bus/publisher.h"
#include "common/messages/codec.h"
#include "tests/common/core/centred.h"

namespace sprout {
namespace {

const std::set<std::string> kFaults = {"none",     "silent",       "no_tof",     "stops",
                                       "rig_once", "ends_at_once", "ends_early", "ignores_sigterm"};

const cv::Size kSize(64, 48);
constexpr std::chrono::milliseconds kPeriod{100};
constexpr int kLastFrame = 4;  // of "stops" and "ends_early"

Rig SmallRig() {
  return {CentredPair(kSize.width, kSize.height, 60), {}};  // without a ToF camera
}

class WrongCapture {
 public:
  WrongCapture(const std::string& url, std::string fault)
      : fault_(std::move(fault)), publisher_(url, "") {}

  [[noreturn]] void Run() {
    for (int64_t seq = 0;; ++seq) {
      if (Has("stops") && seq > kLastFrame) std::this_thread::sleep_for(std::chrono::hours(1));
      if (Has("ends_early") && seq > kLastFrame) std::_Exit(0);
      Send({.utime = 1'700'000'000'000'000 + seq * 100'000, .seq = seq, .rig_id = RigId(rig_)});
      std::this_thread::sleep_for(kPeriod);
    }
  }

 private:
  bool Has(const char* fault) const { return fault_ == fault; }

  void Send(const FrameId& id) {
    if (Has("silent")) return;
    if (id.seq == 0 || (id.seq % 10 == 0 && !Has("rig_once"))) Publish(id, Part::kRig, rig_);
    Publish(id, Part::kLeft, cv::Mat(kSize, CV_8UC1, cv::Scalar(100)));
    Publish(id, Part::kRight, cv::Mat(kSize, CV_8UC1, cv::Scalar(110)));
    if (!Has("no_tof")) Publish(id, Part::kTof, TofImage());
  }

  void Publish(const FrameId& id, Part part, const PartValue& value) {
    const auto bytes = EncodePart(id, part, value);
    if (!publisher_.Publish(ChannelOf(part), bytes)) std::abort();
  }

  std::string fault_;
  Rig rig_ = SmallRig();
  Publisher publisher_;
};

int Main(const std::string& fault) {
  if (!kFaults.contains(fault)) {
    std::cerr << "wrong_capture: no fault '" << fault << "'\n";
    return 2;
  }
  if (fault == "ends_at_once") return 3;
  if (fault == "ignores_sigterm") std::signal(SIGTERM, SIG_IGN);
  WrongCapture(std::getenv("LCM_DEFAULT_URL"), fault).Run();
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc == 2 ? argv[1] : ""); }
