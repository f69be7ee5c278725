#pragma once

#include <memory>
#include <string>
#include <vector>

namespace sprout {

/// Takes what is logged while it lives.
class CapturedLog {
 public:
  CapturedLog();
  ~CapturedLog();

  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;

  /// Also while other threads log.
  std::vector<std::string> Lines() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sprout
