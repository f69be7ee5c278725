#include "common/ros/to_ros.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace sprout {
namespace {

constexpr uint8_t kBigEndianFlag = std::endian::native == std::endian::big ? 1 : 0;

void SetHeader(const RosPlace& place, RosHeader& header) {
  header.stamp = RosStamp(place.utime);
  SetRosText(header.frame_id, place.frame);
}

const char* EncodingOf(const cv::Mat& image) {
  switch (image.type()) {
    case CV_8UC1:
      return "mono8";
    case CV_8UC3:
      return "bgr8";
    case CV_16UC1:
      return "16UC1";
    default:
      assert(image.type() == CV_32FC1);
      return "32FC1";
  }
}

// @returns what keeps the borrowed pixels alive.
std::shared_ptr<const void> SetImage(const RosPlace& place, const cv::Mat& image, RosImage& ros) {
  assert(image.isContinuous());
  SetHeader(place, ros.header);
  ros.height = static_cast<uint32_t>(image.rows);
  ros.width = static_cast<uint32_t>(image.cols);
  SetRosText(ros.encoding, EncodingOf(image));
  ros.is_bigendian = kBigEndianFlag;
  ros.step = static_cast<uint32_t>(image.elemSize() * static_cast<size_t>(image.cols));
  BorrowRos(ros.data, image.data, image.total() * image.elemSize());
  return std::make_shared<const cv::Mat>(image);
}

// All pixels of an image, row by row.
template <typename T>
std::span<T> PixelsOf(cv::Mat_<T>& image) {
  return {image[0], image.total()};
}
template <typename T>
std::span<const T> PixelsOf(const cv::Mat_<T>& image) {
  assert(image.isContinuous());
  return {image[0], image.total()};
}

struct Pinhole {
  cv::Size size;
  double fx, fy, cx, cy;
  double tx = 0;                       // P[0, 3]
  std::span<const double> distortion;  // plumb_bob
};

RosMessage<RosCameraInfo> ToInfo(const RosPlace& place, const Pinhole& camera) {
  RosMessage<RosCameraInfo> info;
  SetHeader(place, info->header);
  info->width = static_cast<uint32_t>(camera.size.width);
  info->height = static_cast<uint32_t>(camera.size.height);
  SetRosText(info->distortion_model, "plumb_bob");
  constexpr size_t kPlumbBob = 5;
  std::ranges::copy(camera.distortion, ResizeRos(info->d, kPlumbBob).begin());
  const std::array k = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  std::ranges::copy(k, info->k);
  for (const int diagonal : {0, 4, 8}) info->r[diagonal] = 1;
  const std::array p = {camera.fx, 0.0, camera.cx, camera.tx, 0.0, camera.fy,
                        camera.cy, 0.0, 0.0,       0.0,       1.0, 0.0};
  std::ranges::copy(p, info->p);
  return info;
}

void SetField(RosPointField& field, std::string_view name, uint32_t offset, uint8_t type) {
  SetRosText(field.name, name);
  field.offset = offset;
  field.datatype = type;
  field.count = 1;
}

constexpr uint32_t kPointBytes = 20;

// A cloud of points that are not set.
RosMessage<RosPointCloud> ToCloud(const RosPlace& place, size_t columns, size_t rows) {
  RosMessage<RosPointCloud> ros;
  SetHeader(place, ros->header);
  ros->height = static_cast<uint32_t>(rows);
  ros->width = static_cast<uint32_t>(columns);
  const std::span fields = ResizeRos(ros->fields, 5);
  SetField(fields[0], "x", 0, kRosFloat32);
  SetField(fields[1], "y", 4, kRosFloat32);
  SetField(fields[2], "z", 8, kRosFloat32);
  SetField(fields[3], "rgb", 12, kRosFloat32);
  SetField(fields[4], "confidence", 16, kRosUint8);
  ros->is_bigendian = kBigEndianFlag != 0;
  ros->point_step = kPointBytes;
  ros->row_step = kPointBytes * ros->width;
  ResizeRos(ros->data, size_t{kPointBytes} * columns * rows);
  return ros;
}

void SetPoint(const CloudPoint& point, uint8_t* at) {
  const std::array position = {point.position_m.x, point.position_m.y, point.position_m.z};
  const uint32_t rgb = uint32_t{point.bgr[2]} << 16 | uint32_t{point.bgr[1]} << 8 | point.bgr[0];
  std::memcpy(at, position.data(), sizeof position);
  std::memcpy(at + 12, &rgb, sizeof rgb);
  at[16] = point.confidence;
}

void SetTransform(int64_t utime, const std::string& parent, const std::string& child,
                  const Eigen::Quaternion<double, Eigen::DontAlign>& turn,
                  const Eigen::Vector3d& place_m, RosTransform& ros) {
  SetHeader({utime, parent}, ros.header);
  SetRosText(ros.child_frame_id, child);
  ros.transform.translation = {place_m.x(), place_m.y(), place_m.z()};
  ros.transform.rotation = {turn.x(), turn.y(), turn.z(), turn.w()};
}

constexpr uint8_t kOk = 0;
constexpr uint8_t kWarn = 1;
constexpr uint8_t kError = 2;
constexpr uint8_t kStale = 3;

std::vector<std::pair<std::string, std::string>> ValuesOf(const StageStatus& status) {
  return {{"newest frame", fmt::format("{}", status.newest_frame.seq)},
          {"frames in", fmt::format("{}", status.frames_in)},
          {"frames out", fmt::format("{}", status.frames_out)},
          {"frames skipped", fmt::format("{}", status.frames_skipped)},
          {"frames incomplete", fmt::format("{}", status.frames_incomplete)},
          {"frames degenerate", fmt::format("{}", status.frames_degenerate)},
          {"frames failed", fmt::format("{}", status.frames_failed)},
          {"bad messages", fmt::format("{}", status.bad_messages)},
          {"sequence gaps", fmt::format("{}", status.sequence_gaps)},
          {"rate (Hz)", fmt::format("{:.2f}", status.rate_hz)},
          {"latency p95 (ms)", fmt::format("{:.1f}", status.latency.p95_ms)},
          {"age p95 (ms)", fmt::format("{:.1f}", status.age.p95_ms)},
          {"memory (MB)", fmt::format("{:.1f}", static_cast<double>(status.rss_bytes) / 1e6)},
          {"version", status.version}};
}

std::pair<uint8_t, std::string> LevelOf(const RosHealth& process) {
  if (process.status.state == StageStatus::State::kStopped) return {kError, "stopped"};
  if (process.silent_s > 0) return {kStale, fmt::format("silent for {:.0f} s", process.silent_s)};
  if (!process.status.last_error.empty()) return {kWarn, process.status.last_error};
  return {kOk, "running"};
}

void Set(const RosHealth& process, RosDiagnostic& ros) {
  const StageStatus& status = process.status;
  const auto [level, message] = LevelOf(process);
  ros.level = level;
  SetRosText(ros.name, "sprout: " + status.stage);
  SetRosText(ros.message, message);
  SetRosText(ros.hardware_id, status.host);
  const auto values = ValuesOf(status);
  const std::span all = ResizeRos(ros.values, values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    SetRosText(all[i].key, values[i].first);
    SetRosText(all[i].value, values[i].second);
  }
}

}  // namespace

