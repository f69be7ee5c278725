#include "services/calibrate/scene/scene_refiner.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numbers>

#include "tests/services/calibrate/knocked_scene.h"

namespace sprout::calibrate {
namespace {

TEST(Experiment, Try) {
  const char* text = std::getenv("TRY");
  const int width = text ? std::atoi(text) : 1024;
  const char* seeds = std::getenv("SEEDS");
  const char* tof = std::getenv("TOF");
  const int frames_count = std::getenv("FRAMES") ? std::atoi(std::getenv("FRAMES")) : 3;
  const RawRig rig = TrueRig({width, width * 3 / 4});
  for (uint32_t seed = 0; seed < uint32_t(seeds ? std::atoi(seeds) : 3); ++seed) {
    std::vector<RigImages> frames;
    for (int i = 0; i < frames_count; ++i) frames.push_back(RenderScene(rig, seed, 20 * i, !tof));
    for (int kind = 0; kind < 2; ++kind) {
      RigNumbers errors{};
      if (kind == 1) {
        for (size_t i = 0; i < kRigNumbers; ++i)
          errors[i] = 0.6 * RowOf(RigNumber(i)).expected * ((seed + i) % 2 ? 1 : -1);
      }
      errors[kPlaceY] = errors[kPlaceZ] = 0;
      SceneWishes wishes{.focal = true, .rows = true, .places = false};
      if (const char* w = std::getenv("WISH")) {
        wishes.focal = w[0] == '1';
        wishes.rows = w[1] == '1';
        wishes.places = w[2] == '1';
        if (!wishes.focal) errors[kFocal] = errors[kFocalRight] = 0;
        if (!wishes.rows) errors[kRowRight] = 0;
      }
      const auto refined = RefineKnocked(rig, errors, frames, wishes);
      if (!refined) {
        std::cout << "refused " << refined.error().text << "\n";
        continue;
      }
      const auto& r = *refined;
      std::cout << fmt::format(
          "seed {} kind {}: matches {} tof {} edges {}; rows {:.3f}/{:.3f} -> {:.3f}/{:.3f} 95 {:.2f}; tof {:+.2f}px {:+.1f}mm "
          "-> {:+.2f}px {:+.1f}mm sigma {:.3f}\n",
          seed, kind, r.matches, r.tof_matches, r.edge_views, r.before.rows_median_px,
          r.before.rows_abs_median_px, r.after.rows_median_px, r.after.rows_abs_median_px, r.after.rows_abs_95_px,
          r.before.tof_px, 1000 * r.before.tof_m, r.after.tof_px, 1000 * r.after.tof_m, r.adjusted.match_sigma_px);
      const RigNumbers left = ErrorsLeft(rig, r.rig);
      for (size_t i = 0; i < kRigNumbers; ++i) {
        const auto& row = RowOf(RigNumber(i));
        std::cout << fmt::format("   {:26} {:+8.4f} left {:+8.4f} ± {:.4f} {} {}\n", row.name,
                                 row.per_unit * errors[i], row.per_unit * left[i],
                                 row.per_unit * r.adjusted.sigma[i], row.unit,
                                 r.adjusted.seen[i] ? "" : "not seen");
      }
    }
  }
}

}  // namespace
}  // namespace sprout::calibrate
