#include "common/app/run_stage.h"
#include "services/depth/depth_adapter.h"

int main(int argc, char** argv) {
  return sprout::RunStage(
      argc, argv, "depth",
      "Converts the final disparity map to depth in metres and to points.\n"
      "Joins SPROUT_DISPARITY, SPROUT_LEFT and SPROUT_RIG, and SPROUT_CONFIDENCE unless\n"
      "depth { confidence: false }; publishes SPROUT_DEPTH and SPROUT_CLOUD, and with\n"
      "depth { publish_preview: true } SPROUT_PREVIEW, a picture for lcm-spy and other viewers.",
      [](const sprout::SproutConfig& config) {
        return std::make_unique<sprout::depth::DepthAdapter>(config.depth());
      });
}
