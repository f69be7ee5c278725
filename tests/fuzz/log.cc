#include <algorithm>

#include "common/logfile/log_reader.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/fuzz/targets.h"

namespace sprout::fuzz {

void ReadWholeLog(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  LogContent content;
  try {
    content = ReadLog(file.path());
  } catch (const LogError&) {
    return;
  }
  // Every byte is either read or reported.
  int64_t end = 0;
  int64_t covered = 0;
  for (const Event& event : content.events) {
    Check(event.offset >= end, "events overlap or go back");
    end = event.end();
    covered += end - event.offset;
  }
  for (const LogDamage& damage : content.damage) {
    Check(damage.bytes > 0, "damage of no byte");
    covered += damage.bytes;
  }
  Check(end <= static_cast<int64_t>(bytes.size()), "an event ends behind the file");
  Check(covered == static_cast<int64_t>(bytes.size()), "bytes are neither read nor reported");
}

std::vector<Bytes> LogSeeds() {
  std::vector<Event> events = SampleEvents(12);
  const Bytes whole = MakeLog(events);
  const Bytes torn(whole.begin(), whole.end() - 5);
  Bytes hole = whole;
  const auto middle = static_cast<std::ptrdiff_t>(whole.size() / 2);
  std::fill(hole.begin() + middle, hole.begin() + middle + 60, uint8_t{0});
  const Bytes headless(whole.begin() + 40, whole.end());
  // The sample log's first events, the last one torn.
  Bytes sample = ReadBytes(std::string(SPROUT_SOURCE_DIR) + "/logs/sample.lcm");
  sample.resize(16384);
  return {whole, torn, hole, headless, sample};
}

}  // namespace sprout::fuzz
