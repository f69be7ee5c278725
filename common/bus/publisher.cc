#include "common/bus/publisher.h"

#include <cerrno>
#include <system_error>

#include "common/bus/datagram_joiner.h"

namespace sprout {

bool Publisher::Publish(std::string_view channel, std::span<const uint8_t> bytes) {
  const std::string name = prefix_ + std::string(channel);
  int error = EMSGSIZE;
  if (bytes.size() <= DatagramJoiner::kMaxMessageBytes) {
    errno = 0;
    const int result = lcm_publish(lcm_.get(), name.c_str(), bytes.data(),
                                   static_cast<unsigned int>(bytes.size()));
    error = errno;
    // Of a message of several datagrams LCM says that it was sent, whatever became of them.
    if (result == 0 && (error == 0 || !is_udpm_)) return true;
  }
  failure_ = std::string(channel) + ": could not be published";
  if (error != 0) failure_ += " (" + std::generic_category().message(error) + ")";
  return false;
}

}  // namespace sprout
