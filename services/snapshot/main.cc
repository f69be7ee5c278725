#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/app/program.h"
#include "common/app/service.h"
#include "common/app/status_reporter.h"
#include "common/core/digest.h"
#include "services/snapshot/graph_listener.h"
#include "services/snapshot/snapshot.h"

namespace sprout::snapshot {
namespace {

struct Options {
  std::filesystem::path folder;
  int64_t frames = 1;
  double timeout_s = 60;
  std::optional<std::string> source;  // of ground truth
};

StageMonitor::Clock::time_point After(double seconds) {
  return StageMonitor::Clock::now() + std::chrono::duration_cast<StageMonitor::Clock::duration>(
                                          std::chrono::duration<double>(seconds));
}

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw ConfigError("--out " + folder.string() + ": " + error.message());
}

datasets::GroundTruth TruthOf(datasets::Dataset* source, int64_t seq) {
  if (source == nullptr) return {};
  const std::optional<int64_t> count = source->frame_count();
  return source->Get(count ? seq % *count : seq).truth;
}

int Listen(const ServiceContext& context, const Options& options, datasets::Dataset* source) {
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  GraphListener listener(context, monitor);
  const StatusReporter reporter(context, monitor);
  const int64_t arrived =
      listener.WaitForFrames(options.frames, After(options.timeout_s), context.stop);
  if (arrived < options.frames) {
    const std::vector<std::string> silent = listener.SilentChannels();
    spdlog::error("{} of {} frames arrived with all their parts in {} s{}", arrived, options.frames,
                  options.timeout_s,
                  silent.empty() ? "" : fmt::format("; nothing on {}", fmt::join(silent, ", ")));
    return context.stop.stop_requested() ? 0 : 1;
  }
  const Frame frame = *listener.TakeNewest(After(1), context.stop);
  for (const std::string& missing : MissingParts(frame)) spdlog::warn(missing);
  // Statuses come once a second, so the last frame may take two to show in all of them.
  const auto statuses = listener.WaitForStatuses(frame.id.seq, After(3), context.stop);
  const datasets::GroundTruth truth = TruthOf(source, frame.id.seq);
  const Result<void> written = WriteFrameFiles(frame, truth, options.folder);
  const Result<std::string> report =
      written ? ReportText(frame, statuses, truth) : tl::unexpected(written.error());
  if (!report) {
    spdlog::error(report.error().text);
    return 1;
  }
  std::cout << *report;
  return 0;
}

int Main(int argc, char** argv) {
  Service service(
      "snapshot",
      "Waits for whole frames of the running graph and writes the last one as pictures,\n"
      "point cloud and mesh, with a table of the run.");
  Options options;
  service.flags().add_option("--out", options.folder, "Folder to write to")->required();
  service.flags()
      .add_option("--frames", options.frames, "Frames to wait for; the last one is written")
      ->check(CLI::Range(int64_t{1}, INT64_MAX))
      ->capture_default_str();
  service.flags()
      .add_option("--timeout", options.timeout_s, "How long to wait for them, s")
      ->check(NumberIn(0.1, 86400.0))
      ->capture_default_str();
  service.flags()
      .add_option("--source", options.source,
                  "Capture's source, for its ground truth; without it nothing is scored")
      ->type_name("SOURCE");
  return service.Run(
      argc, argv,
      [&](const ServiceContext& context) {
        MakeFolder(options.folder);
        const std::unique_ptr<datasets::Dataset> source =
            options.source ? datasets::OpenDataset(context.config.capture()) : nullptr;
        return Listen(context, options, source.get());
      },
      [&](SproutConfig& config) {
        if (options.source) config.mutable_capture()->set_source(*options.source);
      });
}

}  // namespace
}  // namespace sprout::snapshot

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
