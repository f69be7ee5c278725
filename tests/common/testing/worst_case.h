#pragma once

#include <ctime>

namespace sprout {

/// How many seeds, points or the like a test of a worst case has, and what they may take, s of
/// processor time: five times what the slowest takes, and still far less than what is quadratic in
/// their number. Sanitizers make all of it many times slower, and are not there to measure.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kWorstCount = 20'000;
inline constexpr double kWorstSeconds = 200;
#else
inline constexpr int kWorstCount = 300'000;
inline constexpr double kWorstSeconds = 30;
#endif

/// Seconds of processor time that work() takes, those of all threads.
template <typename Work>
double CpuSeconds(const Work& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

}  // namespace sprout
