// A GigE Vision camera that does not exist: Aravis' simulator with pictures, a clock and a GenICam
// file of our own. See tests/rig/README.md.

#include <ifaddrs.h>
#include <net/if.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

#include "common/app/program.h"
#include "common/config/config_error.h"
#include "common/core/image.h"
#include "services/capture/genicam/arv_object.h"
#include "services/capture/genicam/pixels.h"
#include "tests/rig/fake_camera_features.h"
#include "tests/rig/time_stamp.h"

namespace sprout {
namespace {

using std::chrono::milliseconds;

struct Options {
  std::string interface = "lo";
  std::string serial = "FAKE1";
  std::string format = "Mono8";
  int width = 640;
  int height = 480;
  std::vector<std::string> pictures;
  double period_ms = 100;
  bool stamp = false;
  std::string exposures;
  double clock_offset_s = 0;
  double drift_ppm = 0;
  double jump_s = 1000;
  double lost_ratio = 0;
  double latency_ms = 0;
  double unit_mm = 1;
  double focal_px = 0;
  bool spherical = false;
};

// Path of a file that holds the features, in memory alone: nobody has to remove it.
std::string FeaturesFile() {
  const std::string text = FakeCameraFeatures();
  const int file = memfd_create("features", 0);
  if (write(file, text.data(), text.size()) != std::ssize(text)) {
    throw ConfigError("no memory for a file");
  }
  return "/proc/self/fd/" + std::to_string(file);
}

void WriteBits(ArvFakeCamera* camera, uint32_t address, uint64_t bits) {
  bits = GUINT64_TO_BE(bits);
  arv_fake_camera_write_memory(camera, address, sizeof bits, &bits);
}

void WriteDouble(ArvFakeCamera* camera, uint32_t address, double value) {
  uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  WriteBits(camera, address, bits);
}

// A picture as the sensor sees it.
std::vector<uint8_t> Payload(const cv::Mat& picture, capture::PixelFormat format) {
  cv::Mat pixels;
  if (format == capture::PixelFormat::kMono8) {
    pixels = ToGrey(picture);
  } else if (format == capture::PixelFormat::kRGB8) {
    cv::cvtColor(ToBgr(picture), pixels, cv::COLOR_BGR2RGB);
  } else if (picture.depth() == CV_16U) {
    pixels = picture;
  } else {
    // Channel (B, G, R) that lies under the filter, first two of even rows, of odd rows.
    static const std::map<capture::PixelFormat, std::array<int, 4>> kFilters = {
        {capture::PixelFormat::kBayerRG8, {2, 1, 1, 0}},
        {capture::PixelFormat::kBayerGR8, {1, 2, 0, 1}},
        {capture::PixelFormat::kBayerGB8, {1, 0, 2, 1}},
        {capture::PixelFormat::kBayerBG8, {0, 1, 1, 2}}};
    const auto& filter = kFilters.at(format);
    const cv::Mat3b colours = ToBgr(picture);
    pixels.create(colours.size(), CV_8UC1);
    for (int v = 0; v < pixels.rows; ++v) {
      for (int u = 0; u < pixels.cols; ++u) {
        pixels.at<uint8_t>(v, u) = colours(v, u)[filter[static_cast<size_t>(v % 2 * 2 + u % 2)]];
      }
    }
  }
  pixels = pixels.clone();
  return {pixels.datastart, pixels.dataend};
}

class FakeCamera {
 public:
  explicit FakeCamera(const Options& options)
      : options_(options),
        started_us_(g_get_real_time()),
        exposures_(options.exposures, std::ios::app),
        camera_(arv_gv_fake_camera_new_full(options.interface.c_str(), options.serial.c_str(),
                                            FeaturesFile().c_str())) {
    if (!arv_gv_fake_camera_is_running(camera_.get())) {
      throw ConfigError("--interface " + options.interface +
                        ": the simulator does not start there");
    }
    for (const std::string& file : options.pictures) {
      pictures_.push_back(cv::imread(file, cv::IMREAD_UNCHANGED));
      if (pictures_.back().size() != cv::Size(options.width, options.height)) {
        throw ConfigError("--pictures " + file + ": no picture of --width x --height");
      }
    }
    ArvFakeCamera* registers = arv_gv_fake_camera_get_fake_camera(camera_.get());
    const auto write = [&](uint32_t address, auto value) {
      arv_fake_camera_write_register(registers, address, static_cast<uint32_t>(value));
    };
    write(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, options.width);
    write(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, options.height);
    write(ARV_FAKE_CAMERA_REGISTER_WIDTH, options.width);
    write(ARV_FAKE_CAMERA_REGISTER_HEIGHT, options.height);
    write(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, Format(options.format));
    write(kCoordinateSystem, options.spherical ? 1 : 0);
    WriteDouble(registers, kScale, options.unit_mm);
    WriteDouble(registers, kFocalLength, options.focal_px);
    WriteDouble(registers, kPrincipalU, (options.width - 1) / 2.0);
    WriteDouble(registers, kPrincipalV, (options.height - 1) / 2.0);
    // How often it looks whether it was triggered.
    arv_fake_camera_set_trigger_frequency(registers, 500);
    g_object_set(camera_.get(), "gvsp-lost-ratio", options.lost_ratio, nullptr);
    arv_fake_camera_set_fill_pattern(registers, &FakeCamera::Fill, this);
    // The simulator tells nobody of a latch command, so the value is always fresh, to a
    // millisecond.
    clock_ = std::jthread([this, registers](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        WriteBits(registers, kTimestampLatchValue, DeviceNs(g_get_real_time()));
        std::this_thread::sleep_for(milliseconds(1));
      }
    });
  }

