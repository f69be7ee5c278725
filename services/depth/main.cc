#include "common/app/run_stage.h"
#include "services/depth/depth_adapter.h"

int main(int argc, char** argv) {
  return sprout::RunStage(
      argc, argv, "depth",
      "Converts the final disparity map to depth in metres and to points.\n"
      "Joins SPROUT_DISPARITY (with depth { input: FUSED } SPROUT_FUSED), SPROUT_LEFT and\n"
      "SPROUT_RIG, and the map's confidence unless depth { confidence: false }; publishes "
      "SPROUT_DEPTH and SPROUT_CLOUD, and with\n"
      "depth { publish_sigma: true } SPROUT_DEPTH_SIGMA, the depths' standard deviations, from\n"
      "SPROUT_SIGMA, with depth { publish_preview: true } SPROUT_PREVIEW, a picture for lcm-spy "
      "and other viewers.",
      [](const sprout::SproutConfig& config) {
        return std::make_unique<sprout::depth::DepthAdapter>(config.depth());
      });
}
