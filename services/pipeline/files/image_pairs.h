#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/pair_names.h"

namespace sprout {

/// The files of one frame.
struct ImagePair {
  std::filesystem::path left = {};
  std::filesystem::path right = {};
  std::filesystem::path tof = {};  ///< empty: none
  /// Numbers of the pictures in the two videos, from 0; −1 if the files are images.
  int64_t left_frame = -1;
  int64_t right_frame = -1;
  std::filesystem::path folder = {};  ///< of its results, below the output folder
};

/// What ListPairs() found.
struct ImagePairs {
  std::vector<ImagePair> pairs = {};    ///< in the order of their times or numbers
  int64_t left_out = 0;                 ///< images of left and right that have no partner
  std::vector<std::string> notes = {};  ///< what a user should know of it, one line each
};

/// Lists the pairs of LEFT, RIGHT and --tof. Each is an image, a folder of images or a pattern
/// ("left/*.png"), whose files are joined by PairNames(). A pair without a ToF image is one all the
/// same. The results of one pair given as two images have no folder of their own; others have one
/// named after the left image, and where these have equal names, after its folder, too. LEFT and
/// RIGHT may also be two videos, whose pictures are joined by their times (PairTimes()), within
/// half the time between two pictures of the faster one; all pictures are looked at for that. Their
/// results have folders with the numbers of the left ones.
/// @param tof            empty: none.
/// @param max_spread_ms  see PairNames().
/// @throws ConfigError for missing files, and when no two belong together.
ImagePairs ListPairs(const std::string& left, const std::string& right, const std::string& tof,
                     double max_spread_ms = kMaxSpreadMs);

}  // namespace sprout
