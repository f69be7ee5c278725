#include "common/app/run_stage.h"
#include "services/refine/refine_adapter.h"

int main(int argc, char** argv) {
  return sprout::RunStage(
      argc, argv, "refine",
      "Projects the ToF points into the rectified pair and drops the unreliable ones.\n"
      "Joins SPROUT_LEFT, SPROUT_RIGHT, SPROUT_TOF and SPROUT_RIG; publishes SPROUT_SEEDS, and\n"
      "SPROUT_LEFT_SEEDS: the points that only the left camera sees.",
      [](const sprout::SproutConfig& config) {
        return std::make_unique<sprout::refine::RefineAdapter>(config.refine());
      });
}
