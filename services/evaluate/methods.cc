#include "services/evaluate/methods.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "services/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

Method WholeChain() {
  return {.name = "sprout",
          .summary = "the whole chain as the services run it, its final map",
          .run = RunChain};
}

Method PriorAlone() {
  return {.name = "prior",
          .summary = "D_p alone, as the preset's method makes it",
          .run = [](const Scene& scene, const ChainSettings& settings) {
            MethodOutput output;
            StageTimes& ms = output.ms;
            Frame frame = FrameOf(scene);
            RunRefine(scene, settings, frame, ms);
            RunPrior(settings.config.prior(), frame, ms);
            output.map_px = ToPx(frame.prior->disparity);
            ms.total_ms = ms.refine_ms + ms.prior_ms;
            return output;
          }};
}

// The chain with another similarity, other seeds and without gap filling.
Method Variant(std::string name, std::string summary, GrowConfig::Similarity similarity,
               GrowConfig::Seeds seeds) {
  return {.name = std::move(name),
          .summary = std::move(summary),
          .run = [=](const Scene& scene, ChainSettings settings) {
            GrowConfig& grow = *settings.config.mutable_grow();
            grow.set_similarity(similarity);
            grow.set_seeds(seeds);
            grow.set_fill(GrowConfig::NONE);
            return RunChain(scene, settings);
          }};
}

Method EpcFilled() {
  return {.name = "epc-filled",
          .summary = "the same with gaps filled, as the preset says (at least one pass)",
          .run = [](const Scene& scene, ChainSettings settings) {
            GrowConfig& grow = *settings.config.mutable_grow();
            grow.set_similarity(GrowConfig::EPC);
            grow.set_seeds(GrowConfig::TOF);
            if (grow.fill() == GrowConfig::NONE) grow.set_fill(GrowConfig::ONE_PASS);
            return RunChain(scene, settings);
          }};
}

std::vector<Method> PaperMethods() {
  return {
      Variant("mncc-harris", "growth by MNCC, eq. (1), from Harris corners", GrowConfig::MNCC,
              GrowConfig::HARRIS),
      Variant("mncc-tof", "growth by MNCC from ToF seeds", GrowConfig::MNCC, GrowConfig::TOF),
      Variant("expssd-harris", "growth by EXPSSD, eq. (4), from Harris corners", GrowConfig::EXPSSD,
              GrowConfig::HARRIS),
      Variant("expssd-tof", "growth by EXPSSD from ToF seeds", GrowConfig::EXPSSD, GrowConfig::TOF),
      Variant("epc", "growth by EPC, eq. (6): EXPSSD and the prior, from ToF seeds",
              GrowConfig::EPC, GrowConfig::TOF),
      EpcFilled(),
      PriorAlone()};
}

// What the paper published, whatever preset the others run with.
Method PaperFilled() {
  return {.name = "paper-filled",
          .summary = "epc-filled of preset paper, whatever the preset of this run",
          .run = [](const Scene& scene, ChainSettings settings) {
            settings.config = LoadConfig({"paper"});
            return RunChain(scene, settings);
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
              RunRefine(scene, tof_only, frame, ms);
              Join(frame.seeds->seeds, frame.left_seeds->seeds, seeds);
            }
            const RivalInput input{.left = scene.frame.left,
                                   .right = scene.frame.right,
                                   .seeds = seeds,
                                   .max_disparity_px = scene.max_disparity_px,
                                   .fgs = settings.fgs};
            ms.total_ms = ms.refine_ms;
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
