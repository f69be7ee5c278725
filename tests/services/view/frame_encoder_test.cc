#include "services/view/frame_encoder.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "services/view/points.h"
#include "tests/services/view/view_frames.h"

namespace sprout::view {
namespace {

// A packet taken apart as the page does it.
struct Packet {
  explicit Packet(const std::string& bytes) {
    uint32_t length = 0;
    std::memcpy(&length, bytes.data(), sizeof length);
    head = nlohmann::json::parse(bytes.substr(sizeof length, length));
    EXPECT_EQ((sizeof length + length) % 8, 0U);
    bodies = bytes.substr(sizeof length + length);
  }

  std::string Body(const std::string& name) const {
    for (const auto& part : head["parts"]) {
      if (part["name"] == name) return bodies.substr(part["offset"], part["size"]);
    }
    return "";
  }

  cv::Mat Picture(const std::string& name) const {
    const std::string body = Body(name);
    return cv::imdecode(std::vector<char>(body.begin(), body.end()), cv::IMREAD_UNCHANGED);
  }

  nlohmann::json head;
  std::string bodies;
};

class FrameEncoderTest : public ::testing::Test {
 protected:
  FrameEncoderTest() { AddWhole(input_, 100); }

  Packet Encode(const ShownParts& shown) {
    return Packet(encoder_.Encode(input_.ring.Newest(), shown, input_.ring.keys()));
  }

