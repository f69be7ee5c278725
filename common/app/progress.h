#pragma once

#include <string>
#include <thread>

namespace sprout {

/// One line of progress on stderr, cut to the terminal's width. Only for people: nothing is written
/// unless stderr is a terminal.
/// The line is erased when the object is destroyed.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Show(const std::string& text);

  /// For work that cannot say how far it is: shows the text, and from the second second on behind
  /// it for how long, until something else is shown.
  void ShowTime(const std::string& text);

  /// Erases the line, to make room for other output.
  void Clear();

 private:
  bool shown_;
  std::jthread clock_;
};

}  // namespace sprout
