#pragma once

#include <span>

#include "common/core/frame.h"
#include "common/core/rig.h"
#include "common/core/seed.h"
#include "common/core/stage_adapter.h"

namespace sprout {

// Where the right principal point lies further right than the left one (a converged or cropped
// pair), far points have negative disparities: u − u' = f·b/z − (cx_right − cx). The stages search
// from 0. So they work on a wider frame: n columns are added left of the left image and right of
// the right one, which puts n onto every disparity and loses no pixel, and their answers are cut
// back to the images.

/// Most columns that are added.
inline constexpr int kMaxColumns = 512;

/// n for a calibration: the least with which no point in front of the cameras has a negative
/// disparity; 0 where there is none without it.
int ColumnsBelowZero(const RectifiedPair& pair);

/// n for correspondences, where some have a disparity below −1 px, else 0: rounding a match to less
/// than a pixel makes no negative disparity.
int ColumnsBelowZero(std::span<const Seed> seeds);

/// The frame with n more columns: images (the border pixels repeated), pair, seeds, prior. Other
/// parts stay as they are. O(pixels).
/// @param columns  1 to kMaxColumns.
Frame Widened(const Frame& frame, int columns);

/// Cuts the answer of a stage to a widened frame back to the images: maps, confidences and seeds;
/// seeds beside the images count as `outside`. O(pixels).
/// @param size  of the images, before Widened().
void Narrow(StageResult& result, int columns, cv::Size size);

}  // namespace sprout