  RingInput input_;
  std::vector<std::string> complaints_;
  FrameEncoder encoder_{[this](Part, const std::string& why) { complaints_.push_back(why); }};
};

TEST_F(FrameEncoderTest, SendsWhatIsWishedAndThere) {
  const Packet packet = Encode(
      {.pictures = {{Picture::kLeft, 4096}, {Picture::kDisparity, 32}, {Picture::kPrior, 32}}});
  EXPECT_EQ(packet.head["seq"], 100);
  EXPECT_EQ(packet.head["parts"].size(), 2U);
  const cv::Mat left = packet.Picture("left");
  EXPECT_EQ(left.size(), kViewSize);
  EXPECT_NEAR(cv::mean(left)[0], 100, 2);
  EXPECT_EQ(packet.Picture("disparity").size(), cv::Size(32, 24));
  EXPECT_EQ(packet.head["parts"][1]["full_width"], 64);
}

// Both maps have one scale, so that only pixels that differ have other colours.
TEST_F(FrameEncoderTest, PaintsTheFusedMapOnTheScaleOfTheSingleOne) {
  DisparityImage fused = ViewMap();
  fused.counts()(10, 20) = DisparityImage::kInvalid;
  fused.counts()(10, 40) = ToCounts(7.5);
  input_.Add(100, Part::kFused, fused);
  const Packet packet = Encode({.pictures = {{Picture::kDisparity, 64},
                                             {Picture::kFused, 64},
                                             {Picture::kDepth, 64},
                                             {Picture::kFusedDepth, 64}}});
  ASSERT_EQ(packet.head["parts"].size(), 4U);
  for (const auto& [one, other] : {std::pair("disparity", "fused"), {"depth", "fused_depth"}}) {
    const cv::Mat single = packet.Picture(one), with_memory = packet.Picture(other);
    EXPECT_EQ(cv::norm(single.rowRange(24, 48), with_memory.rowRange(24, 48), cv::NORM_INF), 0);
    EXPECT_GT(cv::norm(single.at<cv::Vec3b>(10, 20), with_memory.at<cv::Vec3b>(10, 20)), 30);
  }
  const nlohmann::json probe = encoder_.Probe(input_.ring.Newest(), 40, 10);
  EXPECT_EQ(probe["disparity_px"], 10);
  EXPECT_EQ(probe["fused_px"], 7.5);
  EXPECT_FALSE(encoder_.Probe(input_.ring.Newest(), 20, 10).contains("fused_px"));
}

// The calibration comes once a second, so the first frames may be without.
TEST_F(FrameEncoderTest, PaintsToFDepthsWithoutACalibration) {
  RingInput input;
  const cv::Mat1f depth_m(3, 4, 2.0F);
  input.Add(100, Part::kTof, TofImage{.depth_m = depth_m, .amplitude = {}});
  input.Add(100, Part::kDisparity, ViewMap());
  const Packet packet(
      encoder_.Encode(input.ring.Newest(), {.pictures = {{Picture::kTof, 4}}}, input.ring.keys()));
  const auto& scale = packet.head["scales"]["depth"];
  EXPECT_GT(scale["min"], 0);
  EXPECT_LT(scale["min"], 2);
  EXPECT_GT(scale["max"], 2);
}

TEST_F(FrameEncoderTest, PaintsNearAndFarAlikeInDisparityAndDepth) {
  const Packet packet = Encode({.pictures = {{Picture::kDisparity, 64}, {Picture::kDepth, 64}}});
  const auto& scales = packet.head["scales"];
  EXPECT_LT(scales["depth"]["min"], scales["depth"]["max"]);
  const cv::Vec3d near = ColorOf(1, {0, 1});
  const cv::Vec3d far = ColorOf(0, {0, 1});
  for (const char* name : {"disparity", "depth"}) {
    const cv::Mat picture = packet.Picture(name);
    const cv::Vec3d right = picture.at<cv::Vec3b>(24, 62);  // 15.5 px, 0.32 m
    EXPECT_LT(cv::norm(right - near), cv::norm(right - far)) << name;
    const cv::Vec3d left = picture.at<cv::Vec3b>(24, 2);  // 0.5 px, 10 m
    EXPECT_LT(cv::norm(left - far), cv::norm(left - near)) << name;
  }
}

TEST(FrameEncoderScales, GiveASurfaceOneColourInAllPictures) {
  RingInput input;
  input.Add(1, Part::kRig, ViewRig());
  input.Add(1, Part::kLeft, ViewImage(1));
  DisparityImage map(kViewSize);
  for (int u = 0; u < map.width(); ++u) map.counts().col(u) = ToCounts(10 + u / 4.0);
  input.Add(1, Part::kDisparity, map);
  FrameEncoder encoder([](Part, const std::string&) {});
  const auto scales =
      Packet(encoder.Encode(input.ring.Newest(), {}, input.ring.keys())).head["scales"];
  const RectifiedPair pair = ViewRig().pair;
  EXPECT_DOUBLE_EQ(scales["depth"]["min"], pair.DepthFromDisparity(scales["disparity"]["max"]));
  EXPECT_DOUBLE_EQ(scales["depth"]["max"], pair.DepthFromDisparity(scales["disparity"]["min"]));
}

// What a page that comes back in the middle of a frame gets.
TEST(FrameEncoderScales, BeginAboveZeroWhereNoDepthIsKnown) {
  FrameEncoder encoder([](Part, const std::string&) {});
  RingInput input;
  input.Add(1, Part::kLeft, ViewImage(1));
  input.Add(1, Part::kDisparity, ViewMap());
  const auto bare =
      Packet(encoder.Encode(input.ring.Newest(), {}, input.ring.keys())).head["scales"];
  EXPECT_GT(bare["depth"]["min"], 0);
  EXPECT_LT(bare["depth"]["min"], bare["depth"]["max"]);
}

TEST_F(FrameEncoderTest, SendsPointsWithoutLoss) {
  const Packet packet = Encode({.pictures = {}, .cloud = true});
  const auto& head = packet.head["parts"][0];
  EXPECT_EQ(head["columns"], 64);
  EXPECT_EQ(head["stride"], 1);
  EXPECT_DOUBLE_EQ(head["focal_px"], 50);
  const std::string body = packet.Body("cloud");
  ASSERT_EQ(body.size(), 64U * 48 * 5);  // without confidence
  std::vector<int16_t> counts(64 * 48);
  std::memcpy(counts.data(), body.data(), counts.size() * 2);
  EXPECT_EQ(counts[0], DisparityImage::kInvalid);
  EXPECT_EQ(counts[64 + 40], ToCounts(10));
  EXPECT_EQ(body.back(), 100);  // grey of the last pixel
}

TEST_F(FrameEncoderTest, ThinsAMapThatHasMorePixelsThanPointsAreShown) {
  const cv::Size size(1024, 768);
  Rig rig = ViewRig();
  rig.pair.width = size.width;
  rig.pair.height = size.height;
  rig.pair.focal_px = 800;
  RingInput large;
  large.Add(0, Part::kRig, rig);
  large.Add(0, Part::kLeft, cv::Mat(size, CV_8UC3, cv::Scalar(1, 2, 3)));
  large.Add(0, Part::kDisparity, DisparityImage(cv::Mat1s(size, int16_t{320})));
  DecodedFrame frame(large.ring.Newest(), [](Part, const std::string& why) { FAIL() << why; });
  const EncodedPartPtr cloud = EncodeCloud(frame);
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->head["stride"], 3);
  EXPECT_EQ(cloud->body.size(), 342U * 256 * 5);
  EXPECT_EQ(cloud->body.back(), 1);  // blue comes last
}

// As a page does whose window changes its size.
TEST(FrameEncoderCache, TakesNoMoreMemoryThanItMay) {
  RingInput input;
  const cv::Size size(800, 600);
  input.Add(0, Part::kLeft, cv::Mat(size, CV_8UC1, cv::Scalar(7)));
  FrameEncoder encoder([](Part, const std::string& why) { FAIL() << why; });
  const auto encode = [&](int width) {
    encoder.EncodePicture(input.ring.Newest(), Picture::kLeft, width);
  };
  encode(16);
  const size_t before = mallinfo2().uordblks;
  for (int width = 17; width <= size.width; width += 8) encode(width);
  // Even pictures take 2 to 3 KB, of which there are 98; libjpeg asks for up to 1 MB each.
  EXPECT_LT(mallinfo2().uordblks - before, size_t{4} << 20);
}

TEST(EncodedPart, CountsWhatItsHeadTakes) {
  FrameEncoder encoder([](Part, const std::string& why) { FAIL() << why; });
  RingInput input;
  AddWhole(input, 0);
  DecodedFrame frame(input.ring.Newest(), [](Part, const std::string& why) { FAIL() << why; });
  const EncodedPartPtr cloud = EncodeCloud(frame);
  const size_t before = mallinfo2().uordblks;
  const nlohmann::json copy = cloud->head;  // the largest that there is
  EXPECT_LT(mallinfo2().uordblks - before, EncodedPart::kHeadBytes);
  EXPECT_EQ(cloud->memory(), cloud->body.capacity() + EncodedPart::kHeadBytes);
}

TEST_F(FrameEncoderTest, SendsSeedsOfEveryOrigin) {
  input_.Add(100, Part::kLeftSeeds, SeedSet{.seeds = {{.u = 1, .v = 2, .u_right = -5}}});
  const Packet packet = Encode({.pictures = {}, .seeds = true});
  const auto& head = packet.head["parts"][0];
  EXPECT_EQ(head["tof"], 1);
  EXPECT_EQ(head["left_only"], 1);
  const std::string body = packet.Body("seeds");
  ASSERT_EQ(body.size(), 2U * 7);
  int16_t u = 0;
  std::memcpy(&u, body.data(), sizeof u);
  EXPECT_EQ(u, 10);
  EXPECT_EQ(body[13], 2);
}

TEST_F(FrameEncoderTest, TellsWhatIsKnownOfAPixel) {
  const nlohmann::json probe = encoder_.Probe(input_.ring.Newest(), 40, 20);
  EXPECT_DOUBLE_EQ(probe["disparity_px"], 10);
  EXPECT_DOUBLE_EQ(probe["depth_m"], 0.5);
  EXPECT_EQ(probe["grey"], 100);
  EXPECT_EQ(probe["seed"]["origin"], "ToF");
  EXPECT_DOUBLE_EQ(probe["seed"]["distance_px"], 30);
  EXPECT_FALSE(probe.contains("confidence"));
  EXPECT_FALSE(encoder_.Probe(input_.ring.Newest(), 0, 0).contains("disparity_px"));
  EXPECT_FALSE(encoder_.Probe(input_.ring.Newest(), 999, 999).contains("grey"));
}

TEST_F(FrameEncoderTest, ShowsHowSureTheDisparitiesAre) {
  cv::Mat1b sigma(kViewSize, uint8_t{64});  // 4 px: the end of the scale
  sigma.colRange(0, 32) = 1;
  input_.Add(100, Part::kSigma, cv::Mat(sigma));
  const Packet packet = Encode({.pictures = {{Picture::kDisparitySigma, 64}}});
  const cv::Mat picture = packet.Picture("disparity_sigma");
  ASSERT_EQ(picture.size(), kViewSize);
  const cv::Vec3d unsure = ColorOf(1, {0, 1});
  const cv::Vec3d sure = ColorOf(0, {0, 1});
  const cv::Vec3d right = picture.at<cv::Vec3b>(24, 60);
  const cv::Vec3d left = picture.at<cv::Vec3b>(24, 20);
  EXPECT_LT(cv::norm(right - unsure), cv::norm(right - sure));
  EXPECT_LT(cv::norm(left - sure), cv::norm(left - unsure));
  EXPECT_DOUBLE_EQ(packet.head["scales"]["sigma"]["max"], 4);
  EXPECT_DOUBLE_EQ(encoder_.Probe(input_.ring.Newest(), 40, 20)["disparity_sigma_px"], 4);
  EXPECT_FALSE(encoder_.Probe(input_.ring.Newest(), 0, 20).contains("disparity_sigma_px"));
}

TEST_F(FrameEncoderTest, ShowsNoStandardDeviationsOfAnotherSize) {
  input_.Add(100, Part::kSigma, cv::Mat(8, 8, CV_8UC1, cv::Scalar(9)));
  EXPECT_EQ(Encode({.pictures = {{Picture::kDisparitySigma, 64}}}).head["parts"].size(), 0U);
}

TEST_F(FrameEncoderTest, ComplainsOnceOfAPartThatCannotBeDecoded) {
  auto bytes = Encoded(100, Part::kConfidence, ViewImage(9));
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(input_.ring.Add(ChannelOf(Part::kConfidence), bytes, 0, input_.now));
  const Packet packet =
      Encode({.pictures = {{Picture::kConfidence, 64}, {Picture::kLeft, 64}}, .cloud = true});
  EXPECT_EQ(packet.head["parts"].size(), 2U);
  Encode({.pictures = {{Picture::kConfidence, 32}}});
  EXPECT_EQ(complaints_.size(), 1U);
}

TEST_F(FrameEncoderTest, MakesNoCloudOfWhatDoesNotFitTogether) {
  input_.Add(100, Part::kLeft, cv::Mat(cv::Size(32, 24), CV_8UC1, cv::Scalar(1)));
  EXPECT_TRUE(Encode({.pictures = {}, .cloud = true}).head["parts"].empty());
}

TEST(StableRange, MovesOnlyWhenItMust) {
  StableRange calm;
  EXPECT_EQ(calm.Follow({10, 50}), (ValueRange{10, 50}));
  EXPECT_EQ(calm.Follow({12, 51}), (ValueRange{10, 50}));
  EXPECT_EQ(calm.Follow({10, 60}), (ValueRange{10, 60}));
  EXPECT_EQ(calm.Follow({10, 20}), (ValueRange{10, 20}));
}

}  // namespace
}  // namespace sprout::view
