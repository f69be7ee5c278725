#include "common/app/service.h"
#include "services/prior/prior_plug.h"

int main(int argc, char** argv) {
  return sprout::RunStage(
      argc, argv, "prior",
      "Interpolates the seeds over their Delaunay triangulation to the prior disparity map.\n"
      "Joins SPROUT_SEEDS and SPROUT_RIG; publishes SPROUT_PRIOR.",
      [](const sprout::SproutConfig&) { return std::make_unique<sprout::PriorPlug>(); });
}
