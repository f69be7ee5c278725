#include "services/capture/genicam/discovery.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>

namespace sprout::capture {
namespace {

using Clock = std::chrono::steady_clock;

// Aravis keeps one list for the whole process.
std::mutex& ListMutex() {
  static std::mutex mutex;
  return mutex;
}

std::vector<FoundCamera> UpdatedList() {
  arv_update_device_list();
  std::vector<FoundCamera> cameras;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    cameras.push_back({.id = ArvText(arv_get_device_id(i)),
                       .vendor = ArvText(arv_get_device_vendor(i)),
                       .model = ArvText(arv_get_device_model(i)),
                       .serial = ArvText(arv_get_device_serial_nbr(i)),
                       .address = ArvText(arv_get_device_address(i)),
                       .protocol = ArvText(arv_get_device_protocol(i))});
  }
  std::ranges::sort(cameras, {}, &FoundCamera::serial);
  return cameras;
}

// Whether others write to it: a GigE Vision camera can be read all the same.
bool IsHeldByOthers(ArvCamera* camera) {
  return arv_camera_is_gv_device(camera) &&
         !arv_gv_device_is_controller(ARV_GV_DEVICE(arv_camera_get_device(camera)));
}

// What a camera can give, or why that is not known.
std::string Abilities(const FoundCamera& found) {
  ArvError error;
  const ArvObject<ArvCamera> camera(arv_camera_new(found.id.c_str(), error.out()));
  if (error || !camera) return "cannot be opened: " + error.text();
  int width = 0;
  int height = 0;
  arv_camera_get_sensor_size(camera.get(), &width, &height, error.out());
  std::string text = error ? "size unknown" : fmt::format("{}x{}", width, height);
  unsigned count = 0;
  const GMemory<const char*> formats(
      arv_camera_dup_available_pixel_formats_as_strings(camera.get(), &count, error.out()));
  for (unsigned i = 0; formats && i < count; ++i) text += " " + ArvText(formats.get()[i]);
  if (IsHeldByOthers(camera.get())) text += " (another program holds it)";
  return text;
}

}  // namespace

std::string FoundCamera::Text() const {
  return fmt::format("{} {} {} at {}", vendor, model, serial, address);
}

std::vector<FoundCamera> FindCameras() {
  const std::lock_guard lock(ListMutex());
  return UpdatedList();
}

Result<OpenedCamera> OpenBySerial(const std::string& serial) {
  // A rig's cameras look at the same time; one answer is good for all of them.
  constexpr auto kFresh = std::chrono::milliseconds(500);
  static std::vector<FoundCamera> cameras;
  static std::optional<Clock::time_point> updated;
  const std::lock_guard lock(ListMutex());
  if (!updated || Clock::now() > *updated + kFresh) {
    cameras = UpdatedList();
    updated = Clock::now();
  }
  const auto found = std::ranges::find(cameras, serial, &FoundCamera::serial);
  if (found == cameras.end()) {
    return Fail("does not answer (sprout-capture --list shows the cameras that do)");
  }
  ArvError error;
  ArvObject<ArvCamera> camera(arv_camera_new(found->id.c_str(), error.out()));
  if (error || !camera) return Fail(found->Text() + " cannot be opened: " + error.text());
  if (IsHeldByOthers(camera.get())) return Fail(found->Text() + ": another program holds it");
  return OpenedCamera{*found, std::move(camera)};
}

std::string ListCameras() {
  const std::vector<FoundCamera> cameras = FindCameras();
  if (cameras.empty()) return "no camera answers\n";
  std::string text;
  for (const FoundCamera& camera : cameras) {
    text += fmt::format("{} {}  serial {}  {} {}  {}\n", camera.vendor, camera.model, camera.serial,
                        camera.protocol, camera.address, Abilities(camera));
  }
  return text;
}

}  // namespace sprout::capture
