#ifndef SPROUT_COMMON_APP_COMPUTE_H_
#define SPROUT_COMMON_APP_COMPUTE_H_

#include <string>
#include <vector>

namespace sprout {

/// Threads that the stages share, OpenCV's own work included. What they compute does not depend on
/// it.
/// @param count  0 = as many as there are cores.
void SetThreads(int count);

/// Instruction sets that growth and gap filling were built for and this CPU has, best first. Names
/// as Highway's, in small letters: on x86-64 "avx3", "avx2", "sse4", "ssse3" and always "scalar",
/// on Arm "neon" alone.
std::vector<std::string> SimdLevels();

/// Lets growth and gap filling use nothing better than this instruction set, for the life of the
/// process. What it computes does not depend on it. To be called before the first frame.
/// @param level  one of SimdLevels(), or "best".
/// @throws ConfigError for any other.
void LimitSimd(const std::string& level);

/// Lets the process keep the memory that it has used, for the frames to come. Otherwise the C
/// library gives large buffers back to the kernel, frame by frame, and first touching new pages
/// took 40 of 180 ms a frame (four processes, 2 MP). Only with glibc.
void KeepMemory();

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_COMPUTE_H_
