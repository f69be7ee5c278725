#ifndef SPROUT_COMMON_CORE_RECEIVE_BUFFER_H_
#define SPROUT_COMMON_CORE_RECEIVE_BUFFER_H_

#include <cstdint>
#include <optional>
#include <string>

namespace sprout {

/// One line of warning, with what to do, if the kernel grants a socket a smaller receive buffer
/// than `asked` bytes: then datagrams get lost silently. Nothing if it grants them, or no socket
/// can be opened.
std::optional<std::string> ReceiveBufferShortage(int64_t asked);

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_RECEIVE_BUFFER_H_
