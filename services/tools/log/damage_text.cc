#include "services/tools/log/damage_text.h"

#include <fmt/core.h>

#include <iostream>

namespace sprout::log {

std::string DamageText(const LogDamage& damage) {
  std::string text = fmt::format("bytes {}-{} ({}): ", damage.offset,
                                 damage.offset + damage.bytes - 1, damage.bytes);
  if (damage.tail) return text + "torn tail, the file ends inside an event";
  if (!damage.events) return text + "an unknown number of events lost";
  return text + fmt::format("{} event{} lost", *damage.events, *damage.events == 1 ? "" : "s");
}

void WarnOfDamage(const std::filesystem::path& path, const std::vector<LogDamage>& damage) {
  if (damage.empty()) return;
  int64_t bytes = 0;
  for (const LogDamage& stretch : damage) bytes += stretch.bytes;
  std::cerr << fmt::format(
      "sprout-log: {} is damaged in {} place{}, {} bytes were skipped; see "
      "sprout-log info\n",
      path.string(), damage.size(), damage.size() == 1 ? "" : "s", bytes);
}

}  // namespace sprout::log
