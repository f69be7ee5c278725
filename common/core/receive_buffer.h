#ifndef SPROUT_COMMON_CORE_RECEIVE_BUFFER_H_
#define SPROUT_COMMON_CORE_RECEIVE_BUFFER_H_

#include <cstdint>
#include <optional>
#include <string>

namespace sprout {

/// One line that says so, and what to do, when the kernel grants a socket a smaller receive buffer
/// than `asked` bytes; the price is lost datagrams, of which nobody tells. Nothing when it grants
/// them, or no socket can be had.
std::optional<std::string> ReceiveBufferShortage(int64_t asked);

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_RECEIVE_BUFFER_H_
