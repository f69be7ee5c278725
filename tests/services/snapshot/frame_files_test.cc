#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "common/picture/color_map.h"
#include "services/snapshot/snapshot.h"
#include "tests/common/core/even_prior.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout::snapshot {
namespace {

using ::testing::HasSubstr;

constexpr int kFiles = 14;
// Not divisible by three, neither side nor product.
const cv::Size kSize(64, 40);

DisparityImage Map(cv::Size size) {
  DisparityImage map(size);
  map.counts() = ToCounts(5);
  return map;
}

/// A whole frame: a wall.
Frame Wall(const cv::Mat& left) {
  Frame frame;
  frame.id = {.utime = 1, .seq = 2, .rig_id = "wall"};
  frame.left = left;
  frame.right = left;
  frame.tof = TofImage{.depth_m = cv::Mat1f(6, 8, 1.F), .amplitude = {}};
  frame.rig = Rig{.pair = {.width = left.cols,
                           .height = left.rows,
                           .focal_px = 50,
                           .cx = 32,
                           .cy = 20,
                           .cx_right = 32,
                           .baseline_m = 0.1},
                  .tof = {.width = 8, .height = 6, .fx = 6, .fy = 6, .cx = 4, .cy = 3}};
  frame.seeds = SeedSet{.seeds = {{.u = 12, .v = 7, .u_right = 7}}, .raw = 48};
  frame.left_seeds = SeedSet{};
  frame.prior = EvenPrior(Map(left.size()), 1);
  frame.unfilled = Map(left.size());
  frame.disparity = Map(left.size());
  frame.confidence = cv::Mat1b(left.size(), uchar{200});
  return frame;
}

TEST(WriteFrameFiles, TakesAGreyAndAColourLeftImage) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const TemporaryDirectory directory;
    const auto written =
        WriteFrameFiles(Wall(cv::Mat(kSize, type, cv::Scalar::all(90))), {}, directory / "");
    ASSERT_TRUE(written) << written.error().text;
    EXPECT_EQ(directory.CountEntries(), kFiles);
  }
}

// The bytes of a file up to the end of its header, as text.
std::string PlyHeader(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string header;
  for (std::string line; std::getline(file, line) && line != "end_header";) header += line + "\n";
  return header;
}

