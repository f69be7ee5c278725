#include "common/app/progress.h"

#include <unistd.h>

#include <chrono>
#include <iostream>

#include "common/core/printable.h"
#include "common/core/sleep.h"

namespace sprout {
namespace {

constexpr char kClearLine[] = "\r\x1b[K";

}  // namespace

Progress::Progress(bool quiet) : shown_(!quiet && isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { Clear(); }

void Progress::Show(const std::string& text) {
  clock_ = {};
  if (shown_) std::cerr << kClearLine << Printable(text) << std::flush;
}

void Progress::ShowTime(const std::string& text) {
  Show(text);
  if (!shown_) return;
  clock_ = std::jthread([text](const std::stop_token& stop) {
    for (int seconds = 1; SleepFor(std::chrono::seconds(1), stop); ++seconds) {
      std::cerr << kClearLine << Printable(text) << ", " << seconds << " s" << std::flush;
    }
  });
}

void Progress::Clear() {
  clock_ = {};
  if (shown_) std::cerr << kClearLine << std::flush;
}

}  // namespace sprout
