#pragma once

#include <cstdint>
#include <string_view>

namespace sprout {

/// How often the kernel of this host (its network namespace) could not join the packets of a
/// datagram to any program, since it was started: some were lost, or it had no memory to keep them.
/// It counts datagrams or packets; no program sees these.
int64_t ReassemblyFailures();

/// The same by the text of /proc/net/snmp; 0 where it has no such count.
int64_t ReassemblyFailuresIn(std::string_view snmp);

}  // namespace sprout
