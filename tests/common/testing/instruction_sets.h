#pragma once

#include <hwy/highway.h>

#include <cstdint>
#include <string>
#include <vector>

namespace sprout {

/// Calls run(name) with every instruction set that this CPU has, and with none.
template <typename Run>
void ForEachInstructionSet(const Run& run) {
  std::vector<int64_t> sets = {HWY_SCALAR};
  for (int64_t all = hwy::SupportedTargets(); all != 0; all &= all - 1) sets.push_back(all & -all);
  for (const int64_t set : sets) {
    hwy::SetSupportedTargetsForTest(set);
    hwy::GetChosenTarget().DeInit();  // chosen anew at the next call
    run(std::string(hwy::TargetName(set)));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

}  // namespace sprout
