#include "services/batch/merge.h"

#include <fmt/core.h>

#include <array>
#include <iostream>
#include <map>
#include <memory>

#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/core/interrupt.h"
#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "services/batch/result_folder.h"
#include "services/batch/shard_run.h"
#include "services/batch/stage_run.h"
#include "services/batch/tables.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

// The answers of one stage to a whole log: those of its shards, one behind the other. What the
// stage says of itself at the begin of each is taken from the first.
class AnswerStream {
 public:
  explicit AnswerStream(std::vector<std::string> logs) : logs_(std::move(logs)) { Next(); }

  bool there() const { return there_; }
  const LogEvent& event() const { return event_; }

  void Next() {
    do {
      there_ = reader_ && reader_->Next(event_);
      while (!there_ && at_ < logs_.size()) {
        reader_ = std::make_unique<LogReader>(logs_[at_++]);
        there_ = reader_->Next(event_);
      }
    } while (there_ && at_ > 1 && event_.channel.ends_with(kProcessChannel));
  }

 private:
  std::vector<std::string> logs_;
  size_t at_ = 0;
  std::unique_ptr<LogReader> reader_;
  LogEvent event_;
  bool there_ = false;
};

// By time; each stream keeps its order, of equal times the stage named first comes first.
void MergeStreams(std::vector<AnswerStream>& streams, LogWriter& writer) {
  for (;;) {
    Interrupt::Check();
    AnswerStream* next = nullptr;
    for (AnswerStream& stream : streams) {
      if (stream.there() && (next == nullptr || stream.event().utime < next->event().utime)) {
        next = &stream;
      }
    }
    if (next == nullptr) return;
    writer.Write(next->event().utime, next->event().channel, next->event().data);
    next->Next();
  }
}

// What a merged log is made from.
std::string SourceOf(const Manifest& manifest, const std::vector<size_t>& shards,
                     const Variant& variant) {
  std::string keys;
  for (const size_t number : shards) {
    keys += ResultKey(manifest.head, variant, manifest.shards[number]);
  }
  return Digest(keys);
}

// A merged log says beside it what it is made from, written behind it.
bool MergeOne(const BatchFolder& folder, const Manifest& manifest, size_t log,
              const std::vector<size_t>& shards, const Variant& variant) {
  const fs::path path = folder.merged(manifest.logs[log], variant.name);
  const std::string source = SourceOf(manifest, shards, variant);
  if (IsMadeFrom(path, source)) return false;
  std::vector<AnswerStream> streams;
  for (const std::string& stage : manifest.head.keep) {
    std::vector<std::string> logs;
    for (const size_t number : shards) {
      const std::string key = ResultKey(manifest.head, variant, manifest.shards[number]);
      logs.push_back(folder.result(key) / (stage + ".lcm"));
    }
    streams.emplace_back(std::move(logs));
  }
  UnmarkMadeFrom(path);
  LogWriter writer(path);
  MergeStreams(streams, writer);
  writer.Close();
  MarkMadeFrom(path, source);
  return true;
}

using Cells = std::vector<std::optional<double>>;

// Mean wall time a frame of each stage over a shard, ms.
Cells TimesOf(const fs::path& run_json, const StageNames& stages) {
  StageRuns runs = ReadStageRuns(run_json, stages);
  Cells times;
  for (const std::string& stage : stages) {
    const StageRun& run = runs[stage];
    const auto frames = static_cast<double>(run.frames_out);
    times.push_back(frames > 0 ? std::optional(1000 * run.seconds / frames) : std::nullopt);
  }
  return times;
}

std::pair<double, double> FrameKey(const Cells& row) { return {*row[1], *row[0]}; }

// The rows of a shard: variants' measures and times beside each other, then what differs.
class ShardRows {
 public:
  ShardRows(const BatchFolder& folder, const Manifest& manifest, const Shard& shard) {
    const BatchHead& head = manifest.head;
    for (size_t v = 0; v < head.variants.size(); ++v) {
      const fs::path result = folder.result(ResultKey(head, head.variants[v], shard));
      const Table table = ReadTable(result / kMeasures, MeasureColumns());
      const Cells times = TimesOf(result / kRuns, head.stages);
      for (const Cells& row : table.rows) {
        Cells cells(row.begin() + 2, row.end());
        cells.insert(cells.end(), times.begin(), times.end());
        Put(row, v, std::move(cells));
      }
    }
    if (!Compares(head)) return;
    const BatchLog& log = manifest.logs[static_cast<size_t>(shard.log)];
    const Table table = ReadTable(folder.comparison(ComparisonKey(head, log, shard)) / kChanges,
                                  ComparisonColumns());
    for (const Cells& row : table.rows) Put(row, 2, Cells(row.begin() + 2, row.end()));
  }

