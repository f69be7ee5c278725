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

constexpr uint8_t kGvcpKey = 0x42;
constexpr uint8_t kScheduled = 0x80;  // flag: a time stands behind the keys
constexpr uint16_t kActionCommand = 0x0100;
constexpr uint16_t kPayloadBytes = 20;

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

std::array<uint8_t, 28> ScheduledAction(uint16_t request_id, uint64_t time_ns) {
  std::array<uint8_t, 28> packet{kGvcpKey, kScheduled};
  auto* next = packet.data() + 2;
  const auto append = [&](auto number) {
    for (size_t i = sizeof number; i-- > 0;) *next++ = static_cast<uint8_t>(number >> (8 * i));
  };
  append(kActionCommand);
  append(kPayloadBytes);
  append(request_id);
  append(kActionDeviceKey);
  append(kActionGroupKey);
  append(kActionGroupMask);
  append(time_ns);
  return packet;
}

Result<void> SendScheduledAction(ArvGvDevice* device, uint16_t request_id, uint64_t time_ns) {
  ArvError error;
  const ArvObject<GSocket> socket(g_socket_new(G_SOCKET_FAMILY_IPV4, G_SOCKET_TYPE_DATAGRAM,
                                               G_SOCKET_PROTOCOL_UDP, error.out()));
  if (error) return Fail("action command: " + error.text());
  const auto packet = ScheduledAction(request_id, time_ns);
  g_socket_send_to(socket.get(), arv_gv_device_get_device_address(device),
                   reinterpret_cast<const char*>(packet.data()), packet.size(), nullptr,
                   error.out());
  if (error) return Fail("action command: " + error.text());
  return {};
}

}  // namespace sprout::capture
