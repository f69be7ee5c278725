// The C++ side of measure.py: prints milliseconds a frame.
//   cpp_times compute SOURCE PRESET FRAMES      sprout::Pipeline
//   cpp_times read LOG                          sprout::LogFrames, all parts
#include <fmt/core.h>

#include <chrono>
#include <string>

#include "common/config/config.h"
#include "common/frames/log_frames.h"
#include "common/scenes/dataset.h"
#include "services/pipeline/pipeline.h"

namespace sprout {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point begun) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
}

void Compute(const std::string& source, const std::string& preset, int frames) {
  SproutConfig config = LoadConfig({preset});
  config.mutable_capture()->set_source(source);
  const auto dataset = scenes::OpenDataset(config.capture());
  const scenes::DatasetFrame frame = dataset->Get(0);
  cv::setNumThreads(1);
  Pipeline pipeline(config);
  std::vector<double> times;
  for (int i = 0; i < frames; ++i) {
    const auto begun = Clock::now();
    if (!pipeline.Compute(frame.left, frame.right, frame.tof, dataset->rig())) throw 0;
    times.push_back(MillisecondsSince(begun));
  }
  for (const double time : times) fmt::print("{:.3f} ", time);
  fmt::print("\n");
}

void Read(const std::string& log) {
  const auto begun = Clock::now();
  LogFrames frames(log, {});
  int count = 0;
  while (frames.Next()) ++count;
  fmt::print("{:.4f}\n", MillisecondsSince(begun) / count);
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "compute" && argc == 5) {
    sprout::Compute(argv[2], argv[3], std::stoi(argv[4]));
  } else if (what == "read" && argc == 3) {
    sprout::Read(argv[2]);
  } else {
    return 2;
  }
}