RosTime RosStamp(int64_t utime) {
  constexpr int64_t kPerSecond = 1'000'000;
  // Downwards, as nanoseconds are not negative.
  const int64_t seconds = utime / kPerSecond - (utime % kPerSecond < 0 ? 1 : 0);
  return {.sec = static_cast<int32_t>(seconds),
          .nanosec = static_cast<uint32_t>(utime - seconds * kPerSecond) * 1000};
}

RosMessage<RosImage> ToRosImage(const RosPlace& place, const cv::Mat& image) {
  RosMessage<RosImage> ros;
  ros.Keep(SetImage(place, image, *ros));
  return ros;
}

cv::Mat1w RosMillimetres(const DepthImage& depth) {
  if (depth.metres_per_count == 0.001) return depth.counts;
  cv::Mat1w millimetres(depth.size());
  const double scale = 1000 * depth.metres_per_count;
  std::ranges::transform(PixelsOf(depth.counts), PixelsOf(millimetres).begin(),
                         [scale](uint16_t count) {
                           const double rounded = count * scale + 0.5;
                           return static_cast<uint16_t>(rounded < 65536 ? rounded : 0);
                         });
  return millimetres;
}

RosMessage<RosImage> ToRosDepth(const RosPlace& place, const DepthImage& depth, RosDepth encoding) {
  if (encoding == RosDepth::kMillimetres) return ToRosImage(place, RosMillimetres(depth));
  cv::Mat1f metres(depth.size());
  const auto scale = static_cast<float>(depth.metres_per_count);
  std::ranges::transform(PixelsOf(depth.counts), PixelsOf(metres).begin(), [scale](uint16_t count) {
    return count == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(count) * scale;
  });
  return ToRosImage(place, metres);
}

