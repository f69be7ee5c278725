#include "services/capture/genicam/device.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/core/image.h"
#include "common/core/receive_buffer.h"
#include "common/geometry/lens.h"
#include "services/capture/genicam/pixels.h"

namespace sprout::capture {
namespace {

// Enough for what arrives while one image is converted, also when the host is busy for a moment.
constexpr int kBuffers = 8;

void OnControlLost(ArvDevice* /*device*/, void* is_lost) {
  *static_cast<std::atomic<bool>*>(is_lost) = true;
}

const char* StatusText(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "came only in part";
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "has missing packets";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "has packets with wrong numbers";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "is of another size than the camera announced";
    case ARV_BUFFER_STATUS_ABORTED:
      return "was broken off";
    default:
      return "is not whole";
  }
}

PartContent ContentOf(ArvBuffer* buffer, unsigned part) {
  // A payload of one part says "2D image" whatever it is.
  if (arv_buffer_get_n_parts(buffer) == 1) return PartContent::kUnknown;
  switch (arv_buffer_get_part_data_type(buffer, part)) {
    case ARV_BUFFER_PART_DATA_TYPE_3D_IMAGE:
      return PartContent::kRange;
    case ARV_BUFFER_PART_DATA_TYPE_CONFIDENCE_MAP:
      return PartContent::kConfidence;
    case ARV_BUFFER_PART_DATA_TYPE_2D_IMAGE:
      return PartContent::kImage;
    default:
      return PartContent::kUnknown;
  }
}

std::vector<PayloadPart> PartsOf(ArvBuffer* buffer) {
  std::vector<PayloadPart> parts;
  for (unsigned i = 0; i < arv_buffer_get_n_parts(buffer); ++i) {
    size_t size = 0;
    const void* data = arv_buffer_get_part_data(buffer, i, &size);
    int padding = 0;
    int rows_padding = 0;
    arv_buffer_get_part_padding(buffer, i, &padding, &rows_padding);
    parts.push_back({.format = arv_buffer_get_part_pixel_format(buffer, i),
                     .width = arv_buffer_get_part_width(buffer, i),
                     .height = arv_buffer_get_part_height(buffer, i),
                     .row_padding = static_cast<size_t>(std::max(padding, 0)),
                     .bytes = {static_cast<const uint8_t*>(data), data ? size : 0},
                     .content = ContentOf(buffer, i)});
  }
  return parts;
}

}  // namespace

Device::Device(OpenedCamera opened, const DeviceSettings& settings)
    : settings_(settings),
      found_(std::move(opened.found)),
      text_(found_.Text()),
      camera_(std::move(opened.camera)) {
  lost_handler_ = g_signal_connect(arv_camera_get_device(camera_.get()), "control-lost",
                                   G_CALLBACK(OnControlLost), &is_lost_);
}

Device::~Device() {
  g_signal_handler_disconnect(arv_camera_get_device(camera_.get()), lost_handler_);
  ArvError error;
  // A command to a lost camera would only wait for its timeout.
  if (stream_ && !is_lost_) arv_camera_stop_acquisition(camera_.get(), error.out());
}

Result<std::unique_ptr<Device>> Device::Open(const DeviceSettings& settings) {
  Result<OpenedCamera> opened = OpenBySerial(settings.device.serial());
  if (!opened) return tl::unexpected<Error>(opened.error());
  std::unique_ptr<Device> device(new Device(std::move(*opened), settings));
  if (const Result<void> done = device->SetUp(); !done) {
    return Fail(device->text() + ": " + done.error().text);
  }
  if (const Result<void> done = device->Start(); !done) {
    return Fail(device->text() + ": " + done.error().text);
  }
  return device;
}

