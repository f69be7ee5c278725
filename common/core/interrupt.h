#ifndef SPROUT_COMMON_CORE_INTERRUPT_H_
#define SPROUT_COMMON_CORE_INTERRUPT_H_

#include <csignal>
#include <stdexcept>

namespace sprout {

/// Ctrl-C: what is half written is removed on the way out, what is whole stays.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Takes note of SIGINT and SIGTERM while it lives; a second one ends the program at once. One at a
/// time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  static bool requested();

  /// For long loops: what is half done is removed on the way out. @throws Interrupted when
  /// requested.
  static void Check() {
    if (requested()) throw Interrupted();
  }
};

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_INTERRUPT_H_