RosMessage<RosImage> ToRosDepthSigma(const RosPlace& place, const DepthImage& sigma) {
  cv::Mat1f metres(sigma.size());
  const auto scale = static_cast<float>(sigma.metres_per_count);
  std::ranges::transform(PixelsOf(sigma.counts), PixelsOf(metres).begin(), [scale](uint16_t count) {
    if (count == 0) return std::numeric_limits<float>::quiet_NaN();
    if (count == kMaxDepthSigmaCounts) return std::numeric_limits<float>::infinity();
    return static_cast<float>(count) * scale;
  });
  return ToRosImage(place, metres);
}

RosMessage<RosCameraInfo> ToRosLeftInfo(const RosPlace& place, const RectifiedPair& pair) {
  return ToInfo(place, {pair.size(), pair.focal_px, pair.focal_px, pair.cx, pair.cy, 0, {}});
}

RosMessage<RosCameraInfo> ToRosRightInfo(const RosPlace& place, const RectifiedPair& pair) {
  const double tx = -pair.focal_px * pair.baseline_m;
  return ToInfo(place, {pair.size(), pair.focal_px, pair.focal_px, pair.cx_right, pair.cy, tx, {}});
}

RosMessage<RosCameraInfo> ToRosDepthInfo(const RosPlace& place, const DepthImage& depth) {
  return ToInfo(place, {depth.size(), depth.focal_px, depth.focal_px, depth.cx, depth.cy, 0, {}});
}

RosMessage<RosCameraInfo> ToRosTofInfo(const RosPlace& place, const TofCamera& tof) {
  return ToInfo(place,
                {{tof.width, tof.height}, tof.fx, tof.fy, tof.cx, tof.cy, 0, tof.distortion});
}

RosMessage<RosPointCloud> ToRosCloud(const RosPlace& place, const PointCloud& cloud) {
  RosMessage<RosPointCloud> ros = ToCloud(place, cloud.points.size(), 1);
  ros->is_dense = true;
  uint8_t* at = RosSpan(ros->data).data();
  for (const CloudPoint& point : cloud.points) {
    SetPoint(point, at);
    at += kPointBytes;
  }
  return ros;
}

