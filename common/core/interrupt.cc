#include "common/core/interrupt.h"

namespace sprout {
namespace {

volatile std::sig_atomic_t came = 0;

}  // namespace

Interrupt::Interrupt() {
  came = 0;
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int number) {
      came = 1;
      std::signal(number, SIG_DFL);
    });
  }
}

Interrupt::~Interrupt() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
}

bool Interrupt::requested() { return came != 0; }

}  // namespace sprout
