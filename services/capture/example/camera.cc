// A capture process: sends a wall 2 m away, 10 times a second, to where LCM_DEFAULT_URL says.
#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <lcmtypes/sprout/image_t.hpp>
#include <lcmtypes/sprout/rig_t.hpp>
#include <lcmtypes/sprout/tof_image_t.hpp>
#include <random>
#include <thread>

constexpr int kWidth = 320, kHeight = 240, kTofWidth = 32, kTofHeight = 24;
constexpr int kDisparity = 15;  // = focal_px * baseline_m / 2 m

sprout::image_t Grey(const sprout::header_t& header, const std::vector<uint8_t>& pixels) {
  constexpr int kGrey = sprout::image_t::PIXEL_FORMAT_GREY;
  return {header, kWidth, kHeight, /*row_stride=*/kWidth, kGrey, kWidth * kHeight, pixels};
}

int main() {
  lcm::LCM lcm;
  if (!lcm.good()) return 1;
  sprout::header_t header{.utime = 0, .seq = 0, .rig_id = "1"};  // new numbers: a new rig_id
  const sprout::rig_t rig{.header = header,
                          .width = kWidth,
                          .height = kHeight,
                          .focal_px = 300,
                          .cx = 159.5,
                          .cy = 119.5,
                          .cx_right = 159.5,
                          .baseline_m = 0.1,
                          .tof_width = kTofWidth,
                          .tof_height = kTofHeight,
                          .tof_fx = 30,
                          .tof_fy = 30,
                          .tof_cx = 15.5,
                          .tof_cy = 11.5,
                          .tof_distortion = {},
                          .left_from_tof_rotation = {1, 0, 0, 0},
                          .left_from_tof_translation_m = {}};
  std::vector<uint8_t> wall(kWidth * kHeight + kDisparity);
  std::mt19937 random;
  for (uint8_t& pixel : wall) pixel = static_cast<uint8_t>(random());
  for (;; ++header.seq) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    header.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
    if (header.seq % 10 == 0) lcm.publish("SPROUT_RIG", &rig);
    // The right camera sees at column u what the left one sees at u + kDisparity.
    const auto left = Grey(header, {wall.begin(), wall.end() - kDisparity});
    const auto right = Grey(header, {wall.begin() + kDisparity, wall.end()});
    const std::vector<float> depth_m(kTofWidth * kTofHeight, 2.0F);
    const sprout::tof_image_t tof{header,
                                  kTofWidth,
                                  kTofHeight,
                                  kTofWidth * kTofHeight,
                                  /*amplitude_count=*/0,
                                  depth_m,
                                  /*amplitude=*/{}};
    lcm.publish("SPROUT_LEFT", &left);
    lcm.publish("SPROUT_RIGHT", &right);
    lcm.publish("SPROUT_TOF", &tof);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}
