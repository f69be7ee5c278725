#include "services/tools/evaluate/truth_check.h"

#include <gmock/gmock.h>

#include "services/tools/evaluate/log_evaluation.h"
#include "services/tools/evaluate/video.h"
#include "tests/common/scenes/kitti_folder.h"

namespace sprout::evaluate {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

Scene Synthetic() { return LoadScene("synthetic:640x480", TofChoice("none"), {}); }

TEST(TruthCheck, NamesATruthOfAnotherScaleOrPicture) {
  EXPECT_EQ(WrongTruthText(Synthetic()), "");
  Scene half = Synthetic();
  half.frame.truth.left *= 0.5;
  EXPECT_THAT(WrongTruthText(half), StartsWith("the ground truth does not fit the images; taken"));
  EXPECT_THAT(WrongTruthText(half), HasSubstr("times too long"));
  Scene turned = Synthetic();
  cv::flip(turned.frame.truth.left, turned.frame.truth.left, 0);
  EXPECT_THAT(WrongTruthText(turned), HasSubstr("upside down"));
}

// The synthetic scene with a truth of half its scale.
class HalfTruth : public scenes::Dataset {
 public:
  const Rig& rig() const override { return scene_->rig(); }
  std::optional<int64_t> frame_count() const override { return scene_->frame_count(); }
  scenes::DatasetFrame Get(int64_t index) override {
    scenes::DatasetFrame frame = scene_->Get(index);
    frame.truth.left *= 0.5;
    return frame;
  }

 private:
  std::unique_ptr<scenes::Dataset> scene_ = scenes::OpenDataset("synthetic:640x480");
};

TEST(TruthCheck, NamesTheTruthOfALogToo) {
  for (const bool is_half : {false, true}) {
    auto scene = scenes::OpenDataset("synthetic:640x480");
    Frame frame;
    frame.id = {.utime = 0, .seq = 0, .rig_id = ""};
    frame.disparity = FromPx(scene->Get(0).truth.left);
    LogEvaluation log(is_half ? std::make_unique<HalfTruth>() : std::move(scene));
    log.Add(frame);
    EXPECT_EQ(log.wrong_truth().starts_with("the ground truth does not fit"), is_half);
  }
}

// A wall at 10 m, 5 px, that a scan measures at every other pixel, off by so much.
void WriteWall(const scenes::KittiFolder& folder, const std::string& id, double off_px) {
  std::vector<scenes::KittiFolder::Point> points;
  const auto depth = static_cast<float>(50 / (5 + off_px));
  for (int v = 0; v < scenes::KittiFolder::kHeight; v += 2) {
    for (int u = 0; u < scenes::KittiFolder::kWidth; u += 2) {
      points.push_back({depth, depth * static_cast<float>(20 - u) / 100,
                        depth * static_cast<float>(15 - v) / 100, 0});
    }
  }
  folder.WriteScan(id, points);
}

Scene ScannedWall(double off_px) {
  const scenes::KittiFolder folder("000007");
  WriteWall(folder, "000007", off_px);
  return LoadScene(folder.Config("/000007").source(), TofChoice("scan"), {});
}

TEST(TruthCheck, NamesAScanThatIsNotWhereTheTruthIs) {
  EXPECT_EQ(WrongTruthText(ScannedWall(0.8)), "");
  EXPECT_THAT(WrongTruthText(ScannedWall(1.2)), StartsWith("0 % of the scan's points"));
}

TEST(TruthCheck, NamesTheTruthOfAVideoToo) {
  const auto said = [](double off_px) {
    const scenes::KittiFolder folder;
    for (const char* id : {"000000", "000001", "000002"}) {
      folder.WriteStereo(id);
      WriteWall(folder, id, off_px);
    }
    VideoSettings settings;
    settings.config = LoadConfig({"fast"});
    return EvaluateVideo(folder.Config("").source(), settings, [](int) {}).wrong_inputs;
  };
  EXPECT_EQ(said(0.8), "");
  EXPECT_THAT(said(1.2), StartsWith("0 % of the scan's points"));
}

}  // namespace
}  // namespace sprout::evaluate
