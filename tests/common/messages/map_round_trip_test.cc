#include <gmock/gmock.h>

#include <random>

#include "tests/common/messages/round_trip.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

TEST(DisparityMessage, CarriesExtremeCountsInEveryEncoding) {
  for (const DisparityEncoding encoding : examples::kEncodings) {
    ExpectSamePixels(RoundTrip(Part::kUnfilled, examples::Disparity(), encoding).counts(),
                     examples::Disparity().counts());
  }
}

TEST(DisparityMessage, CarriesAViewIntoALargerMapInEveryEncoding) {
  cv::Mat1s whole(20, 30);
  std::mt19937 random(4);
  for (int16_t& count : whole) count = static_cast<int16_t>(random());
  const DisparityImage view(cv::Mat1s(whole(cv::Rect(3, 2, 11, 13))));
  ASSERT_FALSE(view.counts().isContinuous());
  for (const DisparityEncoding encoding : examples::kEncodings) {
    ExpectSamePixels(RoundTrip(Part::kDisparity, view, encoding).counts(), view.counts());
  }
}

TEST(DisparityMessage, CarriesMapsOfManySizesInEveryEncoding) {
  std::mt19937 random(5);
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(1, 50), cv::Size(50, 1), cv::Size(333, 77)}) {
    DisparityImage disparity(size);
    for (int16_t& count : disparity.counts()) count = static_cast<int16_t>(random());
    for (const DisparityEncoding encoding : examples::kEncodings) {
      ExpectSamePixels(RoundTrip(Part::kUnfilled, disparity, encoding).counts(),
                       disparity.counts());
    }
  }
}

TEST(DisparityMessage, CarriesALargeEmptyMapInAFewBytes) {
  const DisparityImage empty(cv::Size(2000, 1500));  // compresses as far as the format can
  const auto bytes =
      EncodePart(examples::Id(), Part::kDisparity, empty, DisparityEncoding::kDeltaZstd);
  EXPECT_LT(bytes.size(), 10000U);
  ExpectSamePixels(RoundTrip(Part::kDisparity, empty, DisparityEncoding::kDeltaZstd).counts(),
                   empty.counts());
}

TEST(DisparityMessage, IsLittleEndianOnTheWire) {
  const disparity_image_t message =
      ToMessage(examples::Id(), DisparityImage(cv::Mat1s(1, 1, int16_t{0x0102})),
                DisparityEncoding::kRawInt16);
  EXPECT_EQ(message.data, (std::vector<uint8_t>{0x02, 0x01}));
}

void ExpectSamePrior(const PriorMap& actual, const PriorMap& expected) {
  ExpectSamePixels(actual.disparity.counts(), expected.disparity.counts());
  ExpectSamePixels(actual.sigma, expected.sigma);
}

TEST(DepthMessage, CarriesDepthAndIntrinsics) {
  const DepthImage sent = examples::Depth();
  const DepthImage depth = RoundTrip(Part::kDepth, sent);
  ExpectSamePixels(depth.counts, sent.counts);
  EXPECT_EQ(depth.metres_per_count, sent.metres_per_count);
  EXPECT_EQ(depth.focal_px, sent.focal_px);
  EXPECT_EQ(depth.cx, sent.cx);
  EXPECT_EQ(depth.cy, sent.cy);
}

TEST(DepthMessage, HasTheBytesThatItsTypeSays) {
  const depth_image_t message = ToMessage(examples::Id(), examples::Depth());
  EXPECT_EQ(message.depth, (std::vector<uint8_t>{0, 0, 1, 0, 255, 0, 0, 1, 254, 255, 255, 255}));
}

TEST(CloudMessage, CarriesEveryPoint) {
  EXPECT_EQ(RoundTrip(Part::kCloud, examples::Cloud()), examples::Cloud());
  EXPECT_EQ(RoundTrip(Part::kCloud, PointCloud()), PointCloud());
}

TEST(DepthMessage, IsRefusedWhenItsFieldsDoNotFit) {
  const auto error = [](const auto& change) {
    depth_image_t message = ToMessage(examples::Id(), examples::Depth());
    change(message);
    return FromMessage(message, message.depth).error().text;
  };
  EXPECT_THAT(error([](auto& m) { m.width = 0; }), HasSubstr("width = 0"));
  EXPECT_THAT(error([](auto& m) { m.height = 3; }), HasSubstr("size = 12"));
  EXPECT_THAT(error([](auto& m) { m.focal_px = 0; }), HasSubstr("focal_px = 0"));
  EXPECT_THAT(error([](auto& m) { m.metres_per_count = -1; }), HasSubstr("metres_per_count = -1"));
  EXPECT_THAT(error([](auto& m) { m.depth.pop_back(); }), HasSubstr("size = 12"));
}

