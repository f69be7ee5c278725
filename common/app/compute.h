#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sprout {

/// The largest number of threads that SetThreads() accepts.
inline constexpr int kMaxThreads = 1024;

/// Sets the number of threads that the stages and OpenCV share. Results do not depend on it.
/// @param count  0 = as many as there are cores; at most kMaxThreads.
void SetThreads(int count);

/// Instruction sets for which growth and gap filling were built and that this CPU has, best first.
/// Names are Highway's in lower case: on x86-64 "avx3", "avx2", "sse4", "ssse3" and always
/// "scalar", on Arm only "neon".
std::vector<std::string> SimdLevels();

/// Limits growth and gap filling to this instruction set, for the life of the process. Results do
/// not depend on it. Call before the first frame.
/// @param level  one of SimdLevels(), or "best".
/// @throws ConfigError for any other.
void LimitSimd(const std::string& level);

/// Lets the process keep freed memory for later frames. Otherwise the C library gives large buffers
/// back to the kernel, frame by frame, and touching new pages first took 40 of 180 ms a frame (four
/// processes, 2 MP). Only with glibc.
void KeepMemory();

/// Touches memory of the calling thread that KeepMemory() then keeps, so that the first frame finds
/// its pages: new ones take 0.25 ms a MB, zeroed by the kernel. Without KeepMemory() it is of no
/// use.
/// @param bytes  how much is needed at the same time, about.
void TouchMemory(size_t bytes);

/// Lowers the priority of the calling thread, and of those that it starts: what only looks at the
/// graph must not slow it down.
void LowerPriority();

}  // namespace sprout
