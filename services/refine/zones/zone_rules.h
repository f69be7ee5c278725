#ifndef SPROUT_SERVICES_REFINE_ZONES_ZONE_RULES_H_
#define SPROUT_SERVICES_REFINE_ZONES_ZONE_RULES_H_

namespace sprout::refine {

/// The constants of zones. NOTES.md has what was measured.
struct ZoneRules {
  /// How many standard deviations a target's surface is nearer at most, and how many a zone's plane
  /// must be off all planes of seeds around to add information. The smaller surface of a target
  /// with two is 3 away if it has a tenth of the light.
  static constexpr double kSigmas = 3;
  /// How many times less sure the seeds around must be than the zone. Measured.
  static constexpr double kSurer = 4;
  /// A target bounds disparities up to this many widths and heights of its zone beyond the zone's
  /// sides: a surface that one zone hardly sees fills the next one.
  static constexpr double kReach = 1;
  /// Zones fill no cell with a seed in so many cells around. Measured.
  static constexpr int kGapCells = 2;
  /// Most zones within whose reach a place of the left image lies, on average; a message with more
  /// makes no sense. A grid has 9, and as many again beside depth edges.
  static constexpr int kMaxZonesPerCell = 64;
  /// Scale of the M-estimator for the planes of zones, px of disparity a px: the prior's
  /// plane_scale_per_spacing, and its wider first round.
  static constexpr double kPlaneScalePerPx = 0.12;
  static constexpr double kFirstScale = 1.5;
  /// The scale is at least this many standard deviations of both zones, as in the prior.
  static constexpr double kPlaneScaleSigmas = 2;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_ZONES_ZONE_RULES_H_
