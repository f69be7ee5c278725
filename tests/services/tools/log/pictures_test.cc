#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "common/picture/write_image.h"
#include "common/scenes/pfm.h"
#include "services/tools/log/log_frames.h"
#include "tests/common/scenes/kitti_folder.h"
#include "tests/services/tools/log/graph_log.h"

// images and export.
namespace sprout::log {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename());
  }
  return names;
}

class LogImages : public TestWithLogs {};

TEST_F(LogImages, WritesEveryPartOfTheFramesAsked) {
  const auto log = folder_.Write("log", GraphEvents(30));
  const std::string out = OutOf({"images", log, folder_.File("out"), "--frames", "4:5"});
  EXPECT_THAT(out, HasSubstr("18 files of 2 frames\n"));
  EXPECT_THAT(
      FilesIn(folder_.File("out")),
      UnorderedElementsAre("000004_left.png", "000004_right.png", "000004_tof.png",
                           "000004_seeds.png", "000004_prior.png", "000004_prior_sigma.png",
                           "000004_disparity.png", "000005_left.png", "000005_right.png",
                           "000005_tof.png", "000005_seeds.png", "000005_prior.png",
                           "000005_prior_sigma.png", "000005_disparity.png", "000004_cloud.png",
                           "000004_overview.png", "000005_cloud.png", "000005_overview.png"));
  const cv::Mat left = cv::imread(folder_.File("out") + "/000004_left.png");
  ASSERT_FALSE(left.empty());
  EXPECT_GE(left.cols, kLogImageSize.width);
}

// The maps of GraphEvents() are 7/8 full; a scene of another size cannot be their truth.
TEST_F(LogImages, TellsDensityAndRefusesTheTruthOfAnotherScene) {
  const auto log = folder_.Write("log", GraphEvents(3));
  const MainOutcome outcome = RunLog({"images", log, folder_.File("out")});
  EXPECT_THAT(outcome.out, ContainsRegex("filled +3 +87.50\n"));
  ExpectRefused({"images", log, folder_.File("other"), "--truth", "synthetic:64x48"},
                "--truth synthetic:64x48: ");
  ExpectRefused({"images", log, folder_.File("other"), "--truth", "synthetic:32x24"},
                "--truth synthetic:32x24: frame 0 of the log is another picture");
  ExpectRefused({"images", log, folder_.File("other"), "--truth", "nonsense"}, "nonsense");
}

// The map is wrong in the upper half, which the right camera does not see.
TEST_F(LogImages, CountsThePixelsThatBothCamerasSeeAsTheDataSetSays) {
  const scenes::KittiFolder truth("000007");
  cv::Mat1w seen(30, 40, uint16_t{5 * 256});
  seen.rowRange(0, 15) = 0;
  truth.WriteTruth("disp_noc_0/000007_10.png", seen);
  cv::Mat1f map_px(30, 40, 5.F);
  map_px.rowRange(0, 15) = 9;
  const auto log = folder_.Write("log", {PartEvent(Part::kDisparity, 0, FromPx(map_px))});
  const std::string out =
      OutOf({"images", log, folder_.File("out"), "--truth", "kitti:" + truth.place() + "/000007"});
  EXPECT_THAT(out, ContainsRegex("filled +1 +100.00 +100.00\n"));
}

TEST_F(LogImages, ShowsThePointsOfAToFImageThatFitsTheCalibration) {
  Rig rig = std::get<Rig>(LogValue(Part::kRig, 1));
  const TofImage tof = std::get<TofImage>(LogValue(Part::kTof, 1));
  rig.tof.width = tof.depth_m.cols;
  rig.tof.height = tof.depth_m.rows;
  rig.tof.fx = rig.tof.fy = 3;
  rig.tof.cx = 1;
  rig.tof.cy = 0.5;
  const auto log = folder_.Write(
      "log", {PartEvent(Part::kRig, 1, rig), PartEvent(Part::kLeft, 1), PartEvent(Part::kTof, 1)});
  EXPECT_EQ(RunLog({"images", log, folder_.File("out")}).exit_code, 0);
  EXPECT_THAT(FilesIn(folder_.File("out")),
              UnorderedElementsAre("000001_left.png", "000001_tof.png", "000001_seeds_raw.png"));
}