TEST(WriteFrameFiles, ShowsWhatIsInTheFrame) {
  const TemporaryDirectory directory;
  Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
  frame.disparity->counts().rowRange(0, 10) = DisparityImage::kInvalid;
  frame.unfilled->counts().colRange(30, kSize.width) = DisparityImage::kInvalid;
  ASSERT_TRUE(WriteFrameFiles(frame, {}, directory / ""));

  const cv::Mat1f px = cv::imread((directory / "disparity.pfm").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(px.size(), kSize);
  EXPECT_EQ(cv::countNonZero(px == 5), 30 * 64);
  EXPECT_EQ(px(0, 0), std::numeric_limits<float>::infinity());
  EXPECT_THAT(PlyHeader(directory / "cloud.ply"), HasSubstr("element vertex 1920\n"));
  EXPECT_THAT(PlyHeader(directory / "mesh.ply"), HasSubstr("element face "));

  const auto picture = [&](const char* name) { return cv::imread((directory / name).string()); };
  for (const char* name : {"left.png", "seeds_raw.png", "seeds.png", "prior.png", "prior_sigma.png",
                           "disparity.png", "disparity_filled.png", "confidence.png"}) {
    EXPECT_GE(picture(name).cols, kSize.width) << name;
  }
  EXPECT_GT(cv::norm(picture("disparity.png"), picture("disparity_filled.png")), 0);
  EXPECT_GT(cv::norm(picture("seeds.png"), picture("seeds_raw.png")), 0);
  EXPECT_GE(picture("overview.png").rows, 2 * kSize.height);
}

TEST(WriteFrameFiles, TakesAToFImageWithoutAReturn) {
  for (const float code : {std::numeric_limits<float>::quiet_NaN(), 1e20F, 3.4e38F}) {
    const TemporaryDirectory directory;
    Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
    frame.tof->depth_m = code;
    const auto written = WriteFrameFiles(frame, {}, directory / "");
    ASSERT_TRUE(written) << written.error().text;
    EXPECT_EQ(directory.CountEntries(), kFiles);
  }
}

TEST(WriteFrameFiles, TakesAFrameWithoutATofCamera) {
  const TemporaryDirectory directory;
  Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
  frame.rig->tof = {};
  frame.tof = TofImage{};
  const auto written = WriteFrameFiles(frame, {}, directory / "");
  ASSERT_TRUE(written) << written.error().text;
  EXPECT_EQ(directory.CountEntries(), kFiles);
}

TEST(WriteFrameFiles, TakesAFrameWhoseTofCameraSentNoImage) {
  const TemporaryDirectory directory;
  Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
  frame.rig->tof.width = frame.rig->tof.height = 10000;  // rays would take gigabytes
  frame.tof = TofImage{};
  const auto written = WriteFrameFiles(frame, {}, directory / "");
  ASSERT_TRUE(written) << written.error().text;
  EXPECT_EQ(directory.CountEntries(), kFiles);
}

TEST(WriteFrameFiles, LeavesOutWhatAGrowerDoesNotSayAndNamesIt) {
  const TemporaryDirectory directory;
  Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
  EXPECT_THAT(MissingParts(frame), testing::IsEmpty());
  frame.unfilled.reset();
  frame.confidence = cv::Mat();
  const auto written = WriteFrameFiles(frame, {}, directory / "");
  ASSERT_TRUE(written) << written.error().text;
  EXPECT_EQ(directory.CountEntries(), kFiles - 2);
  EXPECT_THAT(MissingParts(frame), testing::ElementsAre(HasSubstr("no SPROUT_UNFILLED"),
                                                        HasSubstr("no SPROUT_CONFIDENCE")));
}

TEST(WriteFrameFiles, PaintsTheErrorsWhereTheTruthIsKnown) {
  const TemporaryDirectory directory;
  const Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
  datasets::GroundTruth truth;
  truth.left = cv::Mat1f(kSize, 7.F);
  truth.left.rowRange(0, 20) = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(WriteFrameFiles(frame, truth, directory / ""));
  const cv::Mat3b errors = cv::imread((directory / "errors.png").string());
  const auto count = [&](const cv::Vec3b& color) {
    return std::count(errors.begin(), errors.end(), color);
  };
  EXPECT_GE(count(ColorOf(2, {0, 4})), 20 * (64 - 7));  // the map has 5 px everywhere
  EXPECT_GE(count(kNoValueColor), 20 * 64);
}

TEST(WriteFrameFiles, GivesNearAndFarTheSameColorsInToFAndDisparityPictures) {
  const TemporaryDirectory directory;
  Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
  frame.disparity->counts().colRange(0, 32) = ToCounts(10);
  for (DisparityImage* map : {&frame.prior->disparity, &*frame.unfilled}) {
    map->counts() = frame.disparity->counts().clone();
  }
  const RectifiedPair& pair = frame.rig->pair;
  frame.tof->depth_m = static_cast<float>(pair.DepthFromDisparity(5));
  frame.tof->depth_m.colRange(0, 4) = static_cast<float>(pair.DepthFromDisparity(10));
  ASSERT_TRUE(WriteFrameFiles(frame, {}, directory / ""));
  const cv::Mat3b tof = cv::imread((directory / "tof.png").string());
  const cv::Mat3b disparity = cv::imread((directory / "disparity_filled.png").string());
  for (const double px : {5, 10}) {
    const cv::Vec3b color = ColorOf(px, {5, 10});
    for (const cv::Mat3b& picture : {tof, disparity}) {
      EXPECT_GE(std::count(picture.begin(), picture.end(), color), 900) << px;
    }
  }
}

struct Misfit {
  const char* expected;
  std::function<void(Frame&)> spoil;
};

TEST(WriteFrameFiles, RefusesImagesThatDoNotFitTheCalibration) {
  const cv::Size other(63, 41);
  const std::vector<Misfit> table = {
      {"ToF image of 300x6: allowed is the calibrated size 8x6",
       [](Frame& frame) { frame.tof->depth_m = cv::Mat1f(6, 300, 1.F); }},
      {"ToF image of 8x6: allowed is the calibrated size 16384x16384",
       [](Frame& frame) { frame.rig->tof.width = frame.rig->tof.height = 16384; }},
      {"left image of 63x41", [&](Frame& frame) { frame.left = cv::Mat1b(other); }},
      {"prior of 63x41", [&](Frame& frame) { frame.prior = PriorMap(other); }},
      {"unfilled map of 63x41", [&](Frame& frame) { frame.unfilled = Map(other); }},
      {"disparity map of 63x41", [&](Frame& frame) { frame.disparity = Map(other); }},
      {"confidence of 63x41", [&](Frame& frame) { frame.confidence = cv::Mat1b(other); }}};
  for (const Misfit& misfit : table) {
    SCOPED_TRACE(misfit.expected);
    const TemporaryDirectory directory;
    Frame frame = Wall(cv::Mat1b(kSize, uchar{90}));
    misfit.spoil(frame);
    const auto written = WriteFrameFiles(frame, {}, directory / "");
    ASSERT_FALSE(written);
    EXPECT_THAT(written.error().text, HasSubstr(misfit.expected));
    EXPECT_EQ(directory.CountEntries(), 0);
  }
}

}  // namespace
}  // namespace sprout::snapshot