  std::string Text(const std::string& start, const std::vector<size_t>& widths) const {
    std::string text;
    for (const auto& key : order_) {
      const std::array<Cells, 3>& parts = rows_.at(key);
      Cells row = {key.second, key.first};
      for (size_t i = 0; i < widths.size(); ++i) {
        Cells cells = parts[i];
        cells.resize(widths[i]);
        row.insert(row.end(), cells.begin(), cells.end());
      }
      text += start + TableRow(row);
    }
    return text;
  }

 private:
  void Put(const Cells& row, size_t place, Cells cells) {
    const auto key = FrameKey(row);
    if (!rows_.contains(key)) order_.push_back(key);
    rows_[key][place] = std::move(cells);
  }

  std::map<std::pair<double, double>, std::array<Cells, 3>> rows_;
  std::vector<std::pair<double, double>> order_;
};

}  // namespace

BatchState StateOf(const BatchFolder& folder, const Manifest& manifest) {
  BatchState state;
  for (const Shard& shard : manifest.shards) {
    const BatchLog& log = manifest.logs[static_cast<size_t>(shard.log)];
    state.done.push_back(IsDone(folder, manifest.head, log, shard, ResultCheck::kQuick));
    if (!state.done.back()) ++state.missing;
  }
  return state;
}

BatchState CheckedStateOf(const BatchFolder& folder, const Manifest& manifest) {
  BatchState state = StateOf(folder, manifest);
  for (size_t log = 0; log < manifest.logs.size(); ++log) {
    const std::vector<size_t> shards = manifest.ShardsOf(log);
    for (const Variant& variant : manifest.head.variants) {
      const fs::path merged = folder.merged(manifest.logs[log], variant.name);
      if (IsMadeFrom(merged, SourceOf(manifest, shards, variant))) continue;
      for (const size_t number : shards) {
        if (!state.done[number]) continue;
        Interrupt::Check();
        const fs::path result =
            folder.result(ResultKey(manifest.head, variant, manifest.shards[number]));
        if (IsWhole(result, ResultCheck::kAll)) continue;
        std::cerr << fmt::format("sprout-batch: {}: damaged; shard {} is computed again\n",
                                 result.string(), number);
        MarkDamaged(result);
        state.done[number] = false;
        ++state.missing;
      }
    }
  }
  return state;
}

int64_t MergeLogs(const BatchFolder& folder, const Manifest& manifest, const BatchState& state) {
  fs::create_directories(folder.root() / "logs");
  int64_t written = 0;
  for (size_t log = 0; log < manifest.logs.size(); ++log) {
    const std::vector<size_t> shards = manifest.ShardsOf(log);
    bool whole = true;
    for (const size_t number : shards) whole = whole && state.done[number];
    if (!whole || shards.empty()) continue;
    for (const Variant& variant : manifest.head.variants) {
      if (MergeOne(folder, manifest, log, shards, variant)) ++written;
    }
  }
  return written;
}

void WriteFrameTable(const BatchFolder& folder, const Manifest& manifest, const BatchState& state) {
  const BatchHead& head = manifest.head;
  Table measures{.columns = {}, .rows = {}};
  for (const std::string& column : MeasureColumns()) measures.columns.push_back(column);
  for (const std::string& stage : head.stages) measures.columns.push_back(stage + "_ms");
  std::string first = "log,shard,seq,utime";
  std::vector<size_t> widths;
  for (const Variant& variant : head.variants) {
    for (const std::string& column : measures.columns) first += "," + variant.name + "_" + column;
    widths.push_back(measures.columns.size());
  }
  widths.resize(2, 0);
  widths.push_back(Compares(head) ? ComparisonColumns().size() : 0);
  if (Compares(head)) {
    for (const std::string& column : ComparisonColumns()) first += "," + column;
  }
  OutputFile file(folder.table());
  file.Write(first + "\n");
  for (size_t i = 0; i < manifest.shards.size(); ++i) {
    if (!state.done[i]) continue;
    Interrupt::Check();
    const Shard& shard = manifest.shards[i];
    const std::string start =
        fmt::format("{},{},", manifest.logs[static_cast<size_t>(shard.log)].name, i);
    file.Write(ShardRows(folder, manifest, shard).Text(start, widths));
  }
  CommitFile(folder.table(), file);
}

}  // namespace sprout::batch
