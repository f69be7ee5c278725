#include "common/app/progress.h"

#include <unistd.h>

#include <iostream>

#include "common/core/printable.h"

namespace sprout {
namespace {

constexpr char kClearLine[] = "\r\x1b[K";

}  // namespace

Progress::Progress(bool quiet) : shown_(!quiet && isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { Clear(); }

void Progress::Show(const std::string& text) {
  if (shown_) std::cerr << kClearLine << Printable(text) << std::flush;
}

void Progress::Clear() {
  if (shown_) std::cerr << kClearLine << std::flush;
}

}  // namespace sprout
