#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "services/tools/evaluate/evaluate.h"
#include "services/tools/evaluate/rivals/harris_seeds.h"
#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

// Runs a function and adds the time it takes.
template <typename Function>
auto Timed(double& ms, const Function& function) {
  const auto begin = std::chrono::steady_clock::now();
  auto result = function();
  ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

Method WholeChain() {
  return {.name = "sprout",
          .summary = "the whole chain as the services run it, its final map",
          .run = [](const Scene& scene, const ChainSettings& settings) {
            return RunChain(scene, settings, FrameOf(scene));
          }};
}

Method PriorAlone() {
  return {.name = "prior",
          .summary = "D_p alone, as the preset's method makes it",
          .run = [](const Scene& scene, const ChainSettings& settings) {
            MethodOutput output;
            Frame frame = FrameOf(scene);
            RunSteps(scene, settings, ChainStep::kPrior, frame, output.ms);
            output.map_px = ToPx(frame.prior->disparity);
            return output;
          }};
}

// The seeds from which growth starts.
enum class StartFrom { kTof, kHarris };

// A frame whose seeds are Harris corners, in the time of growth.
Frame WithHarrisSeeds(const Scene& scene, StageTimes& ms) {
  Frame frame = FrameOf(scene);
  frame.seeds = SeedSet();
  frame.left_seeds = SeedSet();
  frame.seeds->seeds = Timed(ms.grow_ms, [&] {
    return MatchHarrisCorners(scene.left_grey, scene.right_grey, HarrisSettings());
  });
  ms.total_ms = ms.grow_ms;
  return frame;
}

// The chain with another similarity, other seeds and without gap filling.
Method Variant(std::string name, std::string summary, GrowConfig::Similarity similarity,
               StartFrom start) {
  return {.name = std::move(name),
          .summary = std::move(summary),
          .run = [=](const Scene& scene, ChainSettings settings) {
            GrowConfig& grow = *settings.config.mutable_grow();
            grow.set_similarity(similarity);
            grow.set_fill(GrowConfig::NONE);
            StageTimes ms;
            Frame frame = start == StartFrom::kHarris ? WithHarrisSeeds(scene, ms) : FrameOf(scene);
            MethodOutput output = RunChain(scene, settings, std::move(frame));
            output.ms.grow_ms += ms.grow_ms;
            output.ms.total_ms += ms.total_ms;
            return output;
          }};
}

Method EpcFilled() {
  return {.name = "epc-filled",
          .summary = "the same with gaps filled, as the preset says (at least one pass)",
          .run = [](const Scene& scene, ChainSettings settings) {
            GrowConfig& grow = *settings.config.mutable_grow();
            grow.set_similarity(GrowConfig::EPC);
            if (grow.fill() == GrowConfig::NONE) grow.set_fill(GrowConfig::ONE_PASS);
            return RunChain(scene, settings, FrameOf(scene));
          }};
}

std::vector<Method> PaperMethods() {
  return {
      Variant("mncc-harris", "growth by MNCC, eq. (1), from Harris corners", GrowConfig::MNCC,
              StartFrom::kHarris),
      Variant("mncc-tof", "growth by MNCC from ToF seeds", GrowConfig::MNCC, StartFrom::kTof),
      Variant("expssd-harris", "growth by EXPSSD, eq. (4), from Harris corners", GrowConfig::EXPSSD,
              StartFrom::kHarris),
      Variant("expssd-tof", "growth by EXPSSD from ToF seeds", GrowConfig::EXPSSD, StartFrom::kTof),
      Variant("epc", "growth by EPC, eq. (6): EXPSSD and the prior, from ToF seeds",
              GrowConfig::EPC, StartFrom::kTof),
      EpcFilled(),
      PriorAlone()};
}

// The paper's method with preset `paper`, whatever configuration the others run with.
Method PaperFilled() {
  return {.name = "paper-filled",
          .summary = "epc-filled of preset paper, whatever the preset of this run",
          .run = [](const Scene& scene, ChainSettings settings) {
            settings.config = LoadConfig({"paper"});
            return RunChain(scene, settings, FrameOf(scene));
          }};
}

Method FromRival(const Rival& rival) {
  return {.name = rival.name,
          .summary = rival.summary,
          .run = [rival](const Scene& scene, const ChainSettings& settings) {
            MethodOutput output;
            StageTimes& ms = output.ms;
            ChainSettings tof_only = settings;  // what stereo finds is Sprout's
            tof_only.config.mutable_refine()->set_stereo_seeds(false);
            Frame frame = FrameOf(scene);
            std::vector<Seed> seeds;
            if (rival.uses_seeds) {
              RunSteps(scene, tof_only, ChainStep::kRefine, frame, ms);
              Join(frame.seeds->seeds, frame.left_seeds->seeds, seeds);
            }
            const RivalInput input{.left = scene.frame.left,
                                   .right = scene.frame.right,
                                   .seeds = seeds,
                                   .max_disparity_px = scene.max_disparity_px,
                                   .fgs = settings.fgs};
            output.map_px = Timed(ms.total_ms, [&] { return rival.compute(input); });
            return output;
          }};
}

std::string NamesOf(const std::vector<Method>& methods) {
  std::string names = "paper, all";
  for (const Method& method : methods) names += ", " + method.name;
  return names;
}

std::vector<Method> MethodsOf(const std::string& name) {
  if (name == "paper") return PaperMethods();
  const std::vector<Method> all = AllMethods();
  if (name == "all") return all;
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const Method& method) { return method.name == name; });
  if (found == all.end()) {
    throw ConfigError("--methods " + name + ": no such method; allowed: " + NamesOf(all));
  }
  return {*found};
}

}  // namespace

std::vector<Method> AllMethods() {
  std::vector<Method> methods{WholeChain()};
  std::ranges::move(PaperMethods(), std::back_inserter(methods));
  methods.push_back(PaperFilled());
  for (const Rival& rival : AllRivals()) methods.push_back(FromRival(rival));
  return methods;
}

std::vector<Method> SelectMethods(const std::vector<std::string>& names) {
  std::vector<Method> selected;
  for (const std::string& name : names) {
    for (Method& method : MethodsOf(name)) {
      const auto same = [&](const Method& other) { return other.name == method.name; };
      if (std::none_of(selected.begin(), selected.end(), same))
        selected.push_back(std::move(method));
    }
  }
  return selected;
}

}  // namespace sprout::evaluate
