#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sprout {

/// One line of warning, with what to do, if the kernel grants a socket a smaller receive buffer
/// than `asked` bytes: then datagrams get lost silently. Nothing if it grants them, or no socket
/// can be opened.
std::optional<std::string> ReceiveBufferShortage(int64_t asked);

}  // namespace sprout
