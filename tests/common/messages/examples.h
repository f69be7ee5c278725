#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/messages/codec.h"
#include "common/messages/message_type.h"
#include "tests/common/testing/thrown.h"

// One small valid value of each kind, and how to bend its bytes.
namespace sprout::examples {

inline FrameId Id() {
  return {.utime = 1'700'000'000'123'456, .seq = 42, .rig_id = "0123456789abcdef"};
}

/// Bytes from the start of a message to the length of rig_id: fingerprint, utime, seq.
inline constexpr size_t kRigIdLengthOffset = 24;

inline constexpr DisparityEncoding kEncodings[] = {DisparityEncoding::kRawInt16,
                                                   DisparityEncoding::kDeltaZstd};

inline cv::Mat GreyImage() {
  cv::Mat1b image(5, 7);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) image(v, u) = static_cast<uint8_t>(30 * v + u);
  }
  return image;
}

inline cv::Mat BgrImage() {
  cv::Mat3b image(4, 6);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image(v, u) = {static_cast<uint8_t>(u), static_cast<uint8_t>(100 + v), 200};
    }
  }
  return image;
}

inline TofImage Tof(bool amplitude) {
  TofImage tof;
  tof.depth_m = (cv::Mat1f(2, 3) << 1.5F, 2.25F, NAN, 0.5F, 1.0F, 7.0F);
  if (amplitude) tof.amplitude = (cv::Mat1f(2, 3) << 10.0F, 20.0F, 0.0F, 1.0F, 2.0F, 3.5F);
  return tof;
}

inline sprout::Rig Rig() {
  sprout::Rig rig;
  rig.pair = {.width = 640,
              .height = 480,
              .focal_px = 500,
              .cx = 320.5,
              .cy = 240.25,
              .cx_right = 310.75,
              .baseline_m = 0.125};
  rig.tof = {.width = 176,
             .height = 144,
             .fx = 220,
             .fy = 221,
             .cx = 88,
             .cy = 72,
             .distortion = {-0.25, 0.125, 0.001, -0.002, 0.5},
             .left_from_tof_rotation = Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5),
             .left_from_tof_translation_m = {0.0625, -0.03125, 0.25}};
  return rig;
}

inline SeedSet Seeds() {
  return {.seeds = {{10.5F, 3, 4.25F, 0.25F, SeedOrigin::kTof, 175, 0},
                    {11, 4, 5, 1023, SeedOrigin::kStereo},
                    {0, 0, 0, 0.0625F, SeedOrigin::kTof, 0, 16383}},
          .raw = 27,
          .outside = 1,
          .dark = 2,
          .loose = 5,
          .background = 4,
          .hidden = 6,
          .contradicted = 7};
}

inline DisparityImage Disparity() {
  cv::Mat1s counts(3, 4);
  counts << 0, 32767, -32767, DisparityImage::kInvalid,  //
      1, -1, 320, 321,                                   //
      DisparityImage::kInvalid, 32767, DisparityImage::kInvalid, 0;
  return DisparityImage(counts);
}

inline PriorMap Prior() {
  cv::Mat1b sigma(3, 4);
  sigma << 1, 255, 16, 255,  //
      17, 200, 8, 254,       //
      255, 1, 255, 64;
  return {Disparity(), sigma};
}

inline DepthImage Depth() {
  return {.counts = (cv::Mat1w(2, 3) << 0, 1, 255, 256, 65534, 65535),
          .metres_per_count = 0.001,
          .focal_px = 250,
          .cx = 1.25,
          .cy = 0.5};
}

inline PointCloud Cloud() {
  return {.points = {{{0.5F, -0.25F, 2}, {10, 20, 30}, 200}, {{-3, 0, 7.5F}, {255, 0, 1}, 0}}};
}

inline DepthCounts Counts() {
  return {.pixels = 1000, .near = 1, .far = 20, .outside = 300, .unsure = 40, .flying = 5};
}

inline TofZones Zones() {
  return {.columns = 2,
          .rows = 1,
          .targets_per_zone = 2,
          .mode = ZoneMode::kNearest,
          .left_from_sensor = {Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0.25, -1, 3}},
          .views = {{-0.5F, 0, -0.25F, 0.25F}, {0, 0.5F, -0.25F, 0.25F}},
          .targets = {{1.5F, 0.0625F, TargetStatus::kValid},
                      {10'000, 1, TargetStatus::kDoubtful},
                      {0.125F, 0.5F, TargetStatus::kValid},
                      {}}};
}

inline CameraMotion Motion() {
  CameraMotion motion;
  motion.last_from_left = {Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0.25, -1, 3}};
  motion.start_from_left = {Eigen::Quaterniond(0, 0, 1, 0), {-7, 8, 9.5}};
  for (size_t i = 0; i < motion.covariance.size(); ++i) motion.covariance[i] = 0.125 * double(i);
  motion.last_seq = 41;
  motion.start_seq = 3;
  motion.tracked = 500;
  motion.inliers = 400;
  motion.reset = MemoryReset::kNone;
  motion.resets = 2;
  return motion;
}

