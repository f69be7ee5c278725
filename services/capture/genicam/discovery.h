#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "services/capture/genicam/arv_object.h"

namespace sprout::capture {

/// A camera that answers on the network (GigE Vision) or on a bus (USB3 Vision).
struct FoundCamera {
  std::string id;  ///< Aravis' name for it
  std::string vendor;
  std::string model;
  std::string serial;
  std::string address;   ///< IP address, or address on the bus
  std::string protocol;  ///< "GigEVision", "USB3Vision"

  /// "Lucid HLT003S 213700123 at 192.168.0.7", for messages.
  std::string Text() const;
};

/// Searches every network interface and bus; takes about 1 s. Sorted by serial number. Thread-safe.
std::vector<FoundCamera> FindCameras();

/// A camera under exclusive control of this process.
struct OpenedCamera {
  FoundCamera found;
  ArvObject<ArvCamera> camera;
};

/// Opens the camera with a serial number. Several threads may do so at the same time: the network
/// is searched once for all of them. The error says that it does not answer, that another program
/// holds it, or another reason. Thread-safe.
Result<OpenedCamera> OpenBySerial(const std::string& serial);

/// Keys of action commands, which a camera compares with its own (ActionDeviceKey, ActionGroupKey,
/// ActionGroupMask).
inline constexpr uint32_t kActionDeviceKey = 0x5350524F;  // "SPRO"
inline constexpr uint32_t kActionGroupKey = 1;
inline constexpr uint32_t kActionGroupMask = 1;

/// GigE Vision's ACTION_CMD packet, scheduled (GigE Vision 2.0, GVCP): 8 bytes of header, the three
/// keys, the time; big endian. It requests no answer.
/// @param time_ns  of the cameras' common clock.
std::array<uint8_t, 28> ScheduledAction(uint16_t request_id, uint64_t time_ns);

/// Sends it to one camera; Aravis has no function for this.
Result<void> SendScheduledAction(ArvGvDevice* device, uint16_t request_id, uint64_t time_ns);

}  // namespace sprout::capture
