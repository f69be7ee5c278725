#ifndef SPROUT_COMMON_CORE_INTERRUPT_H_
#define SPROUT_COMMON_CORE_INTERRUPT_H_

#include <csignal>
#include <stdexcept>

namespace sprout {

/// Ctrl-C. While it is thrown incomplete files are removed; complete ones stay.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Records SIGINT and SIGTERM while it exists; a second one ends the program at once. Only one
/// object at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  static bool requested();

  /// Ends long loops. @throws Interrupted when a stop was requested.
  static void Check() {
    if (requested()) throw Interrupted();
  }
};

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_INTERRUPT_H_