Result<RosMessage<RosPointCloud>> ToRosOrderedCloud(const RosPlace& place, const PointCloud& cloud,
                                                    const RectifiedPair& pair, int stride) {
  // Rounding error of a float's position at 10,000 px; the next pixel is `stride` away.
  constexpr double kRoundingPx = 0.1;
  const auto columns = static_cast<size_t>((pair.width + stride - 1) / stride);
  const auto rows = static_cast<size_t>((pair.height + stride - 1) / stride);
  RosMessage<RosPointCloud> ros = ToCloud(place, columns, rows);
  ros->is_dense = false;
  const std::span bytes = RosSpan(ros->data);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (size_t i = 0; i < columns * rows; ++i) {
    SetPoint({.position_m = {kNan, kNan, kNan}, .bgr = {}, .confidence = 0},
             &bytes[kPointBytes * i]);
  }
  for (const CloudPoint& point : cloud.points) {
    const cv::Point3d p(point.position_m);
    const double u = pair.focal_px * p.x / p.z + pair.cx;
    const double v = pair.focal_px * p.y / p.z + pair.cy;
    const double column = std::round(u / stride);
    const double row = std::round(v / stride);
    const bool is_there = std::abs(u - column * stride) < kRoundingPx &&
                          std::abs(v - row * stride) < kRoundingPx && column >= 0 && row >= 0 &&
                          column < static_cast<double>(columns) && row < static_cast<double>(rows);
    if (!is_there) {
      return Fail(
          fmt::format("a point at pixel ({:.1f}, {:.1f}): an ordered cloud has every {}. one "
                      "(depth.cloud_stride) of {}x{}",
                      u, v, stride, pair.width, pair.height));
    }
    SetPoint(
        point,
        &bytes[kPointBytes * (static_cast<size_t>(row) * columns + static_cast<size_t>(column))]);
  }
  return ros;
}

RosMessage<RosDisparity> ToRosDisparity(const RosPlace& place, const DisparityImage& disparity,
                                        const RectifiedPair& pair) {
  constexpr auto kPerPx = static_cast<float>(DisparityImage::kCountsPerPixel);
  const auto shift = static_cast<float>(pair.cx_right - pair.cx);
  int16_t least = std::numeric_limits<int16_t>::max();
  int16_t most = DisparityImage::kInvalid;
  for (const int16_t count : PixelsOf(disparity.counts())) {
    if (count != DisparityImage::kInvalid) least = std::min(least, count);
    most = std::max(most, count);
  }
  RosMessage<RosDisparity> ros;
  if (most != DisparityImage::kInvalid) {
    ros->min_disparity = static_cast<float>(least) / kPerPx + shift;
    ros->max_disparity = static_cast<float>(most) / kPerPx + shift;
  }
  const float none = ros->min_disparity - 1;
  cv::Mat1f px(disparity.size());
  std::ranges::transform(
      PixelsOf(disparity.counts()), PixelsOf(px).begin(), [shift, none](int16_t count) {
        return count == DisparityImage::kInvalid ? none
                                                 : static_cast<float>(count) / kPerPx + shift;
      });
  SetHeader(place, ros->header);
  ros.Keep(SetImage(place, px, ros->image));
  ros->f = static_cast<float>(pair.focal_px);
  ros->t = static_cast<float>(pair.baseline_m);
  ros->valid_window.width = ros->image.width;
  ros->valid_window.height = ros->image.height;
  ros->delta_d = 1 / kPerPx;
  return ros;
}

RosMessage<RosTransforms> ToRosTransforms(int64_t utime, const Rig& rig, const RosFrames& frames) {
  RosMessage<RosTransforms> ros;
  const bool has_tof = rig.tof.width > 0;
  const std::span all = ResizeRos(ros->transforms, has_tof ? 2 : 1);
  SetTransform(utime, frames.left, frames.right,
               Eigen::Quaternion<double, Eigen::DontAlign>::Identity(), {rig.pair.baseline_m, 0, 0},
               all[0]);
  if (has_tof) {
    SetTransform(utime, frames.left, frames.tof, rig.tof.left_from_tof_rotation,
                 rig.tof.left_from_tof_translation_m, all[1]);
  }
  return ros;
}

RosMessage<RosDiagnostics> ToRosDiagnostics(int64_t utime,
                                            const std::map<std::string, RosHealth>& processes) {
  RosMessage<RosDiagnostics> ros;
  ros->header.stamp = RosStamp(utime);
  const std::span all = ResizeRos(ros->status, processes.size());
  size_t next = 0;
  for (const auto& [name, process] : processes) Set(process, all[next++]);
  return ros;
}

}  // namespace sprout
