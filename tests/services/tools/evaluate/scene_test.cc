#include "services/tools/evaluate/scene.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/common/scenes/kitti_folder.h"
#include "tests/common/testing/thrown.h"

namespace sprout::evaluate {
namespace {

TEST(Scene, IsAwayWhereNoToFPointIsWithinThreePixels) {
  const scenes::KittiFolder folder("000007");  // points at (20, 15) and (15, 25)
  const std::string frame = folder.Config("/000007").source();
  const Scene scene = LoadScene(frame, TofChoice("scan"), {});
  for (int v = 0; v < scene.size().height; ++v) {
    for (int u = 0; u < scene.size().width; ++u) {
      const double nearest_px = std::min(std::hypot(u - 20, v - 15), std::hypot(u - 15, v - 25));
      EXPECT_EQ(scene.away(v, u) != 0, nearest_px >= kAwayPx) << u << ", " << v;
    }
  }
  const Scene without = LoadScene(frame, TofChoice("none"), {});
  EXPECT_EQ(cv::countNonZero(without.away), scene.size().area());
}

TEST(Scene, CarriesATofCameraOfItsOwn) {
  const scenes::SceneFolder folder(cv::Size(40, 30));
  const std::filesystem::path path = std::filesystem::path(folder.File("x")).parent_path();
  const std::string name = path.filename();
  for (const std::string slash : {"", "/"}) {
    const Scene scene =
        LoadScene(path.string() + slash + "?tof=sr4000&blind=50", TofChoice("grid:5"), {});
    EXPECT_EQ(scene.projector.rig().tof.width, 176);
    EXPECT_EQ(scene.name, name + "_tof=sr4000_blind=50");
  }
}

TEST(Scene, OfMiddleburyIsAFolderOrWhatCaptureCallsIt) {
  EXPECT_EQ(ScenesOf("data/Art"), std::vector<std::string>{"data/Art"});
  EXPECT_EQ(ScenesOf("middlebury:data/Art"), std::vector<std::string>{"data/Art"});
}

TEST(Scene, TakesWhatBothCamerasSeeFromKittisTruth) {
  const scenes::KittiFolder folder("000007");  // 5 px everywhere but at (0, 0)
  cv::Mat1w seen(30, 40, uint16_t{5 * 256});
  seen(cv::Rect(0, 0, 40, 1)) = 0;
  folder.WriteTruth("disp_noc_0/000007_10.png", seen);
  const Scene scene = LoadScene(folder.Config("/000007").source(), TofChoice("scan"), {});
  EXPECT_EQ(cv::countNonZero(scene.nonoccluded), 29 * 40);
  // The first row is hidden, but for what lies beyond the border of the right image.
  EXPECT_EQ(cv::countNonZero(scene.occluded), 35);
  EXPECT_EQ(cv::countNonZero(scene.occluded.row(0)), 35);
  EXPECT_EQ(scene.max_disparity_px, 5);
}

TEST(Scene, RefusesATruthOfWhichNothingIsScored) {
  const scenes::KittiFolder folder("000007");
  folder.WriteTruth("disp_occ_0/000007_10.png", cv::Mat1w(30, 40, uint16_t{0}));
  EXPECT_THAT(Thrown<ConfigError>(
                  [&] { LoadScene(folder.Config("/000007").source(), TofChoice("scan"), {}); }),
              testing::HasSubstr("its ground truth has no pixel that both cameras see"));
}

}  // namespace
}  // namespace sprout::evaluate