TEST(CloudMessage, IsRefusedWhenItsFieldsDoNotFit) {
  const auto error = [](const auto& change) {
    point_cloud_t message = ToMessage(examples::Id(), examples::Cloud());
    change(message);
    return FromMessage(message).error().text;
  };
  EXPECT_THAT(error([](auto& m) { m.count = -1; }), HasSubstr("count = -1"));
  EXPECT_THAT(error([](auto& m) { m.red.pop_back(); }), HasSubstr("the number of colours"));
  EXPECT_THAT(error([](auto& m) { m.y.pop_back(); }), HasSubstr("the number of coordinates"));
  EXPECT_THAT(error([](auto& m) { m.x[1] = NAN; }), HasSubstr("point 1 at (nan"));
}

TEST(CloudMessage, MayHavePointsBehindTheOriginOnlyInTheRobotsFrame) {
  PointCloud cloud = examples::Cloud();
  cloud.points[0].position_m.z = -2;
  EXPECT_EQ(RoundTrip(Part::kBaseCloud, cloud), cloud);
  for (const Part part : {Part::kCloud, Part::kTargetCloud}) {
    const auto bytes = EncodePart(examples::Id(), part, cloud);
    EXPECT_THAT(DecodePart(part, bytes).error().text, HasSubstr("point 0 at"));
  }
}

TEST(DepthCountsMessage, CarriesAll) {
  EXPECT_EQ(RoundTrip(Part::kDepthCounts, examples::Counts()), examples::Counts());
}

TEST(DepthCountsMessage, IsRefusedWithCountsThatCannotBe) {
  const auto error = [](const auto& change) {
    depth_counts_t message = ToMessage(examples::Id(), examples::Counts());
    change(message);
    return FromMessage(message).error().text;
  };
  EXPECT_THAT(error([](auto& m) { m.pixels = 365; }),
              HasSubstr("pixels = 365: allowed is at least the pixels left out, 366"));
  EXPECT_THAT(error([](auto& m) { m.flying = -1; }), HasSubstr("flying = -1"));
}

TEST(PriorMessage, CarriesDisparitiesAndHowSureTheyAreInEveryEncoding) {
  for (const DisparityEncoding encoding : examples::kEncodings) {
    ExpectSamePrior(RoundTrip(Part::kPrior, examples::Prior(), encoding), examples::Prior());
  }
}

TEST(PriorMessage, CarriesViewsIntoLargerMapsInEveryEncoding) {
  std::mt19937 random(7);
  PriorMap whole(cv::Size(30, 20));
  for (int16_t& count : whole.disparity.counts()) count = static_cast<int16_t>(random() % 30000);
  for (uint8_t& count : whole.sigma) count = static_cast<uint8_t>(1 + random() % 255);
  const cv::Rect part(3, 2, 11, 13);
  const PriorMap view(DisparityImage(cv::Mat1s(whole.disparity.counts()(part))),
                      cv::Mat1b(whole.sigma(part)));
  ASSERT_FALSE(view.sigma.isContinuous());
  for (const DisparityEncoding encoding : examples::kEncodings) {
    ExpectSamePrior(RoundTrip(Part::kPrior, view, encoding), view);
  }
}

TEST(PriorMessage, CarriesALargeEmptyPriorInAFewBytes) {
  const PriorMap empty(cv::Size(2000, 1500));
  const auto bytes = EncodePart(examples::Id(), Part::kPrior, empty, DisparityEncoding::kDeltaZstd);
  EXPECT_LT(bytes.size(), 15000U);
  ExpectSamePrior(RoundTrip(Part::kPrior, empty, DisparityEncoding::kDeltaZstd), empty);
}

TEST(PriorMessage, HasTheBytesThatItsTypeSays) {
  const PriorMap prior(DisparityImage(cv::Mat1s(1, 2, int16_t{0x0102})),
                       (cv::Mat1b(1, 2) << 16, 20));
  const prior_t message = ToMessage(examples::Id(), prior, DisparityEncoding::kRawInt16);
  EXPECT_EQ(message.data, (std::vector<uint8_t>{0x02, 0x01, 0x02, 0x01}));
  EXPECT_EQ(message.sigma, (std::vector<uint8_t>{16, 20}));
  EXPECT_EQ(message.sigma_counts_per_px, 16);
}

}  // namespace
}  // namespace sprout
