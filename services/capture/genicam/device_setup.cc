#include "services/capture/genicam/device_setup.h"

#include <fmt/core.h>

#include <cmath>
#include <string_view>

#include "services/capture/genicam/discovery.h"

namespace sprout::capture {
namespace {

// Whether the camera has a feature and can use it now.
bool Has(ArvCamera* camera, const char* feature) {
  ArvError error;
  return arv_camera_is_feature_available(camera, feature, error.out()) && !error;
}

Result<void> ResultOf(const ArvError& error, const std::string& what) {
  if (!error) return {};
  return Fail(what + ": " + error.text());
}

std::string Names(const char** names, unsigned count) {
  std::string text;
  for (unsigned i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + ArvText(names[i]);
  return text;
}

// Checks a number of the rig file against the camera's own bounds, if it tells them.
Result<void> CheckBounds(ArvCamera* camera, const char* field, double value,
                         void (*bounds)(ArvCamera*, double*, double*, GError**)) {
  ArvError error;
  double min = 0;
  double max = 0;
  bounds(camera, &min, &max, error.out());
  if (error || (value >= min && value <= max)) return {};
  return Fail(fmt::format("{} = {}: this camera allows {} to {}", field, value, min, max));
}

// Selects the parts of a ToF camera's payload: ranges, amplitudes and confidences.
Result<void> SetParts(ArvCamera* camera) {
  ArvError error;
  if (arv_camera_is_gv_device(camera)) {
    // Without multipart payloads the components come one after the other, in payloads of their own.
    if (!arv_camera_gv_is_multipart_supported(camera, error.out()) || error) return {};
    arv_camera_gv_set_multipart(camera, TRUE, error.out());
    if (error) return ResultOf(error, "multipart payload");
  }
  if (!arv_camera_is_component_available(camera, error.out()) || error) return {};
  unsigned count = 0;
  const GMemory<const char*> parts(
      arv_camera_dup_available_components(camera, &count, error.out()));
  for (const std::string_view part : {"Intensity", "Confidence", "Range"}) {
    for (unsigned i = 0; parts && i < count; ++i) {
      if (ArvText(parts.get()[i]) != part) continue;
      // The last one stays selected: the pixel format is that of the ranges.
      arv_camera_select_component(camera, part.data(), ARV_COMPONENT_SELECTION_FLAGS_ENABLE,
                                  nullptr, error.out());
      if (error) return ResultOf(error, "component " + std::string(part));
    }
  }
  return {};
}

Result<void> SetPixelFormat(ArvCamera* camera, const std::string& format) {
  if (format.empty()) return {};
  ArvError error;
  arv_camera_set_pixel_format_from_string(camera, format.c_str(), error.out());
  if (!error) return {};
  const std::string reason = error.text();
  unsigned count = 0;
  const GMemory<const char*> formats(
      arv_camera_dup_available_pixel_formats_as_strings(camera, &count, error.out()));
  const std::string allowed = formats ? Names(formats.get(), count) : reason;
  return Fail("pixel_format = " + format + ": this camera allows " + allowed);
}

Result<void> SetExposure(ArvCamera* camera, double exposure_us) {
  if (exposure_us <= 0) return {};
  ArvError error;
  if (arv_camera_is_exposure_auto_available(camera, error.out())) {
    arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, error.out());
    if (error) return ResultOf(error, "exposure_us");
  }
  const Result<void> fits =
      CheckBounds(camera, "exposure_us", exposure_us, arv_camera_get_exposure_time_bounds);
  if (!fits) return fits;
  arv_camera_set_exposure_time(camera, exposure_us, error.out());
  return ResultOf(error, fmt::format("exposure_us = {}", exposure_us));
}

Result<void> SetGain(ArvCamera* camera, double gain_db) {
  if (gain_db < 0) return {};
  ArvError error;
  if (arv_camera_is_gain_auto_available(camera, error.out())) {
    arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, error.out());
    if (error) return ResultOf(error, "gain_db");
  }
  const Result<void> fits = CheckBounds(camera, "gain_db", gain_db, arv_camera_get_gain_bounds);
  if (!fits) return fits;
  arv_camera_set_gain(camera, gain_db, error.out());
  return ResultOf(error, fmt::format("gain_db = {}", gain_db));
}

Result<void> SetPacketSize(ArvCamera* camera, int packet_size) {
  if (!arv_camera_is_gv_device(camera)) return {};
  // Aravis then finds the largest size that arrives, when the stream is made.
  if (packet_size == 0) {
    arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_ALWAYS);
    return {};
  }
  arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
  ArvError error;
  arv_camera_gv_set_packet_size(camera, packet_size, error.out());
  return ResultOf(error, fmt::format("packet_size = {}", packet_size));
}

