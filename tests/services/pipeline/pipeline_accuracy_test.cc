// What preset default reaches on real scenes. A change that costs more than the margin below the
// figure in each row has to say why.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/measure/score.h"
#include "services/pipeline/pipeline.h"
#include "services/tools/evaluate/scene.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

constexpr double kMarginPoints = 0.3;

// Correct non-occluded pixels, error <= 1 px, per cent.
double CorrectPercent(const std::string& folder, const std::string& tof) {
  const evaluate::Scene scene =
      evaluate::LoadScene(folder, evaluate::TofChoice(tof), LoadConfig({"default"}).capture());
  Pipeline pipeline(LoadConfig({"default"}));
  const auto result =
      pipeline.Compute(scene.frame.left, scene.frame.right, scene.frame.tof, scene.projector.rig());
  if (!result) throw std::runtime_error(result.error().text);
  return Score(result->disparity, scene.frame.truth.left, scene.nonoccluded)
      .value()
      .correct_le1_percent();
}

struct Expected {
  const char* tof;
  double percent;
};

// Debian's opencv-doc has it everywhere. Its truth is of whole pixels and of the left view only.
TEST(PipelineAccuracy, HoldsOnAloe) {
  const fs::path data = "/usr/share/doc/opencv-doc/examples/data";
  const TemporaryDirectory folder;
  fs::create_symlink(data / "aloeL.jpg", folder / "view1.jpg");
  fs::create_symlink(data / "aloeR.jpg", folder / "view5.jpg");
  fs::create_symlink(data / "aloeGT.png", folder / "disp1.png");
  std::ofstream(folder / "dmin.txt") << "270\n";
  for (const auto& [tof, percent] :
       {Expected{"grid:auto", 96.99}, {"sr4000?blind=50", 89.46}, {"none", 90.33}}) {
    const double correct = CorrectPercent(folder.path(), tof);
    EXPECT_GE(correct, percent - kMarginPoints) << tof;
  }
}

TEST(PipelineAccuracy, HoldsOnMiddlebury) {
  const char* data = std::getenv("SPROUT_DATA");
  if (data == nullptr) {
    GTEST_SKIP() << "SPROUT_DATA is not set; scripts/fetch_middlebury gets the scenes";
  }
  const std::string half = std::string(data) + "/middlebury/half/";
  for (const auto& [tof, percent] :
       {Expected{"grid:auto", 98.92}, {"sr4000?blind=50", 94.58}, {"none", 92.37}}) {
    double sum = 0;
    for (const char* scene : {"Art", "Books", "Cloth3", "Dolls"})
      sum += CorrectPercent(half + scene, tof);
    EXPECT_GE(sum / 4, percent - kMarginPoints) << tof;
  }
}

}  // namespace
}  // namespace sprout
