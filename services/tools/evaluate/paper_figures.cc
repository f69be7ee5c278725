#include "services/tools/evaluate/paper_figures.h"

#include <iterator>

namespace sprout::evaluate {
namespace {

constexpr const char* kScenes[] = {"Lampshade1", "Monopoly", "Plastic"};

struct PublishedRow {
  const char* method;
  double percent[std::size(kScenes)];
};

// Gandhi, Čech, Horaud: "High-Resolution Depth Maps Based on TOF-Stereo Fusion", ICRA 2012, III-A:
// the evaluation on Middlebury 2006, full size.
constexpr PublishedRow kRows[] = {
    {"mncc-harris", {61.5, 51.2, 25.2}},   {"mncc-tof", {64.3, 53.4, 28.2}},
    {"expssd-harris", {44.9, 29.4, 13.5}}, {"expssd-tof", {49.5, 32.1, 20.6}},
    {"epc", {88.8, 85.2, 88.7}},           {"epc-filled", {96.4, 95.3, 98.2}},
    {"prior", {92.9, 92.1, 96.0}},
};

}  // namespace

std::optional<double> PaperPercent(const std::string& scene, const std::string& method) {
  for (const PublishedRow& row : kRows) {
    for (size_t i = 0; i < std::size(kScenes); ++i) {
      if (method == row.method && scene == kScenes[i]) return row.percent[i];
    }
  }
  return std::nullopt;
}

}  // namespace sprout::evaluate
