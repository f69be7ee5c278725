#include "common/app/run_stage.h"
#include "services/grow/grow_adapter.h"

int main(int argc, char** argv) {
  return sprout::RunStage(
      argc, argv, "grow",
      "Grows correspondences best first from the seeds, guided by the prior, and fills gaps.\n"
      "Joins SPROUT_LEFT, SPROUT_RIGHT, SPROUT_SEEDS and SPROUT_PRIOR (the last two as the\n"
      "configuration needs them); publishes SPROUT_DISPARITY.",
      [](const sprout::SproutConfig& config) {
        return std::make_unique<sprout::grow::GrowAdapter>(config.grow());
      });
}
