// Opens the real scenes, when they are there.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "common/geometry/projection.h"
#include "common/scenes/dataset.h"

namespace sprout::scenes {
namespace {

namespace fs = std::filesystem;

// Every folder with a left image below SPROUT_DATA/middlebury.
std::vector<fs::path> Scenes() {
  std::vector<fs::path> scenes;
  const char* data = std::getenv("SPROUT_DATA");
  if (data == nullptr) return scenes;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(data) / "middlebury")) {
    const std::string name = entry.path().stem();
    if (name == "view1" || name == "im0") scenes.push_back(entry.path().parent_path());
  }
  return scenes;
}

// What these scenes have in common, measured on the files themselves. The ends of the range leave
// out one pixel in a hundred, as some truths have strays.
struct Range {
  float low_px;
  float high_px;
};

Range ExpectPlausible(const cv::Mat1f& disparity, const std::string& what) {
  std::vector<float> known;
  std::copy_if(disparity.begin(), disparity.end(), std::back_inserter(known),
               [](float d) { return !std::isnan(d); });
  EXPECT_GT(static_cast<double>(known.size()), 0.85 * static_cast<double>(disparity.total()))
      << what;
  std::sort(known.begin(), known.end());
  const size_t strays = known.size() / 100;
  const Range range{known[strays], known[known.size() - 1 - strays]};
  EXPECT_GT(range.low_px, 0.008 * disparity.cols) << what;
  EXPECT_GT(range.high_px, 0.07 * disparity.cols) << what;
  EXPECT_LT(range.high_px, 0.2 * disparity.cols) << what;
  return range;
}

TEST(MiddleburyData, OpensEveryScene) {
  const std::vector<fs::path> scenes = Scenes();
  if (scenes.empty()) {
    GTEST_SKIP() << "set SPROUT_DATA to a folder with middlebury/*: scripts/fetch_middlebury";
  }
  for (const fs::path& scene : scenes) {
    const auto source = OpenDataset("middlebury:" + scene.string());
    const DatasetFrame frame = source->Get(0);
    const RectifiedPair& pair = source->rig().pair;
    const std::string what = scene.string();

    EXPECT_EQ(frame.left.size(), pair.size()) << what;
    EXPECT_EQ(frame.right.size(), pair.size()) << what;
    EXPECT_GE(pair.width, 400) << what;
    EXPECT_GE(pair.height, 370) << what;
    const Range range = ExpectPlausible(frame.truth.left, what);
    if (!frame.truth.right.empty()) ExpectPlausible(frame.truth.right, what);
    EXPECT_EQ(frame.tof.depth_m.size(), cv::Size(pair.width / 10, pair.height / 10)) << what;
    if (fs::exists(scene / "disp1.png")) {  // one camera, at three sizes
      EXPECT_NEAR(pair.focal_px / pair.height, 3740.0 / 1110, 1e-9) << what;
    }
    if (fs::exists(scene / "dmin.txt") || fs::exists(scene / "calib.txt")) {
      // A table or a room; without dmin.txt depths are not metric.
      EXPECT_GT(pair.DepthFromDisparity(range.high_px), 0.8) << what;
      EXPECT_LT(pair.DepthFromDisparity(range.low_px), 6) << what;
    }
  }
}

TEST(MiddleburyData, ShowsEverySceneToAnSr4000) {
  const std::vector<fs::path> scenes = Scenes();
  if (scenes.empty()) {
    GTEST_SKIP() << "set SPROUT_DATA to a folder with middlebury/*: scripts/fetch_middlebury";
  }
  for (const fs::path& scene : scenes) {
    const auto source = OpenDataset("middlebury:" + scene.string() + "?tof=sr4000");
    const DatasetFrame frame = source->Get(0);
    int behind = 0;
    int known = 0;
    int close = 0;
    for (const auto& point : TofProjector(source->rig()).Project(frame.tof, behind)) {
      const cv::Point pixel(static_cast<int>(std::lround(point.seed.u)),
                            static_cast<int>(std::lround(point.seed.v)));
      if (!cv::Rect({}, frame.truth.left.size()).contains(pixel)) continue;
      const float truth_px = frame.truth.left(pixel);
      if (std::isnan(truth_px)) continue;
      ++known;
      if (std::abs(truth_px - point.seed.disparity()) <= 3) ++close;
    }
    EXPECT_EQ(behind, 0) << scene;
    EXPECT_GT(known, 176 * 144 / 2) << scene;
    EXPECT_GT(close, 0.75 * known) << scene;  // others are hidden from the left camera, or fly
  }
}

}  // namespace
}  // namespace sprout::scenes
