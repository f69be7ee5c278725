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
      "and other viewers.\n"
      "Rules (min_m, max_m, region, box, min_confidence, remove_flying) leave points out,\n"
      "counted on SPROUT_DEPTH_COUNTS. With depth { rig: FILE } also the points in the robot's "
      "frame, on\n"
      "SPROUT_BASE_CLOUD; with target: NAME depth and points as another camera sees them, on\n"
      "SPROUT_TARGET_DEPTH and SPROUT_TARGET_CLOUD; with publish_scan: true SPROUT_SCAN, a laser "
      "scan.",
      [](const sprout::SproutConfig& config) {
        return std::make_unique<sprout::depth::DepthAdapter>(config.depth());
      });
}
