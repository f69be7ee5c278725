#include "services/evaluate/rivals/rival.h"
#include "services/prior/seed_spreading.h"

namespace sprout {
namespace {

constexpr double kLambda = 10;     // strength of the smoothing
constexpr double kSigmaColor = 3;  // difference of colours over which it hardly goes, grey levels

cv::Mat1f Compute(const RivalInput& input) {
  return SpreadSeeds(input.seeds, input.left, kLambda, kSigmaColor);
}

}  // namespace

Rival Fgs() {
  return {.name = "fgs",
          .summary =
              "OpenCV's FastGlobalSmoother spreads the ToF seeds over the left image; never "
              "looks at the right one",
          .uses_seeds = true,
          .compute = Compute};
}

}  // namespace sprout
