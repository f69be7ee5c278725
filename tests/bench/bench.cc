// Times of every stage and of the whole chain beside OpenCV's semi-global matching on the same
// images, for scripts/bench. Each benchmark is called PART/PRESET/MEGAPIXELS/THREADS and gives the
// time of one frame, the mean over the scenes. default-blind50 and default-none are preset default
// with half of the ToF returns, and without any. rectify/colour has a coloured left image.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <functional>
#include <iostream>
#include <opencv2/calib3d.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/rig/rectifier.h"
#include "services/grow/grow_adapter.h"
#include "services/pipeline/chain.h"
#include "services/prior/prior_adapter.h"
#include "services/refine/refine_adapter.h"
#include "tests/bench/bench_frame.h"

namespace sprout {
namespace {

constexpr const char* kScenes[] = {"Lampshade1", "Monopoly", "Plastic"};

struct Size {
  const char* megapixels;
  cv::Size pixels;
};
constexpr int kSizes = 5;
const Size kAllSizes[kSizes] = {{"0.36", {694, 519}},
                                {"0.47", {1242, 375}},  // KITTI's
                                {"1.4", {1300, 1077}},
                                {"2.0", {1624, 1224}},
                                {"8.0", {3248, 2463}}};

// The frames of one size; only the last size asked for is kept, the large ones take memory.
const std::vector<BenchFrame>& FramesOf(cv::Size size) {
  static cv::Size loaded;
  static std::vector<BenchFrame> frames;
  if (loaded == size) return frames;
  frames.clear();
  const char* data = std::getenv("SPROUT_DATA");
  if (data == nullptr) throw ConfigError("SPROUT_DATA: not set; allowed: the folder of the scenes");
  for (const char* scene : kScenes) {
    if (const char* only = std::getenv("ONLY"); only && std::string(only) != scene) continue;
    frames.push_back(LoadBenchFrame(std::string(data) + "/middlebury/full/" + scene, size));
  }
  loaded = size;
  return frames;
}

// The chain as sprout-pipeline runs it, with everything that the preset publishes; and the adapters
// of the services, one object a stage for all frames.
struct Stages {
  explicit Stages(const SproutConfig& config)
      : whole(config),
        refine(config.refine()),
        prior(config.prior()),
        grow(config.grow()),
        fill(WithoutConfidence(config.grow())) {}

  static GrowConfig WithoutConfidence(GrowConfig config) {
    config.set_publish_confidence(false);
    config.set_min_confidence(0);
    return config;
  }

