#include "common/core/receive_buffer.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <limits>

namespace sprout {
namespace {

// Asks the kernel: in a network namespace its limit cannot be read.
std::optional<int64_t> GrantedBuffer(int64_t asked) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0) return std::nullopt;
  const int bytes = static_cast<int>(std::min<int64_t>(asked, std::numeric_limits<int>::max()));
  int doubled = 0;  // the kernel counts what it needs itself, too
  socklen_t size = sizeof doubled;
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &doubled, &size);
  close(fd);
  return doubled / 2;
}

}  // namespace

std::optional<std::string> ReceiveBufferShortage(int64_t asked) {
  const std::optional<int64_t> granted = GrantedBuffer(asked);
  if (!granted || *granted >= asked) return std::nullopt;
  return "the kernel grants a receive buffer of " + std::to_string(*granted) + " of " +
         std::to_string(asked) +
         " bytes: large frames may be lost; raise it: sysctl -w net.core.rmem_max=" +
         std::to_string(asked) + " (scripts/setup does it)";
}

}  // namespace sprout