Result<void> Device::SetUp() {
  if (const Result<void> done = SetUpCamera(camera_.get(), settings_); !done) return done;
  ReadExposure();
  clock_reader_.emplace(camera_.get());
  ArvError error;
  int width = 0;
  int height = 0;
  arv_camera_get_region(camera_.get(), nullptr, nullptr, &width, &height, error.out());
  if (error) return Fail("size of the images: " + error.text());
  const uint32_t format = arv_camera_get_pixel_format(camera_.get(), error.out());
  if (error) return Fail("pixel format: " + error.text());
  text_ += fmt::format(": {}x{} {}", width, height, PixelFormatName(format));
  const auto known = static_cast<PixelFormat>(format);
  if (settings_.is_tof ? !IsTofFormat(known) : !IsStereoFormat(known)) {
    return Fail("set to a pixel format that is not understood; pixel_format allows " +
                (settings_.is_tof ? TofFormatNames() : StereoFormatNames()));
  }
  if (!settings_.is_tof) return {};
  scan3d_ = ReadScan3d(camera_.get());
  if (!scan3d_.is_range) return {};
  const std::optional<Lens> lens = settings_.lens ? settings_.lens : ReadLens(camera_.get());
  if (!lens)
    return Fail("gives ranges along the ray, but neither it nor the rig file has its lens");
  range_per_depth_ = RangePerDepth(*lens);
  return {};
}

Result<void> Device::Start() {
  ArvError error;
  stream_.reset(arv_camera_create_stream(camera_.get(), nullptr, nullptr, error.out()));
  if (error || !stream_) return Fail("no stream: " + error.text());
  const unsigned payload = arv_camera_get_payload(camera_.get(), error.out());
  if (error) return Fail("size of the payload: " + error.text());
  // Without the right to a packet socket an image waits in the socket, whose default of 208 KiB is
  // full long before a busy host looks. So a buffer of two images is asked for; the kernel doubles
  // that for its own needs.
  if (ARV_IS_GV_STREAM(stream_.get())) {
    const unsigned two_images = 2 * std::min(payload, 1U << 28);
    g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
                 "socket-buffer-size", static_cast<gint>(two_images), nullptr);
    if (const auto shortage = ReceiveBufferShortage(two_images)) buffer_hint_ = ": " + *shortage;
  }
  for (int i = 0; i < kBuffers; ++i) {
    arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
  }
  arv_camera_start_acquisition(camera_.get(), error.out());
  if (error) return Fail("start of the acquisition: " + error.text());
  return {};
}

std::optional<DeviceImage> Device::Next(int64_t timeout_us) {
  ArvBuffer* buffer =
      arv_stream_timeout_pop_buffer(stream_.get(), static_cast<uint64_t>(timeout_us));
  if (!buffer) return std::nullopt;
  // Aravis gives some back unused when a stream begins amid what a camera still sends for an older
  // one. They hold no image and no number; one that is really missing leaves a gap in the numbers.
  if (arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_CLEARED) {
    arv_stream_push_buffer(stream_.get(), buffer);
    return std::nullopt;
  }
  DeviceImage image = Converted(buffer);
  arv_stream_push_buffer(stream_.get(), buffer);
  return image;
}

// Counts images whose numbers were skipped and that do not come any more: an image that lacks
// packets comes late, after newer ones. Counters of GigE Vision 1 have 16 bits, so a long step in
// either direction is a new start.
int64_t Device::CountMissing(uint64_t id) {
  constexpr uint64_t kPatience = 32;
  if (id + kPatience < newest_id_ || id > newest_id_ + kPatience) {
    missing_ids_.clear();
    newest_id_ = id;
  }
  while (newest_id_ < id) missing_ids_.insert(++newest_id_);
  missing_ids_.erase(id);
  int64_t count = 0;
  while (!missing_ids_.empty() && *missing_ids_.begin() + kPatience < newest_id_) {
    missing_ids_.erase(missing_ids_.begin());
    ++count;
  }
  return count;
}