  // Its clock is another one from now on.
  void JumpClock() { jump_s_ = jump_s_ + options_.jump_s; }

 private:
  static capture::PixelFormat Format(const std::string& name) {
    const std::optional<capture::PixelFormat> format = capture::PixelFormatNamed(name);
    if (!format) throw ConfigError("--format " + name + ": no such format");
    return *format;
  }

  // The simulator's thread: an exposure has just ended.
  static void Fill(ArvBuffer* buffer, void* self, uint32_t exposure_us, uint32_t /*gain*/,
                   uint32_t format) {
    static_cast<FakeCamera*>(self)->Expose(buffer, exposure_us,
                                           static_cast<capture::PixelFormat>(format));
  }

  uint64_t DeviceNs(int64_t utime) const {
    const auto passed_us = static_cast<double>(utime - started_us_);
    const double ns = 1e12 + (options_.clock_offset_s + jump_s_) * 1e9 +
                      passed_us * 1e3 * (1 + options_.drift_ppm * 1e-6);
    return static_cast<uint64_t>(ns);
  }

  void Expose(ArvBuffer* buffer, int64_t exposure_us, capture::PixelFormat format) {
    // A ToF camera computes before it sends.
    const int64_t begin_us = g_get_real_time() - exposure_us;
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(options_.latency_ms));
    arv_buffer_set_timestamp(buffer, DeviceNs(begin_us));
    const auto number =
        static_cast<int64_t>(static_cast<double>(begin_us) / (options_.period_ms * 1e3));
    const std::vector<uint8_t>& payload = PayloadOf(number, format);
    size_t size = 0;
    // Aravis hands its simulator's memory out as const.
    auto* bytes =
        const_cast<uint8_t*>(static_cast<const uint8_t*>(arv_buffer_get_data(buffer, &size)));
    std::memcpy(bytes, payload.data(), payload.size());
    const int64_t middle_us = begin_us + exposure_us / 2;
    if (exposures_.is_open()) exposures_ << middle_us << std::endl;
    if (!options_.stamp) return;
    const bool is_wide =
        format == capture::PixelFormat::kMono16 || format == capture::PixelFormat::kCoord3dC16;
    is_wide ? WriteStamp16(middle_us, {bytes, payload.size()})
            : WriteStamp8(middle_us, {bytes, payload.size()});
  }

  const std::vector<uint8_t>& PayloadOf(int64_t number, capture::PixelFormat format) {
    const size_t count = std::max<size_t>(pictures_.size(), 1);
    const size_t index = static_cast<size_t>(number) % count;
    std::vector<uint8_t>& payload = payloads_[{index, format}];
    if (payload.empty()) payload = Payload(Picture(index, format), format);
    return payload;
  }