TEST_F(LogImages, ShowsWhatALogOfOneStageHas) {
  const auto log = folder_.Write(
      "log", {PartEvent(Part::kSeeds, 3), PartEvent(Part::kUnfilled, 3), PartEvent(Part::kRig, 8)});
  EXPECT_EQ(RunLog({"images", log, folder_.File("out")}).exit_code, 0);
  EXPECT_THAT(FilesIn(folder_.File("out")),
              UnorderedElementsAre("000003_seeds.png", "000003_unfilled.png"));
}

TEST_F(LogImages, TakesTheSizeFromWhatIsThereBeforeTheCalibration) {
  Rig huge = std::get<Rig>(LogValue(Part::kRig, 1));
  huge.pair.width = huge.pair.height = 10'000;
  const auto log = folder_.Write("log", {PartEvent(Part::kRig, 1, huge), PartEvent(Part::kSeeds, 1),
                                         PartEvent(Part::kTof, 1), PartEvent(Part::kPrior, 1)});
  EXPECT_EQ(RunLog({"images", log, folder_.File("out")}).exit_code, 0);
  for (const char* name : {"seeds", "tof"}) {
    const cv::Mat picture = cv::imread(folder_.File("out") + "/000001_" + name + ".png");
    EXPECT_GE(picture.cols, kLogImageSize.width) << name;
    EXPECT_LT(picture.cols, 1000) << name;
  }
}

TEST_F(LogImages, KeepsFramesOfOneNumberApart) {
  Event again = PartEvent(Part::kLeft, 3);
  FrameId id = LogFrameId(3);
  id.utime += 5;
  again.data = EncodePart(id, Part::kLeft, LogValue(Part::kLeft, 3), DisparityEncoding::kRawInt16);
  const auto log = folder_.Write("log", {PartEvent(Part::kLeft, 3), again});
  EXPECT_THAT(OutOf({"images", log, folder_.File("out")}), HasSubstr("2 files of 2 frames"));
  EXPECT_THAT(FilesIn(folder_.File("out")),
              UnorderedElementsAre("000003_left.png", "000003_1700000000300005_left.png"));
}

