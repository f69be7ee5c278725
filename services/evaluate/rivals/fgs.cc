#include "services/evaluate/rivals/rival.h"
#include "services/prior/seed_spreading.h"

namespace sprout {
namespace {

cv::Mat1f Compute(const RivalInput& input) {
  return SpreadSeeds(input.seeds, input.left, input.fgs_lambda, input.fgs_sigma);
}

}  // namespace

Rival Fgs() {
  return {.name = "fgs",
          .summary =
              "OpenCV's FastGlobalSmoother spreads the ToF seeds over the left image with the "
              "preset's fgs_lambda and fgs_sigma; never looks at the right one",
          .uses_seeds = true,
          .compute = Compute};
}

}  // namespace sprout
