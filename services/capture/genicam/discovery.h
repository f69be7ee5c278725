#ifndef SPROUT_SERVICES_CAPTURE_GENICAM_DISCOVERY_H_
#define SPROUT_SERVICES_CAPTURE_GENICAM_DISCOVERY_H_

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

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_GENICAM_DISCOVERY_H_
