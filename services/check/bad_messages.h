#ifndef SPROUT_SERVICES_CHECK_BAD_MESSAGES_H_
#define SPROUT_SERVICES_CHECK_BAD_MESSAGES_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/core/frame.h"

namespace sprout::check {

/// A way to turn a good message into one that no program must take for good.
struct Spoiling {
  std::string name;  ///< "width = -1"
  /// From bytes as EncodePart() gives them, maps as RAW_INT16.
  std::function<std::vector<uint8_t>(std::vector<uint8_t> good)> apply;
};

/// Ways to spoil the message of a part: cut short, of another type, random bytes, counts and sizes
/// that do not fit, numbers that are none. The same ones every time.
std::vector<Spoiling> SpoilingsOf(Part part);

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_CHECK_BAD_MESSAGES_H_
