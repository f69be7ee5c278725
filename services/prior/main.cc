#include "common/app/run_stage.h"
#include "services/prior/prior_adapter.h"

int main(int argc, char** argv) {
  return sprout::RunStage(
      argc, argv, "prior",
      "Makes the prior disparity map from the seeds: interpolated over their Delaunay\n"
      "triangulation, and decided between near and far where that spans a depth edge.\n"
      "Joins SPROUT_SEEDS and SPROUT_RIG, SPROUT_LEFT_SEEDS unless left_seeds is off, "
      "SPROUT_LEFT,\n"
      "and SPROUT_RIGHT with the method that looks at it; publishes SPROUT_PRIOR.",
      [](const sprout::SproutConfig& config) {
        return std::make_unique<sprout::prior::PriorAdapter>(config.prior());
      });
}
