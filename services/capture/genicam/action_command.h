#ifndef SPROUT_SERVICES_CAPTURE_GENICAM_ACTION_COMMAND_H_
#define SPROUT_SERVICES_CAPTURE_GENICAM_ACTION_COMMAND_H_

#include <array>
#include <cstdint>

#include "common/core/result.h"
#include "services/capture/genicam/arv_object.h"

namespace sprout::capture {

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

#endif  // SPROUT_SERVICES_CAPTURE_GENICAM_ACTION_COMMAND_H_
