#include "services/capture/genicam/action_command.h"

namespace sprout::capture {
namespace {

constexpr uint8_t kGvcpKey = 0x42;
constexpr uint8_t kScheduled = 0x80;  // flag: a time stands behind the keys
constexpr uint16_t kActionCommand = 0x0100;
constexpr uint16_t kPayloadBytes = 20;

}  // namespace

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
