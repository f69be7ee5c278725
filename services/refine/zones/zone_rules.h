#ifndef SPROUT_SERVICES_REFINE_ZONES_ZONE_RULES_H_
#define SPROUT_SERVICES_REFINE_ZONES_ZONE_RULES_H_

namespace sprout::refine {

/// The constants of zones. NOTES.md has what was measured.
struct ZoneRules {
  /// A target's surface lies within this many standard deviations: of a zone that two surfaces
  /// share, the smaller one counts up to a tenth of the light.
  static constexpr double kSigmas = 3;
  /// What a zone says reaches this many of its own widths and heights beyond its sides: a surface
  /// that a zone hardly sees fills the next one.
  static constexpr double kReach = 1;
  /// On average a place of the left image is within reach of at most this many zones, else the
  /// message makes no sense: 9 of a grid, and as many again beside depth edges.
  static constexpr int kMostZonesPerCell = 64;
  /// Scale of the M-estimator for the planes of zones, px of disparity a px: the prior's
  /// plane_scale_per_spacing.
  static constexpr double kPlaneScalePerPx = 0.12;
  /// And how many standard deviations of both zones: the prior's.
  static constexpr double kPlaneScaleSigmas = 2;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_ZONES_ZONE_RULES_H_
