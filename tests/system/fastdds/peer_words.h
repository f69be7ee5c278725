#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

namespace sprout::fast_peer {

inline volatile std::sig_atomic_t has_to_end = 0;

inline double Now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

inline void SleepTo(double when) {
  while (!has_to_end && Now() < when) {
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(when - Now(), 0.05)));
  }
}

// Words behind the fixed arguments: "name=value" or "name".
class Options {
 public:
  Options(int count, char** words) : words_(words, words + std::max(count, 0)) {}
  bool Has(const std::string& name) const {
    return std::find(words_.begin(), words_.end(), name) != words_.end();
  }
  std::string Get(const std::string& name, const std::string& other) const {
    for (const std::string& word : words_) {
      if (word.rfind(name + "=", 0) == 0) return word.substr(name.size() + 1);
    }
    return other;
  }
  double Number(const std::string& name, double other) const {
    const std::string text = Get(name, "");
    return text.empty() ? other : std::atof(text.c_str());
  }
  const std::vector<std::string>& words() const { return words_; }

 private:
  std::vector<std::string> words_;
};

}  // namespace sprout::fast_peer
