#ifndef SPROUT_SERVICES_BATCH_INTERRUPT_H_
#define SPROUT_SERVICES_BATCH_INTERRUPT_H_

#include <csignal>
#include <stdexcept>

namespace sprout {

/// Ctrl-C. What is whole stays.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted; the same command goes on from here") {}
};

/// Takes note of SIGINT and SIGTERM while it lives. One at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  static bool requested();
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_BATCH_INTERRUPT_H_