  cv::Mat Picture(size_t index, capture::PixelFormat format) const {
    if (!pictures_.empty()) return pictures_[index];
    const bool is_wide =
        format == capture::PixelFormat::kMono16 || format == capture::PixelFormat::kCoord3dC16;
    cv::Mat ramp(options_.height, options_.width, is_wide ? CV_16UC1 : CV_8UC1);
    for (int v = 0; v < ramp.rows; ++v) {
      for (int u = 0; u < ramp.cols; ++u) {
        if (is_wide) {
          ramp.at<uint16_t>(v, u) = static_cast<uint16_t>(1000 + u + v);
        } else {
          ramp.at<uint8_t>(v, u) = static_cast<uint8_t>(u + v);
        }
      }
    }
    return ramp;
  }

  Options options_;
  int64_t started_us_;
  std::atomic<double> jump_s_ = 0;
  std::ofstream exposures_;
  std::vector<cv::Mat> pictures_;
  std::map<std::pair<size_t, capture::PixelFormat>, std::vector<uint8_t>> payloads_;
  capture::ArvObject<ArvGvFakeCamera> camera_;  // its thread uses those above
  std::jthread clock_;                          // the last one: it uses all others
};

// Whether a network interface is up and has an address.
bool IsUp(const std::string& name) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return false;
  bool is_up = false;
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    is_up |= name == entry->ifa_name && (entry->ifa_flags & IFF_UP) && entry->ifa_addr &&
             entry->ifa_addr->sa_family == AF_INET;
  }
  freeifaddrs(list);
  return is_up;
}

int Run(const Options& options) {
  sigset_t ends;
  sigemptyset(&ends);
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) sigaddset(&ends, signal);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  // The interface is moved into this network after the program has started, so it is waited for.
  for (int i = 0; i < 1000 && !IsUp(options.interface); ++i) {
    std::this_thread::sleep_for(milliseconds(10));
  }
  {
    FakeCamera camera(options);
    std::cout << "running" << std::endl;
    for (int signal = 0; sigwait(&ends, &signal) == 0 && signal == SIGUSR1;) camera.JumpClock();
  }
  arv_shutdown();
  return 0;
}

int Main(int argc, char** argv) {
  Flags flags("fake_camera", "A GigE Vision camera that does not exist");
  Options options;
  flags.Add("--interface", options.interface, "Network interface; it is waited for, at most 10 s");
  flags.Add("--serial", options.serial, "Serial number");
  flags.Add("--format", options.format, "GenICam's name of the pixel format at the start");
  flags.Add("--width", options.width, "px").WithinWhole(8, 4096);
  flags.Add("--height", options.height, "px").WithinWhole(1, 4096);
  flags.Add("--pictures", options.pictures,
            "What it sees, one after the other; 16-bit ones are a ToF camera's numbers");
  flags.Add("--period", options.period_ms, "How long a picture stands, ms");
  flags.Add("--stamp", options.stamp,
            "Write the time of exposure into the first pixels (time_stamp.h)");
  flags.Add("--exposures", options.exposures,
            "File that gets the time of each exposure, µs since 1970, a line each");
  flags.Add("--clock-offset", options.clock_offset_s, "Of its clock, s");
  flags.Add("--drift", options.drift_ppm, "How much too fast its clock runs, ppm");
  flags.Add("--jump", options.jump_s, "By how much its clock jumps at SIGUSR1, s");
  flags.Add("--lost-ratio", options.lost_ratio, "Of packets that are not sent").Within(0, 1);
  flags.Add("--latency", options.latency_ms, "What it needs before it sends an image, ms");
  flags.Add("--unit", options.unit_mm, "Scan3dCoordinateScale, mm");
  flags.Add("--focal", options.focal_px, "Scan3dFocalLength, px; 0 = does not know");
  flags.Add("--spherical", options.spherical, "Its numbers are ranges along the ray");
  return RunProgram(flags, argc, argv, [&] { return Run(options); });
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
