#pragma once

#include <cstdint>
#include <string>

namespace sprout {

/// Registers of a fake camera that Aravis' simulator does not know; fake_camera writes them.
enum Register : uint32_t {
  kScale = 0x400,
  kFocalLength = 0x418,
  kPrincipalU = 0x420,
  kPrincipalV = 0x428,
  kCoordinateSystem = 0x438,
  kTimestampLatch = 0x43c,
  kTimestampLatchValue = 0x440,
};

/// What a fake camera says of itself: GenICam's XML (GenApi 1.1).
std::string FakeCameraFeatures();

}  // namespace sprout
