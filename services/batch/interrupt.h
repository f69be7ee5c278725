#ifndef SPROUT_SERVICES_BATCH_INTERRUPT_H_
#define SPROUT_SERVICES_BATCH_INTERRUPT_H_

#include <csignal>
#include <stdexcept>

namespace sprout::batch {

/// Ctrl-C. What is whole stays.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted; the same command goes on from here") {}
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

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_INTERRUPT_H_
