#include "services/tools/batch/batch_state.h"

#include <fmt/core.h>

#include <iostream>

#include "common/core/interrupt.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/result_folder.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

bool IsDone(const BatchFolder& folder, const Manifest& manifest, int log) {
  for (int i = 0; i < manifest.variant_size(); ++i) {
    if (!IsWhole(folder.result(manifest, log, i), ResultCheck::kQuick)) return false;
  }
  return !Compares(manifest) || IsWhole(folder.comparison(manifest, log), ResultCheck::kQuick);
}

// @returns false when the result is damaged.
bool LinkOne(const BatchFolder& folder, const Manifest& manifest, int log, int variant) {
  const fs::path result = folder.result(manifest, log, variant);
  const fs::path link = folder.answers(manifest.log(log), variant);
  const fs::path target = fs::relative(result, link.parent_path()) / kAnswers;
  std::error_code none;
  if (fs::read_symlink(link, none) == target) return true;
  fs::remove(link);
  if (!IsWhole(result, ResultCheck::kAll)) {
    std::cerr << fmt::format("sprout-batch: {}: damaged; log {} is computed again\n",
                             result.string(), log);
    MarkDamaged(result);
    return false;
  }
  if (fs::exists(result / kAnswers)) fs::create_symlink(target, link);
  return true;
}

}  // namespace

BatchState StateOf(const BatchFolder& folder, const Manifest& manifest) {
  BatchState state;
  for (int log = 0; log < manifest.log_size(); ++log) {
    state.done.push_back(IsDone(folder, manifest, log));
    if (!state.done.back()) ++state.missing;
  }
  return state;
}

BatchState LinkAnswers(const BatchFolder& folder, const Manifest& manifest) {
  fs::create_directories(folder.root() / "logs");
  BatchState state = StateOf(folder, manifest);
  for (int log = 0; log < manifest.log_size(); ++log) {
    const auto at = static_cast<size_t>(log);
    for (int i = 0; i < manifest.variant_size(); ++i) {
      Interrupt::Check();
      if (!state.done[at]) {
        fs::remove(folder.answers(manifest.log(log), i));  // of an earlier batch
      } else if (!LinkOne(folder, manifest, log, i)) {
        state.done[at] = false;
        ++state.missing;
      }
    }
  }
  return state;
}

void RemoveParts(const BatchFolder& folder) {
  std::vector<fs::path> parts;
  for (const char* const kind : {"results", "comparisons"}) {
    if (!fs::exists(folder.root() / kind)) continue;
    for (const auto& group : fs::directory_iterator(folder.root() / kind)) {
      for (const auto& result : fs::directory_iterator(group)) {
        if (result.path().filename().string().find(".part-") != std::string::npos) {
          parts.push_back(result.path());
        }
      }
    }
  }
  for (const fs::path& part : parts) fs::remove_all(part);
}

}  // namespace sprout::batch
