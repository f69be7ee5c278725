// Times of every stage and of the whole chain beside OpenCV's semi-global matching on the same
// images, for scripts/bench. Each benchmark is called PART/PRESET/MEGAPIXELS/THREADS and gives the
// time of one frame, the mean over the scenes. default-blind50 and default-none are preset default
// with half of the ToF returns, and without any.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "services/grow/gap_filler.h"
#include "services/grow/grower.h"
#include "services/prior/prior_estimator.h"
#include "services/refine/refiner.h"
#include "tests/bench/bench_frame.h"

namespace sprout {
namespace {

constexpr const char* kScenes[] = {"Lampshade1", "Monopoly", "Plastic"};

struct Size {
  const char* megapixels;
  cv::Size pixels;
};
constexpr int kSizes = 4;
const Size kAllSizes[kSizes] = {
    {"0.36", {694, 519}}, {"1.4", {1300, 1077}}, {"2.0", {1624, 1224}}, {"8.0", {3248, 2463}}};

// The frames of one size; only the last size asked for is kept, the large ones take memory.
const std::vector<BenchFrame>& FramesOf(cv::Size size) {
  static cv::Size loaded;
  static std::vector<BenchFrame> frames;
  if (loaded == size) return frames;
  frames.clear();
  const char* data = std::getenv("SPROUT_DATA");
  if (data == nullptr) throw ConfigError("SPROUT_DATA: not set; allowed: the folder of the scenes");
  for (const char* scene : kScenes) {
    frames.push_back(LoadBenchFrame(std::string(data) + "/middlebury/full/" + scene, size));
  }
  loaded = size;
  return frames;
}

// The chain as the services run it, one object a stage for all frames.
class Chain {
 public:
  explicit Chain(const SproutConfig& config)
      : config_(config),
        refiner_(config.refine()),
        prior_(config.prior()),
        grower_(config.grow()) {}

  // What growth and what the prior start from; valid until the next call.
  struct Seeds {
    const std::vector<Seed>& grow;
    const std::vector<Seed>& prior;
  };
  Seeds Refine(const BenchFrame& bench, const TofProjector& projector) {
    refined_ =
        refiner_.Compute(bench.left, bench.right, bench.frame.tof, projector, std::move(refined_))
            .value();
    if (!prior_.uses_left_seeds()) return {refined_.seeds, refined_.seeds};
    Join(refined_.seeds, refiner_.left_seeds().seeds, prior_seeds_);
    return {refined_.seeds, prior_seeds_};
  }
  PriorMap Prior(const BenchFrame& bench, const std::vector<Seed>& seeds) {
    const CapturedFrame& frame = bench.frame;
    return prior_.Compute(frame.left, frame.right, seeds, frame.left.size()).value();
  }
  DisparityImage Grow(const BenchFrame& bench, const std::vector<Seed>& seeds,
                      const PriorMap& prior) {
    return grower_.Compute(bench.left, bench.right, seeds, prior).value();
  }
  DisparityImage Fill(const DisparityImage& grown, const PriorMap& prior) {
    return filler_.Fill(grown, config_.grow().fill(), prior.disparity);
  }

 private:
  SproutConfig config_;
  Refiner refiner_;
  SeedSet refined_;
  std::vector<Seed> prior_seeds_;
  PriorEstimator prior_;
  Grower grower_;
  GapFiller filler_;
};

// What goes into each stage.
struct Inputs {
  const BenchFrame& bench;
  TofProjector projector;
  std::vector<Seed> seeds;
  std::vector<Seed> prior_seeds;
  PriorMap prior;
  DisparityImage grown;
};

enum class Part { kRefine, kPrior, kGrow, kFill, kChain };
constexpr std::pair<Part, const char*> kParts[] = {{Part::kRefine, "refine"},
                                                   {Part::kPrior, "prior"},
                                                   {Part::kGrow, "grow"},
                                                   {Part::kFill, "fill"},
                                                   {Part::kChain, "chain"}};

void RunPart(Part part, Chain& chain, const Inputs& in) {
  switch (part) {
    case Part::kRefine:
      benchmark::DoNotOptimize(chain.Refine(in.bench, in.projector));
      return;
    case Part::kPrior:
      benchmark::DoNotOptimize(chain.Prior(in.bench, in.prior_seeds));
      return;
    case Part::kGrow:
      benchmark::DoNotOptimize(chain.Grow(in.bench, in.seeds, in.prior));
      return;
    case Part::kFill:
      benchmark::DoNotOptimize(chain.Fill(in.grown, in.prior));
      return;
    case Part::kChain: {
      const Chain::Seeds seeds = chain.Refine(in.bench, in.projector);
      const PriorMap prior = chain.Prior(in.bench, seeds.prior);
      benchmark::DoNotOptimize(chain.Fill(chain.Grow(in.bench, seeds.grow, prior), prior));
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
void MeasurePart(benchmark::State& state, Part part, const std::string& preset, double lost,
                 cv::Size size, int threads) {
  cv::setNumThreads(threads);
  Chain chain(LoadConfig({preset}));
  std::vector<BenchFrame> frames = FramesOf(size);
  std::vector<Inputs> inputs;
  for (BenchFrame& bench : frames) {
    bench.frame.tof.depth_m = bench.frame.tof.depth_m.clone();
    LoseDarkReturns(lost, bench);
    Inputs& in = inputs.emplace_back(Inputs{bench, TofProjector(bench.rig), {}, {}, {}, {}});
    const Chain::Seeds seeds = chain.Refine(bench, in.projector);
    in.seeds = seeds.grow;
    in.prior_seeds = seeds.prior;
    in.prior = chain.Prior(bench, in.prior_seeds);
    in.grown = chain.Grow(bench, in.seeds, in.prior);
  }
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
      for (const std::string preset : {"fast", "default"}) {
        for (const auto& [part, name] : kParts) {
          Register(std::string(name) + "/" + preset + where, [=](benchmark::State& state) {
            MeasurePart(state, part, preset, /*lost=*/0, size, threads);
          });
        }
      }
      for (const auto& [name, lost] : {std::pair{"blind50", 0.5}, {"none", 1.0}}) {
        Register(std::string("chain/default-") + name + where, [=](benchmark::State& state) {
          MeasurePart(state, Part::kChain, "default", lost, size, threads);
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
    benchmark::RunSpecifiedBenchmarks();
  } catch (const std::exception& e) {
    std::cerr << "sprout_bench: " << e.what() << "\n";
    return 1;
  }
  return 0;
}
