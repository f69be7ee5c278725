#include "common/app/run_stage.h"
#include "services/temporal/temporal_adapter.h"

int main(int argc, char** argv) {
  return sprout::RunStage(
      argc, argv, "temporal",
      "Fuses disparity maps with those of earlier frames, moved by the camera's own motion, which\n"
      "it measures: steadier, fuller maps, and odometry. Joins SPROUT_LEFT, SPROUT_RIG,\n"
      "SPROUT_DISPARITY and SPROUT_CONFIDENCE; publishes SPROUT_FUSED, SPROUT_FUSED_CONFIDENCE "
      "and\n"
      "SPROUT_MOTION.",
      [](const sprout::SproutConfig& config) {
        return std::make_unique<sprout::temporal::TemporalAdapter>(config.temporal());
      });
}
