// One frame through a part of the chain, for count_instructions: what is counted is what
// CountedRun() does. Always the same scene, one thread and one instruction set, and the second
// frame of its size, so that memory is there.
#include <hwy/targets.h>

#include <functional>
#include <iostream>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "common/config/config.h"
#include "common/scenes/dataset.h"
#include "services/grow/grow_adapter.h"
#include "services/prior/prior_adapter.h"
#include "services/refine/refine_adapter.h"

namespace sprout {

// By this name valgrind knows it.
extern "C" __attribute__((noinline)) void CountedRun(const std::function<void()>& run) { run(); }

namespace {

Frame SyntheticFrame(const CaptureConfig& config) {
  const auto dataset = scenes::OpenDataset(config);
  const scenes::DatasetFrame given = dataset->Get(0);
  Frame frame;
  frame.left = given.left;
  frame.right = given.right;
  frame.tof = given.tof;
  frame.rig = dataset->rig();
  return frame;
}

int Main(int argc, char** argv) {
  const std::string usage = "usage: sprout_instructions PRESET prior|grow|finish\n";
  if (argc != 3) {
    std::cerr << usage;
    return 2;
  }
  SproutConfig config = LoadConfig({argv[1]});
  config.mutable_capture()->set_source("synthetic:320x240");
  config.mutable_refine()->set_stereo_seeds(false);  // not counted, and slow under valgrind
  hwy::SetSupportedTargetsForTest(HWY_SSE4);         // every x86-64 that valgrind shows has it
  cv::setNumThreads(1);
  Frame frame = SyntheticFrame(config.capture());
  refine::RefineAdapter refine(config.refine());
  prior::PriorAdapter prior(config.prior());
  grow::GrowAdapter grow(config.grow());
  AddAnswer(refine, frame);
  AddAnswer(prior, frame);
  const grow::GrowAdapter::Growth growth = grow.Grow(frame);
  const std::map<std::string, std::function<void()>> parts = {
      {"prior", [&] { prior.Process(frame); }},
      {"grow", [&] { grow.Grow(frame); }},
      {"finish", [&] { grow.Finish(frame, growth); }}};
  const auto part = parts.find(argv[2]);
  if (part == parts.end()) {
    std::cerr << usage;
    return 2;
  }
  part->second();
  CountedRun(part->second);
  return 0;
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
