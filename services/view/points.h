#pragma once

#include "services/view/decoded_frame.h"
#include "services/view/packet.h"

namespace sprout::view {

/// Most points of a cloud, and most seeds, that are sent to a page.
inline constexpr int kMaxShownPoints = 150'000;
inline constexpr int kMaxShownSeeds = 60'000;

/// The cloud of a frame as a grid of every `stride`-th pixel and row: int16 counts of disparity, 3
/// × uint8 colour (red, green, blue), and uint8 confidence if has_confidence; the page computes the
/// points with the calibration in the head. So a point takes 6 bytes, without loss of depth. Null
/// without a disparity map, left image and calibration of one size. O(points).
EncodedPartPtr EncodeCloud(DecodedFrame& frame);

/// The seeds of a frame: int16 column, row, and disparity (counts), uint8 kind (0 ToF, 1 stereo, 2
/// seen by the left camera only), as consecutive arrays. If there are too many seeds, every n-th is
/// sent. Null without seeds. O(seeds).
EncodedPartPtr EncodeSeeds(DecodedFrame& frame);

/// The values at a pixel: u, v; disparity_px, its disparity_sigma_px, depth_m, fused_px, confidence
/// (0 to 1), prior_px, its sigma_px, grey or colour; and of the nearest seed its position, origin,
/// sigma_px and distance_px. Unknown values are left out. O(seeds).
nlohmann::json ProbeJson(DecodedFrame& frame, int u, int v);

}  // namespace sprout::view