Result<void> SetFreeRun(ArvCamera* camera, double frame_rate_hz) {
  ArvError error;
  arv_camera_clear_triggers(camera, error.out());
  if (error) return ResultOf(error, "trigger = FREE_RUN");
  if (!arv_camera_is_frame_rate_available(camera, error.out())) return {};
  const Result<void> fits =
      CheckBounds(camera, "frame_rate_hz", frame_rate_hz, arv_camera_get_frame_rate_bounds);
  if (!fits) return fits;
  arv_camera_set_frame_rate(camera, frame_rate_hz, error.out());
  return ResultOf(error, fmt::format("frame_rate_hz = {}", frame_rate_hz));
}

Result<void> SetTriggerSource(ArvCamera* camera, const char* source, const std::string& what) {
  ArvError error;
  arv_camera_set_trigger(camera, source, error.out());
  if (!error) return {};
  const std::string reason = error.text();
  unsigned count = 0;
  const GMemory<const char*> sources(
      arv_camera_dup_available_trigger_sources(camera, &count, error.out()));
  return Fail(fmt::format("{}: trigger source {}: {}; this camera has: {}", what, source, reason,
                          sources ? Names(sources.get(), count) : "none"));
}

// `source` if the camera has it, else `otherwise`: cameras count lines and actions from 0 or
// from 1.
const char* FirstSource(ArvCamera* camera, const char* source, const char* otherwise) {
  ArvError error;
  const bool has_it =
      arv_camera_is_enumeration_entry_available(camera, "TriggerSource", source, error.out());
  return has_it && !error ? source : otherwise;
}

Result<void> SetInteger(ArvCamera* camera, const char* feature, int64_t value) {
  ArvError error;
  arv_camera_set_integer(camera, feature, value, error.out());
  return ResultOf(error, "trigger = PTP: " + std::string(feature));
}

// Sets the camera to the network's clock, and to exposures at the times of action commands.
Result<void> SetPtp(ArvCamera* camera) {
  const char* enable = Has(camera, "PtpEnable") ? "PtpEnable" : "GevIEEE1588";  // new, old cameras
  if (!arv_camera_is_gv_device(camera) || !Has(camera, enable)) {
    return Fail("trigger = PTP: this camera has no PTP; allowed: FREE_RUN, SOFTWARE, LINE");
  }
  ArvError error;
  arv_camera_set_boolean(camera, enable, TRUE, error.out());
  if (error) return ResultOf(error, "trigger = PTP: " + std::string(enable));
  const char* source = FirstSource(camera, "Action0", "Action1");
  const int number = source[std::string_view("Action").size()] - '0';
  Result<void> done;
  if (Has(camera, "ActionSelector")) done = SetInteger(camera, "ActionSelector", number);
  if (done) done = SetInteger(camera, "ActionDeviceKey", kActionDeviceKey);
  if (done) done = SetInteger(camera, "ActionGroupKey", kActionGroupKey);
  if (done) done = SetInteger(camera, "ActionGroupMask", kActionGroupMask);
  if (!done) return done;
  return SetTriggerSource(camera, source, "trigger = PTP");
}

Result<void> SetTrigger(ArvCamera* camera, const DeviceSettings& settings) {
  switch (settings.trigger) {
    case RigDescription::FREE_RUN:
      return SetFreeRun(camera, settings.frame_rate_hz);
    case RigDescription::SOFTWARE:
      return SetTriggerSource(camera, "Software", "trigger = SOFTWARE");
    case RigDescription::LINE:
      return SetTriggerSource(camera, FirstSource(camera, "Line0", "Line1"), "trigger = LINE");
    case RigDescription::PTP:
      break;
  }
  return SetPtp(camera);
}

double ReadFloat(ArvCamera* camera, const char* feature, double otherwise) {
  if (!Has(camera, feature)) return otherwise;
  ArvError error;
  const double value = arv_camera_get_float(camera, feature, error.out());
  return error ? otherwise : value;
}