  Chain whole;
  refine::RefineAdapter refine;
  prior::PriorAdapter prior;
  grow::GrowAdapter grow;
  grow::GrowAdapter fill;  // finishes without the confidence
};

// What goes into each stage: a frame with what all of them made of it.
struct Inputs {
  Frame frame;
  grow::GrowAdapter::Growth growth;
};

enum class BenchPart { kRefine, kPrior, kGrow, kFill, kFinish, kChain };
constexpr std::pair<BenchPart, const char*> kBenchParts[] = {
    {BenchPart::kRefine, "refine"}, {BenchPart::kPrior, "prior"},   {BenchPart::kGrow, "grow"},
    {BenchPart::kFill, "fill"},     {BenchPart::kFinish, "finish"}, {BenchPart::kChain, "chain"}};

void RunPart(BenchPart part, Stages& chain, Inputs& in) {
  switch (part) {
    case BenchPart::kRefine:
      benchmark::DoNotOptimize(chain.refine.Process(in.frame));
      return;
    case BenchPart::kPrior:
      benchmark::DoNotOptimize(chain.prior.Process(in.frame));
      return;
    case BenchPart::kGrow:
      benchmark::DoNotOptimize(chain.grow.Grow(in.frame));
      return;
    case BenchPart::kFill:
      benchmark::DoNotOptimize(chain.fill.Finish(in.frame, in.growth));
      return;
    case BenchPart::kFinish:
      benchmark::DoNotOptimize(chain.grow.Finish(in.frame, in.growth));
      return;
    case BenchPart::kChain: {
      Frame frame;
      frame.id = in.frame.id;
      frame.left = in.frame.left;
      frame.right = in.frame.right;
      frame.tof = in.frame.tof;
      frame.rig = in.frame.rig;
      ChainObserver nobody;
      chain.whole.Run(frame, nobody);
    }
  }
}

// One iteration runs all scenes; times are divided by their number afterwards.
template <typename Run>
void RunOnAllScenes(benchmark::State& state, cv::Size size, size_t scenes, const Run& run) {
  for (auto _ : state) {
    for (size_t scene = 0; scene < scenes; ++scene) run(scene);
  }
  state.counters["scenes"] = static_cast<double>(scenes);
  state.counters["pixels"] = size.area();
}

// @param lost  share of the ToF returns that are taken away.
void MeasurePart(benchmark::State& state, BenchPart part, const std::string& preset, double lost,
                 cv::Size size, int threads) {
  cv::setNumThreads(threads);
  Stages chain(LoadConfig({preset}));
  std::vector<BenchFrame> frames = FramesOf(size);
  std::vector<Inputs> inputs;
  for (BenchFrame& bench : frames) {
    bench.frame.tof.depth_m = bench.frame.tof.depth_m.clone();
    LoseDarkReturns(lost, bench);
    Frame frame;
    frame.id.seq = 1;  // not one of the few that are looked at for what is wrong with the input
    frame.left = bench.frame.left;
    frame.right = bench.frame.right;
    frame.tof = bench.frame.tof;
    frame.rig = bench.rig;
    AddAnswer(chain.refine, frame);
    AddAnswer(chain.prior, frame);
    grow::GrowAdapter::Growth growth = chain.grow.Grow(frame);
    inputs.push_back({std::move(frame), std::move(growth)});
  }
  // A stage looks at its first frame whatever its number.
  RunPart(part, chain, inputs[0]);
  RunOnAllScenes(state, size, inputs.size(),
                 [&](size_t scene) { RunPart(part, chain, inputs[scene]); });
}

// As OpenCV's documentation advises; 256 disparities, what a camera rig of this kind needs.
void MeasureSgbm(benchmark::State& state, int mode, cv::Size size, int threads) {
  cv::setNumThreads(threads);
  constexpr int kBlock = 5;
  const auto sgbm = cv::StereoSGBM::create(0, 256, kBlock, 8 * kBlock * kBlock,
                                           32 * kBlock * kBlock, 1, 63, 10, 100, 2, mode);
  const std::vector<BenchFrame>& frames = FramesOf(size);
  cv::Mat map;
  RunOnAllScenes(state, size, frames.size(), [&](size_t scene) {
    sgbm->compute(frames[scene].left, frames[scene].right, map);
  });
}

// A pair of cameras of that size as they come: lenses that distort, a right camera that is turned.
RawRig RigOf(cv::Size size) {
  RawRig rig;
  rig.left = {.width = size.width,
              .height = size.height,
              .fx = 0.9 * size.width,
              .fy = 0.9 * size.width,
              .cx = size.width / 2.0,
              .cy = size.height / 2.0,
              .distortion = {-0.12, 0.03, 0.0005, -0.0008, 0.001}};
  rig.right = rig.left;
  rig.left_from_right.rotation = Eigen::Quaterniond(1, 0.012, -0.02, 0.015).normalized();
  rig.left_from_right.translation_m = {0.1, 0.004, -0.003};
  return rig;
}

void MeasureRectification(benchmark::State& state, bool colour, cv::Size size, int threads) {
  cv::setNumThreads(threads);
  const Rectifier rectifier(RigOf(size));
  const std::vector<BenchFrame>& frames = FramesOf(size);
  RunOnAllScenes(state, size, frames.size(), [&](size_t scene) {
    const BenchFrame& bench = frames[scene];
    benchmark::DoNotOptimize(rectifier.RectifyLeft(colour ? bench.frame.left : bench.left));
    benchmark::DoNotOptimize(rectifier.RectifyRight(bench.right));
  });
}

void Register(const std::string& name, const std::function<void(benchmark::State&)>& measure) {
  benchmark::RegisterBenchmark(name.c_str(), [measure](benchmark::State& state) { measure(state); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->MeasureProcessCPUTime();
}

// Fewer threads first: OpenCV's pool may refuse to shrink.
void RegisterAll() {
  for (const auto& [megapixels, size] : kAllSizes) {
    for (const int threads : {1, 2}) {
      const std::string where = std::string("/") + megapixels + "/" + std::to_string(threads);
      for (const auto& [mode, name] : {std::pair{cv::StereoSGBM::MODE_SGBM_3WAY, "sgbm-3way"},
                                       {cv::StereoSGBM::MODE_SGBM, "sgbm-5way"}}) {
        Register(std::string(name) + "/opencv" + where,
                 [=](benchmark::State& state) { MeasureSgbm(state, mode, size, threads); });
      }
      for (const auto& [colour, name] : {std::pair{false, "grey"}, {true, "colour"}}) {
        Register(std::string("rectify/") + name + where, [=](benchmark::State& state) {
          MeasureRectification(state, colour, size, threads);
        });
      }
      for (const std::string preset : {"fast", "default"}) {
        for (const auto& [part, name] : kBenchParts) {
          Register(std::string(name) + "/" + preset + where, [=](benchmark::State& state) {
            MeasurePart(state, part, preset, /*lost=*/0, size, threads);
          });
        }
      }
      for (const auto& [name, lost] : {std::pair{"blind50", 0.5}, {"none", 1.0}}) {
        Register(std::string("chain/default-") + name + where, [=](benchmark::State& state) {
          MeasurePart(state, BenchPart::kChain, "default", lost, size, threads);
        });
      }
    }
  }
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  try {
    sprout::RegisterAll();
    // The library prints an error where no benchmark has that name.
    return benchmark::RunSpecifiedBenchmarks() > 0 ? 0 : 2;
  } catch (const std::exception& e) {
    std::cerr << "sprout_bench: " << e.what() << "\n";
    return 1;
  }
}
