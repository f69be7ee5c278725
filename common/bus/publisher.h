#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/bus/datagram_joiner.h"
#include "common/bus/lcm_url.h"

namespace sprout {

/// Sends messages over its own connection. Not thread-safe.
class Publisher {
 public:
  /// @param prefix  put before every channel, so that two graphs run side by side.
  /// @throws BusError, see OpenLcm().
  Publisher(const std::string& url, std::string prefix)
      : lcm_(OpenLcm(url)), prefix_(std::move(prefix)) {}

  /// @returns false when LCM refused the message, or it is larger than anybody would take.
  [[nodiscard]] bool Publish(std::string_view channel, std::span<const uint8_t> bytes) {
    if (bytes.size() > DatagramJoiner::kMaxMessageBytes) return false;
    const std::string name = prefix_ + std::string(channel);
    return lcm_publish(lcm_.get(), name.c_str(), bytes.data(),
                       static_cast<unsigned int>(bytes.size())) == 0;
  }

 private:
  LcmPtr lcm_;
  std::string prefix_;
};

}  // namespace sprout
