// Made-up results of many shards through manifest, restart, merge and report: how long each takes
// and how much memory. Exit code 1 when one takes more than a minute or all more than a gigabyte.
//
//     batch_scale [SHARDS]         10 frames a shard, 10 shards a log
#include <fmt/core.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>

#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "services/batch/report.h"
#include "services/batch/result_folder.h"
#include "services/batch/shard_run.h"
#include "services/batch/stage_run.h"
#include "services/batch/tables.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kFrames = 10;
constexpr int64_t kShardsPerLog = 10;

int64_t Time(int64_t shard, int64_t i) {
  return 1'700'000'000'000'000 + 100'000 * (shard * kFrames + i);
}

class Simulation {
 public:
  Simulation(const fs::path& root, int64_t shards) : folder_(root), shards_(shards) {}

  // An index of a log that is not there, as sprout-batch would have made it.
  void MakeIndexes() const {
    for (int64_t log = 0; log < shards_ / kShardsPerLog; ++log) {
      std::vector<IndexedEvent> events;
      for (int64_t i = 0; i < kShardsPerLog * kFrames; ++i) {
        for (const Part part : {Part::kLeft, Part::kRight, Part::kTof}) {
          IndexedEvent event;
          event.utime = Time(log * kShardsPerLog, i);
          event.offset = 1'000'000 * i;
          event.bytes = 300'000;
          event.channel = ChannelOf(part);
          event.id = {.utime = event.utime, .seq = i, .rig_id = "cafe"};
          event.hash = Hash(fmt::format("{} {} {}", log, i, static_cast<int>(part)));
          if (i == 0 && part == Part::kLeft) {
            IndexedEvent rig = event;
            rig.channel = ChannelOf(Part::kRig);
            events.push_back(std::move(rig));
          }
          events.push_back(std::move(event));
        }
      }
      IndexSummary summary;
      summary.events = std::ssize(events);
      WriteIndex(IndexPath(log), summary, events);
    }
  }

