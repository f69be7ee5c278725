#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/bus/lcm_url.h"

namespace sprout {

/// Sends messages over its own connection. Not thread-safe.
class Publisher {
 public:
  /// @param prefix  put before every channel, so that two graphs run side by side.
  /// @throws BusError, see OpenLcm().
  Publisher(const std::string& url, std::string prefix)
      : lcm_(OpenLcm(url)), is_udpm_(IsUdpm(url)), prefix_(std::move(prefix)) {}

  /// @returns false when not all of the message could be sent, or it is larger than anybody would
  ///          take; then see failure().
  [[nodiscard]] bool Publish(std::string_view channel, std::span<const uint8_t> bytes);

  /// Which message could not be published last, and why, in one line.
  const std::string& failure() const { return failure_; }

 private:
  LcmPtr lcm_;
  bool is_udpm_;
  std::string prefix_;
  std::string failure_;
};

}  // namespace sprout
