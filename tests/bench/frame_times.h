#ifndef SPROUT_TESTS_BENCH_FRAME_TIMES_H_
#define SPROUT_TESTS_BENCH_FRAME_TIMES_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace sprout {

/// What processes log about each frame with --log-level debug.
class FrameTimes {
 public:
  /// @param log  what the process of a stage wrote.
  void Read(const std::string& stage, std::string_view log);

  /// Ages of the answers (capture to answer published), and what they may be: twice what all stages
  /// worked on a frame, on average over the answers of the second before, and the time between two
  /// frames. Also what frames spent in each stage: worked on, waiting behind others, and before, on
  /// the way from the stage before until complete (moved).
  /// @param stages  in their order; the last one answers.
  nlohmann::ordered_json Summarise(const std::vector<std::string>& stages, double rate_hz) const;

 private:
  struct Times {
    double waited_ms = 0;  // behind other frames
    double worked_ms = 0;
    double age_ms = 0;
  };
  std::map<std::string, std::map<int64_t, Times>> times_;  // by stage and number of the frame
};

}  // namespace sprout

#endif  // SPROUT_TESTS_BENCH_FRAME_TIMES_H_