std::string ReadEntry(ArvCamera* camera, const char* feature) {
  if (!Has(camera, feature)) return "";
  ArvError error;
  const std::string entry = ArvText(arv_camera_get_string(camera, feature, error.out()));
  return error ? "" : entry;
}

// Metres of SFNC's Scan3dDistanceUnit; a millimetre is its default.
double UnitMetres(const std::string& unit) {
  if (unit == "Inch") return 0.0254;
  if (unit == "Meter" || unit == "Metre") return 1;
  return 1e-3;
}

}  // namespace

Result<void> SetUpCamera(ArvCamera* camera, const DeviceSettings& settings) {
  const CameraDevice& device = settings.device;
  ArvError error;
  // A program that died may have left it running; one that does not run may refuse.
  arv_camera_stop_acquisition(camera, error.out());
  Result<void> done;
  if (settings.is_tof) done = SetParts(camera);
  if (done) done = SetPixelFormat(camera, device.pixel_format());
  if (done) done = SetExposure(camera, device.exposure_us());
  if (done) done = SetGain(camera, device.gain_db());
  if (done) done = SetPacketSize(camera, device.packet_size());
  if (done) done = SetTrigger(camera, settings);
  if (!done) return done;
  arv_camera_set_acquisition_mode(camera, ARV_ACQUISITION_MODE_CONTINUOUS, error.out());
  return ResultOf(error, "continuous acquisition");
}

ClockReader::ClockReader(ArvCamera* camera) {
  if (Has(camera, "TimestampLatch") && Has(camera, "TimestampLatchValue")) {
    latch_ = "TimestampLatch";
    value_ = "TimestampLatchValue";
    return;
  }
  if (!Has(camera, "GevTimestampControlLatch") || !Has(camera, "GevTimestampValue")) return;
  ArvError error;
  const int64_t frequency_hz =
      arv_camera_get_integer(camera, "GevTimestampTickFrequency", error.out());
  if (error || frequency_hz <= 0) return;
  tick_ns_ = 1e9 / static_cast<double>(frequency_hz);
  latch_ = "GevTimestampControlLatch";
  value_ = "GevTimestampValue";
}

std::optional<int64_t> ClockReader::Read(ArvCamera* camera) const {
  if (!latch_) return std::nullopt;
  ArvError error;
  arv_camera_execute_command(camera, latch_, error.out());
  if (error) return std::nullopt;
  const int64_t ticks = arv_camera_get_integer(camera, value_, error.out());
  if (error) return std::nullopt;
  // A tick of 1 ns needs all digits of the number.
  if (tick_ns_ == 1) return ticks;
  return std::llround(static_cast<double>(ticks) * tick_ns_);
}

Scan3d ReadScan3d(ArvCamera* camera) {
  ArvError error;
  if (Has(camera, "Scan3dCoordinateSelector")) {
    arv_camera_set_string(camera, "Scan3dCoordinateSelector", "CoordinateC", error.out());
  }
  Scan3d scan3d;
  scan3d.scale = ReadFloat(camera, "Scan3dCoordinateScale", scan3d.scale);
  scan3d.offset = ReadFloat(camera, "Scan3dCoordinateOffset", scan3d.offset);
  scan3d.unit_m = UnitMetres(ReadEntry(camera, "Scan3dDistanceUnit"));
  scan3d.is_range = ReadEntry(camera, "Scan3dCoordinateSystem") == "Spherical";
  if (Has(camera, "Scan3dInvalidDataFlag") &&
      arv_camera_get_boolean(camera, "Scan3dInvalidDataFlag", error.out()) && !error &&
      Has(camera, "Scan3dInvalidDataValue")) {
    const double value = arv_camera_get_float(camera, "Scan3dInvalidDataValue", error.out());
    if (!error) scan3d.invalid = value;
  }
  return scan3d;
}

std::optional<Lens> ReadLens(ArvCamera* camera) {
  ArvError error;
  Lens lens;
  arv_camera_get_region(camera, nullptr, nullptr, &lens.width, &lens.height, error.out());
  lens.fx = ReadFloat(camera, "Scan3dFocalLength", 0);
  lens.fy = lens.fx;
  lens.cx = ReadFloat(camera, "Scan3dPrincipalPointU", (lens.width - 1) / 2.0);
  lens.cy = ReadFloat(camera, "Scan3dPrincipalPointV", (lens.height - 1) / 2.0);
  if (error || lens.fx <= 0) return std::nullopt;
  return lens;
}

}  // namespace sprout::capture