TEST_F(LogImages, GoesOnBehindAnUndecodableMessage) {
  auto events = GraphEvents(3);
  EventOf(events, Part::kLeft, 1).data.pop_back();
  const auto log = folder_.Write("log", events);
  const MainOutcome outcome = RunLog({"images", log, folder_.File("out")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("24 files of 3 frames"));
  EXPECT_THAT(outcome.err, HasSubstr("undecodable messages: 1, the first SPROUT_LEFT, event "));
}

TEST_F(LogImages, RefusesWhatHasNothingToShow) {
  const auto log = folder_.Write("log", GraphEvents(3));
  ExpectRefused({"images", log, folder_.File("out"), "--frames", "9"},
                "no message of these frames");
  ExpectRefused({"images", log, folder_.File("out"), "--channel-prefix", "TWO_"},
                "there are channels as SPROUT_");
  ExpectRefused({"images", log, log + "/out"}, "cannot be written");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

class LogExport : public TestWithLogs {};

TEST_F(LogExport, WritesTheMapsAsPfm) {
  const auto log = folder_.Write("log", GraphEvents(30));
  ASSERT_EQ(RunLog({"export", log, folder_.File("out"), "--pfm", "--frames", "7"}).exit_code, 0);
  EXPECT_THAT(FilesIn(folder_.File("out")),
              UnorderedElementsAre("000007_prior.pfm", "000007_disparity.pfm"));
  const cv::Mat1f px = scenes::ReadPfm(folder_.File("out") + "/000007_disparity.pfm");
  ASSERT_EQ(px.size(), kLogImageSize);
  EXPECT_EQ(px(3, 8), LogDisparity(7).Px(8, 3));
  EXPECT_TRUE(std::isinf(px(3, 0)));
}

TEST_F(LogExport, WritesTheStandardDeviationsInPx) {
  cv::Mat1b sigma(kLogImageSize, uint8_t{24});
  sigma(2, 5) = kMaxSigmaCounts;
  const auto log = folder_.Write(
      "log", {PartEvent(Part::kDisparity, 7), PartEvent(Part::kSigma, 7, cv::Mat(sigma))});
  ASSERT_EQ(RunLog({"export", log, folder_.File("out"), "--pfm"}).exit_code, 0);
  const cv::Mat1f px = scenes::ReadPfm(folder_.File("out") + "/000007_sigma.pfm");
  ASSERT_EQ(px.size(), kLogImageSize);
  EXPECT_EQ(px(3, 8), 1.5F);
  EXPECT_TRUE(std::isinf(px(2, 5)));
  ASSERT_EQ(RunLog({"images", log, folder_.File("pictures")}).exit_code, 0);
  EXPECT_THAT(FilesIn(folder_.File("pictures")),
              UnorderedElementsAre("000007_disparity.png", "000007_sigma.png"));
}

TEST_F(LogExport, WritesCloudsWithACalibrationFromAnywhere) {
  auto events = GraphEvents(30);
  Erase(events, Part::kRig, 1);
  Erase(events, Part::kRig, 11);  // the one left comes when the first frames are long written
  const auto log = folder_.Write("log", events);
  ASSERT_EQ(RunLog({"export", log, folder_.File("out"), "--ply"}).exit_code, 0);
  EXPECT_EQ(FilesIn(folder_.File("out")).size(), 30U);
  const Bytes ply = ReadBytes(folder_.File("out") + "/000000_cloud.ply");
  ASSERT_GT(ply.size(), 1000U);
  const std::string head(ply.begin(), ply.begin() + 200);
  EXPECT_THAT(head, HasSubstr("element vertex 672\n"));  // 28 × 24
}

TEST_F(LogExport, SaysWhichCloudsItCannotMake) {
  auto events = GraphEvents(3);
  Erase(events, Part::kLeft, 1);
  const auto log = folder_.Write("log", events);
  const MainOutcome outcome = RunLog({"export", log, folder_.File("out"), "--ply"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("no cloud of 1 frames"));
  EXPECT_EQ(FilesIn(folder_.File("out")).size(), 2U);
}

TEST_F(LogExport, GoesOnBehindAFrameOfOtherSizes) {
  auto events = GraphEvents(3);
  EventOf(events, Part::kLeft, 1) = PartEvent(Part::kLeft, 1, cv::Mat(9, 9, CV_8UC1, cv::Scalar()));
  const auto log = folder_.Write("log", events);
  const MainOutcome outcome = RunLog({"export", log, folder_.File("out"), "--ply"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no cloud of frame 1: disparity map 32x24, left image 9x9"));
  EXPECT_THAT(outcome.out, HasSubstr("2 files of 2 frames"));
}

TEST_F(LogImages, ShowsFramesWithoutATofCamera) {
  const TofImage none;
  const auto log = folder_.Write("log", {PartEvent(Part::kLeft, 1), PartEvent(Part::kTof, 1, none),
                                         PartEvent(Part::kTof, 2, none), PartEvent(Part::kRight, 2),
                                         PartEvent(Part::kTof, 3, none)});
  EXPECT_THAT(OutOf({"images", log, folder_.File("out")}), HasSubstr("4 files of 2 frames"));
}

TEST_F(LogExport, WritesSurfaces) {
  const auto log = folder_.Write("log", GraphEvents(2));  // the calibration comes with frame 1
  EXPECT_EQ(RunLog({"export", log, folder_.File("out"), "--mesh"}).exit_code, 0);
  EXPECT_THAT(FilesIn(folder_.File("out")),
              UnorderedElementsAre("000000_mesh.ply", "000001_mesh.ply"));
  EXPECT_THAT(FileText(folder_.File("out") + "/000001_mesh.ply"),
              ContainsRegex("element face [1-9]"));
}

TEST_F(LogExport, WritesDepthsInMillimetresAndTheIntrinsics) {
  const auto log = folder_.Write("log", GraphEvents(2));
  const std::string out = folder_.File("out");
  ASSERT_EQ(RunLog({"export", log, out, "--depth"}).exit_code, 0);
  EXPECT_THAT(FilesIn(out),
              UnorderedElementsAre("000000_depth.png", "000001_depth.png", "intrinsics.json"));
  const cv::Mat mm = cv::imread(out + "/000001_depth.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(mm.type(), CV_16UC1);
  const RectifiedPair pair = LogRig().pair;
  const double metres = pair.DepthFromDisparity(double{LogDisparity(1).Px(8, 3)});
  ASSERT_LT(metres, kMaxPngDepthM);
  EXPECT_NEAR(mm.at<uint16_t>(3, 8), metres * 1000, 0.5);
  EXPECT_EQ(mm.at<uint16_t>(3, 0), 0);
  std::ifstream file(out + "/intrinsics.json");
  const nlohmann::json json = nlohmann::json::parse(file);
  EXPECT_EQ(json["fx"], pair.focal_px);
  EXPECT_EQ(json["cx"], pair.cx);
  EXPECT_EQ(json["cy"], pair.cy);
  EXPECT_EQ(json["baseline_m"], pair.baseline_m);
  EXPECT_EQ(json["width"], pair.width);
}

TEST_F(LogExport, WritesDepthOfALogThatHasOnlyThat) {
  const auto log = folder_.Write("log", {PartEvent(Part::kDepth, 1), PartEvent(Part::kLeft, 2)});
  const MainOutcome outcome = RunLog({"export", log, folder_.File("out"), "--depth"});
  EXPECT_EQ(outcome.exit_code, 0);
  const DepthImage depth = examples::Depth();
  const cv::Mat mm = cv::imread(folder_.File("out") + "/000001_depth.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(mm.size(), depth.size());
  for (int v = 0; v < mm.rows; ++v) {
    for (int u = 0; u < mm.cols; ++u) {
      const double metres = depth.Metres(u, v);
      EXPECT_NEAR(mm.at<uint16_t>(v, u), metres <= kMaxPngDepthM ? metres * 1000 : 0, 0.51);
    }
  }
}

TEST_F(LogExport, GivesCloudsTheConfidenceOfEachPoint) {
  const cv::Mat confidence(kLogImageSize, CV_8UC1, cv::Scalar(77));
  auto events = GraphEvents(2);
  events.push_back(PartEvent(Part::kConfidence, 1, confidence));
  const auto log = folder_.Write("log", events);
  ASSERT_EQ(RunLog({"export", log, folder_.File("out"), "--ply"}).exit_code, 0);
  const Bytes with = ReadBytes(folder_.File("out") + "/000001_cloud.ply");
  const Bytes without = ReadBytes(folder_.File("out") + "/000000_cloud.ply");
  EXPECT_THAT(std::string(with.begin(), with.begin() + 400),
              HasSubstr("property uchar confidence\nend_header\n"));
  EXPECT_EQ(with.back(), 77);
  EXPECT_THAT(std::string(without.begin(), without.begin() + 400),
              testing::Not(HasSubstr("confidence")));
}

// The program that reads the frames prints the damage, with its own name in front.
TEST_F(LogImages, DamageIsSaidByWhoReadsTheFrames) {
  auto events = GraphEvents(3);
  Bytes bytes = MakeLog(events);
  bytes.resize(bytes.size() - 5);
  const auto log = folder_.File("log");
  WriteBytes(log, bytes);
  testing::internal::CaptureStderr();
  const std::string complaint = ReadFrames({.file = log, .folder = {}, .frames = {}, .prefix = {}},
                                           AllParts(), [](const Frame&) {});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_THAT(complaint, HasSubstr("log is damaged in 1 place, "));
}

TEST_F(LogImages, RefusesTwoAnswersForOneFrame) {
  auto events = GraphEvents(3);
  events.push_back(PartEvent(Part::kDisparity, 1, LogDisparity(5)));
  const auto log = folder_.Write("log", events);
  ExpectRefused({"images", log, folder_.File("out")}, "two answers for frame 1: SPROUT_DISPARITY");
  ExpectRefused({"export", log, folder_.File("out2"), "--pfm"}, "sprout-log merge --replace");
  ExpectRefused({"rank", log}, "two answers");
}

TEST_F(LogExport, RefusesToDoNothing) {
  const auto log = folder_.Write("log", GraphEvents(3));
  ExpectRefused({"export", log, folder_.File("out")}, "--ply, --mesh, --pfm, --depth or --npz");
  ExpectRefused(
      {"export", folder_.Write("raw", {PartEvent(Part::kLeft, 1)}), folder_.File("out"), "--pfm"},
      "no message of these frames");
}

}  // namespace
}  // namespace sprout::log
