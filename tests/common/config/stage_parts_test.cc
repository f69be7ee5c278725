#include "common/config/stage_parts.h"

#include <gtest/gtest.h>

namespace sprout {
namespace {

TEST(StageParts, RefineNeedsACaptureAndAnswersSeeds) {
  RefineConfig config;
  EXPECT_EQ(InputsOf(config), (PartSet{Part::kLeft, Part::kRight, Part::kTof, Part::kRig}));
  config.set_zones(true);
  EXPECT_EQ(InputsOf(config),
            (PartSet{Part::kLeft, Part::kRight, Part::kTof, Part::kTofZones, Part::kRig}));
  EXPECT_EQ(OutputsOf(config), (PartSet{Part::kSeeds, Part::kLeftSeeds}));
}

TEST(StageParts, PriorNeedsTheRightImageForEdgesOnly) {
  PriorConfig config;
  config.set_method(PriorConfig::DELAUNAY);
  config.set_left_seeds(false);
  EXPECT_EQ(InputsOf(config), (PartSet{Part::kLeft, Part::kRig, Part::kSeeds}));
  config.set_method(PriorConfig::EDGES);
  config.set_left_seeds(true);
  EXPECT_EQ(InputsOf(config),
            (PartSet{Part::kLeft, Part::kRight, Part::kRig, Part::kSeeds, Part::kLeftSeeds}));
  EXPECT_EQ(OutputsOf(config), PartSet{Part::kPrior});
}

TEST(StageParts, GrowNeedsThePriorForItsSimilarityOrItsGaps) {
  const PartSet without{Part::kLeft, Part::kRight, Part::kSeeds};
  PartSet with = without;
  with.Add(Part::kPrior);
  GrowConfig config;
  for (const auto similarity : {GrowConfig::MNCC, GrowConfig::EXPSSD, GrowConfig::EPC}) {
    for (const auto fill : {GrowConfig::NONE, GrowConfig::ONE_PASS, GrowConfig::PRIOR}) {
      config.set_similarity(similarity);
      config.set_fill(fill);
      const bool uses_prior = similarity == GrowConfig::EPC || fill == GrowConfig::PRIOR;
      EXPECT_EQ(InputsOf(config), uses_prior ? with : without) << similarity << " " << fill;
    }
  }
}

TEST(StageParts, GrowAnswersWhatItsConfigurationPublishes) {
  GrowConfig config;
  config.set_publish_confidence(false);
  EXPECT_EQ(OutputsOf(config), PartSet{Part::kDisparity});
  config.set_publish_confidence(true);
  config.set_publish_unfilled(true);
  EXPECT_EQ(OutputsOf(config),
            (PartSet{Part::kDisparity, Part::kUnfilled, Part::kConfidence, Part::kSigma}));
}

TEST(StageParts, AreKnownByName) {
  SproutConfig config;
  EXPECT_EQ(InputsOf("refine", config), InputsOf(config.refine()));
  EXPECT_EQ(InputsOf("prior", config), InputsOf(config.prior()));
  EXPECT_EQ(OutputsOf("grow", config), OutputsOf(config.grow()));
}

}  // namespace
}  // namespace sprout
