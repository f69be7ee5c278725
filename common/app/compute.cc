#include "common/app/compute.h"

#include <hwy/highway.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <memory>
#include <opencv2/core/utility.hpp>

#include "common/app/log.h"
#include "common/config/config_error.h"

namespace sprout {
namespace {

// The instruction set that every CPU has.
constexpr int64_t kScalar = HWY_SCALAR;

std::string NameOf(int64_t target) {
  if (target == kScalar) return "scalar";
  std::string name = hwy::TargetName(target);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

// Best first: Highway gives better instruction sets lower bits.
std::vector<int64_t> Targets() {
  constexpr bool kOne = (HWY_TARGETS & (HWY_TARGETS - 1)) == 0;
  if (kOne) return {HWY_TARGETS};  // nothing is chosen when the program runs
  std::vector<int64_t> targets;
  for (int64_t rest = hwy::SupportedTargets() & HWY_TARGETS & ~kScalar; rest != 0;
       rest &= rest - 1) {
    targets.push_back(rest & -rest);
  }
  targets.push_back(kScalar);
  return targets;
}

}  // namespace

void SetThreads(int count) { cv::setNumThreads(count > 0 ? count : cv::getNumberOfCPUs()); }

std::vector<std::string> SimdLevels() {
  std::vector<std::string> levels;
  for (const int64_t target : Targets()) levels.push_back(NameOf(target));
  return levels;
}

void LimitSimd(const std::string& level) {
  if (level == "best") return;
  int64_t better = 0;
  std::string allowed = "best";
  for (const int64_t target : Targets()) {
    if (NameOf(target) == level) return hwy::DisableTargets(better);
    better |= target;
    allowed += ", " + NameOf(target);
  }
  throw ConfigError("--simd '" + level + "': this CPU has " + allowed);
}

void KeepMemory() {
#ifdef __GLIBC__
  constexpr int kMaxFromHeap = 32 << 20;  // bytes; glibc takes no more. 8 MP in colour have 24 MB
  mallopt(M_MMAP_THRESHOLD, kMaxFromHeap);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

void TouchMemory(size_t bytes) {
  constexpr size_t kBlock = size_t{8} << 20;  // bytes; a map of a frame, far from kMaxFromHeap
  constexpr size_t kPage = 4096;              // the smallest that Linux has
  std::vector<std::unique_ptr<char[]>> blocks((bytes + kBlock - 1) / kBlock);
  for (std::unique_ptr<char[]>& block : blocks) {
    block = std::make_unique_for_overwrite<char[]>(kBlock);
    // Volatile: the compiler knows that nobody reads them.
    volatile char* const first = block.get();
    for (size_t i = 0; i < kBlock; i += kPage) first[i] = 0;
  }
}

void LowerPriority() {
  constexpr int kNice = 10;
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  if (setpriority(PRIO_PROCESS, thread, kNice) != 0)
    LogLine(LogLevel::kDebug, "the priority stays as it is");
}

}  // namespace sprout