  void Plan() {
    BatchHead& head = manifest_.head;
    head.keep = {"grow"};
    head.shard_bytes = kFrames * 900'000;
    head.tables = Digest("made up");
    head.stages = {"refine", "prior", "grow"};
    for (const char* name : {"a", "b"}) {
      Variant variant{.name = name, .config_digest = Digest(name), .programs = {}};
      for (const std::string& stage : head.stages) {
        variant.programs[stage] = {"/made/up/program", Digest(stage), "v"};
      }
      head.variants.push_back(std::move(variant));
    }
    const PlanOptions options{.inputs = InputsOf(head.stages, SproutConfig()),
                              .prefix = "",
                              .shard_bytes = kFrames * 900'000};
    for (int64_t log = 0; log < shards_ / kShardsPerLog; ++log) {
      const LogIndex index = LogIndex::Read(IndexPath(log));
      LogPlan plan = PlanShards(index, options);
      for (Shard& shard : plan.shards) {
        shard.log = log;
        manifest_.shards.push_back(std::move(shard));
      }
      manifest_.logs.push_back({.path = fmt::format("/made/up/{}.lcm", log),
                                .name = fmt::format("log{:05}", log),
                                .index = IndexPath(log),
                                .summary = index.summary()});
    }
    WriteManifest(folder_.manifest(), manifest_);
  }

  void MakeResults() const {
    for (size_t i = 0; i < manifest_.shards.size(); ++i) {
      const auto shard = static_cast<int64_t>(i);
      for (const Variant& variant : manifest_.head.variants) MakeResult(shard, variant);
      const BatchLog& log = manifest_.logs[i / kShardsPerLog];
      const fs::path path =
          folder_.comparison(ComparisonKey(manifest_.head, log, manifest_.shards[i]));
      ResultFolder comparison(path);
      WriteTable(comparison / kChanges, MadeUp(shard, ComparisonColumns()));
      comparison.Commit();
    }
  }

  void Restart() const {
    const Manifest manifest = ReadManifest(folder_.manifest());
    const BatchState state = StateOf(folder_, manifest);
    if (state.missing != 0) throw std::runtime_error("shards are missing");
  }

  void Merge() const { MergeLogs(folder_, manifest_, CheckedStateOf(folder_, manifest_)); }

  void Report() const {
    const BatchState state = StateOf(folder_, manifest_);
    WriteFrameTable(folder_, manifest_, state);
    WriteReport(folder_, manifest_, state, "/made/up/sprout-batch");
  }

  size_t shards() const { return manifest_.shards.size(); }

 private:
  fs::path IndexPath(int64_t log) const {
    return folder_.root() / fmt::format("log{:05}.index", log);
  }

  static Table MadeUp(int64_t shard, const std::vector<std::string>& columns) {
    Table table{.columns = {"seq", "utime"}, .rows = {}};
    table.columns.insert(table.columns.end(), columns.begin(), columns.end());
    for (int64_t i = 0; i < kFrames; ++i) {
      auto& row = table.rows.emplace_back();
      row = {static_cast<double>(shard % kShardsPerLog * kFrames + i),
             static_cast<double>(Time(shard, i))};
      for (size_t c = 0; c < columns.size(); ++c) {
        row.emplace_back(0.5 + 0.5 * std::sin(static_cast<double>(shard * kFrames + i) * 0.1 +
                                              static_cast<double>(c)));
      }
    }
    return table;
  }

  void MakeResult(int64_t number, const Variant& variant) const {
    const Shard& shard = manifest_.shards[static_cast<size_t>(number)];
    ResultFolder result(folder_.result(ResultKey(manifest_.head, variant, shard)));
    WriteTable(result / kMeasures, MadeUp(number, MeasureColumns()));
    const StageRun run{.frames_in = kFrames, .frames_out = kFrames, .seconds = 1};
    WriteStageRuns(result / kRuns, {{"refine", run}, {"prior", run}, {"grow", run}});
    LogWriter log(result / "grow.lcm");
    const DisparityImage map(cv::Size(8, 6));
    for (int64_t i = 0; i < kFrames; ++i) {
      const FrameId id{
          .utime = Time(number, i), .seq = number % kShardsPerLog * kFrames + i, .rig_id = "cafe"};
      log.Write(Time(number, i), ChannelOf(Part::kDisparity),
                EncodePart(id, Part::kDisparity, map, DisparityEncoding::kRawInt16));
    }
    log.Close();
    result.Commit();
  }

  BatchFolder folder_;
  int64_t shards_;
  Manifest manifest_;
};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

int Main(int64_t shards) {
  std::string root = fs::temp_directory_path() / "batch_scale_XXXXXX";
  if (mkdtemp(root.data()) == nullptr) return 1;
  Simulation simulation(root, shards);
  bool in_time = true;
  // Bounds are on CPU time, which does not depend on what else the machine does.
  const auto measure = [&](const char* what, auto step) {
    const auto start = std::chrono::steady_clock::now();
    const double cpu_start = CpuSeconds();
    step();
    const double cpu = CpuSeconds() - cpu_start;
    const double wall =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::cout << fmt::format("{:<32} {:6.2f} s of CPU, {:6.2f} s\n", what, cpu, wall) << std::flush;
    return cpu;
  };
  measure("(indexes made up)", [&] { simulation.MakeIndexes(); });
  in_time &= measure("manifest", [&] { simulation.Plan(); }) < 60;
  measure("(results made up)", [&] { simulation.MakeResults(); });
  in_time &= measure("restart of a finished batch", [&] { simulation.Restart(); }) < 5;
  in_time &= measure("merged logs", [&] { simulation.Merge(); }) < 60;
  in_time &= measure("table and report", [&] { simulation.Report(); }) < 60;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::cout << fmt::format("{} shards, {} frames, {} MB\n", simulation.shards(),
                           simulation.shards() * kFrames, usage.ru_maxrss / 1024);
  fs::remove_all(root);
  return in_time && usage.ru_maxrss < 1024 * 1024 ? 0 : 1;
}

}  // namespace
}  // namespace sprout::batch

int main(int argc, char** argv) {
  return sprout::batch::Main(argc > 1 ? std::atoll(argv[1]) : 10'000);
}