DeviceImage Device::Converted(ArvBuffer* buffer) {
  DeviceImage image;
  const uint64_t id = arv_buffer_get_frame_id(buffer);
  image.lost = CountMissing(id);
  if (image.lost > 0) image.trouble = fmt::format("{} images never came", image.lost);
  const ArvBufferStatus status = arv_buffer_get_status(buffer);
  Result<void> filled;
  if (status != ARV_BUFFER_STATUS_SUCCESS) {
    const bool lacks_packets =
        status == ARV_BUFFER_STATUS_TIMEOUT || status == ARV_BUFFER_STATUS_MISSING_PACKETS;
    filled = Fail(StatusText(status) + (lacks_packets ? buffer_hint_ : ""));
  } else {
    filled = Fill(buffer, image);
  }
  if (filled) return image;
  ++image.lost;
  image.trouble = fmt::format("image {} {}", id, filled.error().text);
  return image;
}

Result<void> Device::Fill(ArvBuffer* buffer, DeviceImage& image) {
  const auto arrived_ns = static_cast<int64_t>(arv_buffer_get_system_timestamp(buffer));
  image.device_ns = static_cast<int64_t>(arv_buffer_get_timestamp(buffer));
  if (image.device_ns == 0) image.device_ns = arrived_ns;  // the device has no clock
  image.arrived_utime = arrived_ns / 1000;
  image.exposure_ns = exposure_ns_;
  const std::vector<PayloadPart> parts = PartsOf(buffer);
  if (!settings_.is_tof) {
    if (parts.empty()) return Fail("is a payload without an image");
    Result<cv::Mat> converted = ToImage(parts.front());
    if (!converted) return Fail("cannot be used: " + converted.error().text);
    image.image = std::move(*converted);
    return {};
  }
  Result<TofImage> converted = ToTofImage(parts, scan3d_);
  if (!converted) return Fail("cannot be used: " + converted.error().text);
  image.tof = std::move(*converted);
  if (range_per_depth_.empty()) return {};
  if (image.tof.depth_m.size() != range_per_depth_.size()) {
    const std::string size = SizeText(image.tof.depth_m.size());
    image.tof = {};
    return Fail("is " + size + "; the lens is calibrated for " + SizeText(range_per_depth_.size()));
  }
  RangesToDepths(image.tof, range_per_depth_);
  return {};
}

void Device::Trigger() {
  ArvError error;  // ignored: a lost camera is noticed by the heartbeat
  arv_camera_software_trigger(camera_.get(), error.out());
}

void Device::TriggerAt(int64_t device_ns) {
  if (++action_id_ == 0) action_id_ = 1;  // 0 is no number
  // Errors are ignored: a lost camera is noticed by the heartbeat.
  static_cast<void>(SendScheduledAction(ARV_GV_DEVICE(arv_camera_get_device(camera_.get())),
                                        action_id_, static_cast<uint64_t>(device_ns)));
}

std::optional<ClockReading> Device::ReadClock() {
  // The quickest answer has the least delay.
  constexpr int kTries = 5;
  constexpr int64_t kQuickUs = 5000;
  std::optional<ClockReading> best;
  int64_t best_took_us = 0;
  for (int i = 0; i < kTries; ++i) {
    const int64_t asked_us = g_get_real_time();
    const std::optional<int64_t> device_ns = clock_reader_->Read(camera_.get());
    if (!device_ns) return best;
    const int64_t answered_us = g_get_real_time();
    const int64_t took_us = answered_us - asked_us;
    if (!best || took_us < best_took_us) {
      best = ClockReading{*device_ns, answered_us};
      best_took_us = took_us;
    }
    if (best_took_us <= kQuickUs) break;
  }
  return best;
}

void Device::ReadExposure() {
  ArvError error;
  if (!arv_camera_is_exposure_time_available(camera_.get(), error.out()) || error) return;
  const double exposure_us = arv_camera_get_exposure_time(camera_.get(), error.out());
  if (!error) exposure_ns_ = std::llround(exposure_us * 1e3);
}

}  // namespace sprout::capture
