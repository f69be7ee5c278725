#include "services/tools/batch/answers.h"

#include <algorithm>
#include <deque>
#include <limits>

#include "common/config/stage_parts.h"
#include "common/frames/whole_frames.h"
#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "services/tools/batch/measures.h"

namespace sprout::batch {

void MergeLogs(const std::vector<std::string>& logs, const std::filesystem::path& out) {
  struct Stream {
    explicit Stream(const std::string& log) : reader(log) { Next(); }
    void Next() {
      if (!reader.Next(event)) event.utime = std::numeric_limits<int64_t>::max();
    }

    LogReader reader;
    LogEvent event;
  };
  std::deque<Stream> streams(logs.begin(), logs.end());
  LogWriter writer(out);
  for (;;) {
    Stream& next = *std::ranges::min_element(
        streams, {}, [](const Stream& stream) { return stream.event.utime; });
    if (next.event.utime == std::numeric_limits<int64_t>::max()) break;
    writer.Write(next.event.utime, next.event.channel, next.event.data);
    next.Next();
  }
  writer.Close();
}

Table MeasureAnswers(const Manifest& manifest, const SproutConfig& config,
                     const std::vector<std::string>& logs) {
  const Part answer = AnswerOf(*manifest.stage().rbegin());
  // What the stages took from the log, which may have recorded answers, too. The place of the left
  // image is wanted for pictures.
  PartSet input = {Part::kLeft};
  PartSet answered;
  for (const std::string& stage : manifest.stage()) {
    for (const Part part : kAllParts) {
      if (!answered.Has(part) && InputsOf(stage, config).Has(part)) input.Add(part);
      if (OutputsOf(stage, config).Has(part)) answered.Add(part);
    }
  }
  FrameLookup frames(manifest.channel_prefix());
  frames.Add(logs[0], input);
  for (int i = 0; i < manifest.stage_size(); ++i) {
    const PartSet outputs = OutputsOf(manifest.stage(i), config);
    const bool is_needed = std::ranges::any_of(kAllParts, [&](Part part) {
      return outputs.Has(part) && (part == answer || MeasuredParts().Has(part));
    });
    if (is_needed) frames.Add(logs[static_cast<size_t>(i) + 1], outputs);
  }
  return MeasureFrames(frames, answer, manifest.measured());
}

bool CountWithoutFrames(const Manifest& manifest, const BatchLog& log, const SproutConfig& config,
                        StageRun& run) {
  int64_t refused = 0;
  WholeFrames frames(log.path(), manifest.channel_prefix(), InputsOf(manifest.stage(0), config),
                     [&](const LogEvent&, const std::string&) { ++refused; });
  if (frames.Next()) return false;
  int64_t damaged = 0;
  for (const LogDamage& damage : frames.log().damage()) damaged += damage.bytes;
  run.set_incomplete(frames.joiner().incomplete());
  run.set_left_out(frames.joiner().sequence_gaps());
  run.set_bad_messages(refused);
  run.set_damaged_bytes(damaged);
  return true;
}

}  // namespace sprout::batch
