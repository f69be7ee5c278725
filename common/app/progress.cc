#include "common/app/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>

#include "common/core/printable.h"
#include "common/core/sleep.h"

namespace sprout {
namespace {

constexpr char kClearLine[] = "\r\x1b[K";

// Replaces the line by text and end. The text is cut to the terminal's width, beyond which it would
// fill another line that is never erased.
void Replace(const std::string& text, const std::string& end = "") {
  std::string shown = Printable(text);
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) {
    size_t left = size.ws_col - std::min<size_t>(size.ws_col, end.size() + 1);
    const auto begins = [](char byte) { return (byte & 0xc0) != 0x80; };  // a letter of UTF-8
    const auto last = std::ranges::find_if(shown, [&](char b) { return begins(b) && left-- == 0; });
    shown.erase(last, shown.end());
  }
  std::cerr << kClearLine << shown << end << std::flush;
}

}  // namespace

Progress::Progress(bool quiet) : shown_(!quiet && isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { Clear(); }

void Progress::Show(const std::string& text) {
  clock_ = {};
  if (shown_) Replace(text);
}

void Progress::ShowTime(const std::string& text) {
  Show(text);
  if (!shown_) return;
  clock_ = std::jthread([text](const std::stop_token& stop) {
    for (int seconds = 1; SleepFor(std::chrono::seconds(1), stop); ++seconds) {
      Replace(text, ", " + std::to_string(seconds) + " s");
    }
  });
}

void Progress::Clear() {
  clock_ = {};
  if (shown_) std::cerr << kClearLine << std::flush;
}

}  // namespace sprout
