#ifndef SPROUT_SERVICES_TOOLS_CHECK_BAD_MESSAGES_H_
#define SPROUT_SERVICES_TOOLS_CHECK_BAD_MESSAGES_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/core/frame.h"

namespace sprout::check {

/// A way to corrupt a valid message, such that every program must refuse it.
struct Corruption {
  std::string name;  ///< "width = -1"
  /// Takes bytes of EncodePart(), with maps as RAW_INT16.
  std::function<std::vector<uint8_t>(std::vector<uint8_t> good)> apply;
};

/// Ways to corrupt the message of a part: cut short, of another type, random bytes, counts and
/// sizes that do not fit, NaN and infinities. Always the same ones.
std::vector<Corruption> CorruptionsOf(Part part);

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_TOOLS_CHECK_BAD_MESSAGES_H_
