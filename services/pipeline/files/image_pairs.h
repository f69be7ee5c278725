#ifndef SPROUT_SERVICES_PIPELINE_FILES_IMAGE_PAIRS_H_
#define SPROUT_SERVICES_PIPELINE_FILES_IMAGE_PAIRS_H_

#include <filesystem>
#include <string>
#include <vector>

namespace sprout {

/// The files of one frame.
struct ImagePair {
  std::filesystem::path left;
  std::filesystem::path right;
  std::filesystem::path tof;     ///< empty: none
  std::filesystem::path folder;  ///< of its results, below the output folder
};

/// Lists the pairs of LEFT, RIGHT and --tof. Each is an image, a folder of images or a pattern
/// ("left/*.png"), whose files are paired in the order of their names. The results of one pair
/// given as two images have no folder of their own; others have one named after the left image, and
/// where these have equal names, after its folder, too.
/// @param tof  empty: none.
/// @throws ConfigError for missing files, and for lists that differ in length.
std::vector<ImagePair> ListPairs(const std::string& left, const std::string& right,
                                 const std::string& tof);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PIPELINE_FILES_IMAGE_PAIRS_H_
