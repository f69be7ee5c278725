#include "common/bus/publisher.h"

#include <cerrno>
#include <system_error>

#include "common/bus/datagram_joiner.h"

namespace sprout {
namespace {

// Up to which size of channel and bytes LCM sends a message in one datagram, and says of it whether
// it was sent. Of a message of several it says that it was, whatever became of them.
constexpr size_t kMaxInOneDatagram = 65498;

}  // namespace

bool Publisher::Publish(std::string_view channel, std::span<const uint8_t> bytes) {
  const std::string name = prefix_ + std::string(channel);
  int error = EMSGSIZE;
  if (bytes.size() <= DatagramJoiner::kMaxMessageBytes) {
    errno = 0;
    const int result = lcm_publish(lcm_.get(), name.c_str(), bytes.data(),
                                   static_cast<unsigned int>(bytes.size()));
    error = errno;
    const bool is_in_parts = is_udpm_ && name.size() + bytes.size() > kMaxInOneDatagram;
    if (result == 0 && (error == 0 || !is_in_parts)) return true;
  }
  failure_ = std::string(channel) + ": could not be published";
  if (error != 0) failure_ += " (" + std::generic_category().message(error) + ")";
  return false;
}

}  // namespace sprout
