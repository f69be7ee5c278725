#include "services/tools/log/read_progress.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "services/tools/log/print_line.h"

namespace sprout::log {
namespace {

constexpr std::chrono::milliseconds kPeriod{200};

}  // namespace

ReadProgress::ReadProgress(std::string what, int64_t bytes)
    : what_(std::move(what)), bytes_(bytes), next_(std::chrono::steady_clock::now() + kPeriod) {}

void ReadProgress::Update(int64_t position) {
  Interrupt::Check();
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kPeriod;
  line_.Show(fmt::format("{}: {} % of {:.1f} GB", what_,
                         100 * position / std::max<int64_t>(bytes_, 1),
                         static_cast<double>(bytes_) / 1e9));
}

std::string DamageText(const LogDamage& damage) {
  std::string text = fmt::format("bytes {}-{} ({}): ", damage.offset,
                                 damage.offset + damage.bytes - 1, damage.bytes);
  if (damage.tail) return text + "torn tail, the file ends inside an event";
  if (!damage.events) return text + "an unknown number of events lost";
  return text + fmt::format("{} event{} lost", *damage.events, *damage.events == 1 ? "" : "s");
}

std::string DamageWarning(const std::filesystem::path& path, const std::vector<LogDamage>& damage) {
  if (damage.empty()) return {};
  int64_t bytes = 0;
  for (const LogDamage& stretch : damage) bytes += stretch.bytes;
  return fmt::format("{} is damaged in {} place{}, {} bytes were skipped; see sprout-log info",
                     path.string(), damage.size(), damage.size() == 1 ? "" : "s", bytes);
}

void WarnOfDamage(const std::filesystem::path& path, const std::vector<LogDamage>& damage) {
  if (const std::string text = DamageWarning(path, damage); !text.empty()) PrintWarning(text);
}

}  // namespace sprout::log