inline StageStatus Status() {
  StageStatus status;
  status.newest_frame = Id();
  status.stage = "refine";
  status.host = "robot";
  status.version = "0.1.0 (test)";
  status.config_digest = "fedcba9876543210";
  status.last_error = "frame 41: no seeds";
  status.pid = 77;
  status.state = StageStatus::State::kRunning;
  status.frames_in = 1;
  status.frames_out = 2;
  status.frames_skipped = 3;
  status.frames_incomplete = 4;
  status.frames_degenerate = 5;
  status.frames_failed = 6;
  status.frames_resent = 7;
  status.bad_messages = 8;
  status.sequence_gaps = 9;
  status.rate_hz = 10.5;
  status.latency = {.p50_ms = 11, .p95_ms = 12, .p99_ms = 13, .max_ms = 14};
  status.age = {.p50_ms = 15, .p95_ms = 16, .p99_ms = 17, .max_ms = 18};
  status.rss_bytes = int64_t{19} << 32;
  status.tof_coverage = 0.25F;
  status.spread_ms = 1.5F;
  status.tof_offset = {.u_px = 2.25F, .v_px = -0.5F, .sigma_px = 0.125F};
  return status;
}

/// A JPEG stream in an image message.
inline image_t Jpeg() {
  const cv::Mat image(16, 24, CV_8UC3, cv::Scalar(20, 120, 220));
  image_t message = ToMessage(Id(), image);
  cv::imencode(".jpg", image, message.data, {cv::IMWRITE_JPEG_QUALITY, 95});
  message.pixel_format = image_t::PIXEL_FORMAT_MJPG;
  message.row_stride = 0;
  message.size = static_cast<int32_t>(message.data.size());
  return message;
}

inline ProcessInfo Process() {
  return {.header = Id(),
          .stage = "grow",
          .host = "robot",
          .version = "0.1.0 (test)",
          .config_digest = "fedcba9876543210",
          .config_text = "grow {\n  sigma_p_px: 0.8\n}\n",
          .pid = 78};
}

inline RigChange Change() {
  return {.newest_frame = Id(),
          .reason = "the scene is too flat",
          .verdict = RigChange::Verdict::kWrong,
          .frames = 10,
          .matches = 1500,
          .tof_matches = 700,
          .rows_px = -0.5F,
          .rows_spread_px = 0.25F,
          .rows_sigma_px = 0.125F,
          .right = {.turn = {0.001, -0.002, 0.003}, .sigma = {0.0001, 0.0002, 0.0003}},
          .tof = {.turn = {0.01, 0, -0.03}, .sigma = {0.003, -1, 0.006}},
          .range_offset_m = 0.02,
          .range_sigma_m = 0.001};
}

template <typename Message>
std::vector<uint8_t> Encode(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  return bytes;
}

/// Writes a big-endian int32.
inline std::vector<uint8_t> Patched(std::vector<uint8_t> bytes, size_t offset, int32_t value) {
  for (size_t i = 0; i < 4; ++i) {
    bytes.at(offset + i) = static_cast<uint8_t>(static_cast<uint32_t>(value) >> (24 - 8 * i));
  }
  return bytes;
}

/// A named valid message, and the error of decoding bytes as one (empty: none).
struct Wire {
  std::string name;
  std::vector<uint8_t> bytes;
  std::optional<Part> part;                  ///< nothing: a message that carries none
  MessageType other = MessageType::kStatus;  ///< its type then

  std::string ErrorOf(std::span<const uint8_t> as_one) const {
    return part ? WhyNot(DecodePart(*part, as_one)) : WhyNot(DecodeAs(other, as_one));
  }
};

/// Every message type, with every encoding of those that have some.
inline std::vector<Wire> AllWires() {
  const auto wire = [](const char* name, Part part, const PartValue& value,
                       DisparityEncoding encoding = DisparityEncoding::kRawInt16) {
    return Wire{name, EncodePart(Id(), part, value, encoding), part};
  };
  return {wire("grey image", Part::kLeft, GreyImage()),
          wire("BGR image", Part::kRight, BgrImage()),
          Wire{"JPEG image", Encode(Jpeg()), Part::kLeft},
          wire("tof", Part::kTof, Tof(false)),
          wire("tof with amplitude", Part::kTof, Tof(true)),
          wire("rig", Part::kRig, Rig()),
          wire("seeds", Part::kSeeds, Seeds()),
          wire("raw prior", Part::kPrior, Prior()),
          wire("zstd prior", Part::kPrior, Prior(), DisparityEncoding::kDeltaZstd),
          wire("raw disparity", Part::kUnfilled, Disparity()),
          wire("zstd disparity", Part::kDisparity, Disparity(), DisparityEncoding::kDeltaZstd),
          wire("depth", Part::kDepth, Depth()),
          wire("cloud", Part::kCloud, Cloud()),
          wire("motion", Part::kMotion, Motion()),
          wire("depth counts", Part::kDepthCounts, Counts()),
          wire("base cloud", Part::kBaseCloud, Cloud()),
          wire("zones", Part::kTofZones, Zones()),
          Wire{"process", EncodeProcessInfo(Process()), std::nullopt, MessageType::kProcess},
          Wire{"rig change", EncodeRigChange(Change()), std::nullopt, MessageType::kRigChange},
          Wire{"status", EncodeStatus(Status()), std::nullopt}};
}

}  // namespace sprout::examples
