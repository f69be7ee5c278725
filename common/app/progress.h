#ifndef SPROUT_COMMON_APP_PROGRESS_H_
#define SPROUT_COMMON_APP_PROGRESS_H_

#include <string>

namespace sprout {

/// One line on stderr that says what is being done. Only for people: nothing is written unless
/// stderr is a terminal. The line goes away with the object.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Show(const std::string& text);

  /// Takes the line away, to make room for other output.
  void Clear();

 private:
  bool shown_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_PROGRESS_H_
