#include "services/tools/log/message_diff.h"

#include <gmock/gmock.h>

#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::HasSubstr;

Bytes Encoded(Part part, const PartValue& value,
              DisparityEncoding encoding = DisparityEncoding::kRawInt16) {
  return EncodePart(LogFrameId(1), part, value, encoding);
}

TEST(MessageDiff, DoesNotOverflowBetweenTheEndsOfTheScale) {
  const DisparityImage a(cv::Mat1s(1, 1, int16_t{32767}));
  const DisparityImage b(cv::Mat1s(1, 1, int16_t{-32767}));
  EXPECT_EQ(Compare(a, b).max_px, 65534.0 / 32);
}

TEST(MessageDiff, TakesAnotherEncodingOfTheSameMapForEqual) {
  for (const Part part : {Part::kPrior, Part::kDisparity}) {
    const Bytes raw = Encoded(part, LogValue(part, 1));
    const Bytes packed = Encoded(part, LogValue(part, 1), DisparityEncoding::kDeltaZstd);
    EXPECT_TRUE(Compare(raw, packed).equal);
    EXPECT_FALSE(Compare(Encoded(part, LogValue(part, 2)), packed).equal);
  }
}

TEST(MessageDiff, TakesAnotherOrderOfColoursForEqual) {
  const cv::Mat bgr = std::get<cv::Mat>(LogValue(Part::kLeft, 1));
  image_t message = ToMessage(LogFrameId(1), bgr);
  message.pixel_format = image_t::PIXEL_FORMAT_RGB3;
  for (size_t i = 0; i < message.data.size(); i += 3) {
    std::swap(message.data[i], message.data[i + 2]);
  }
  EXPECT_TRUE(Compare(Encoded(Part::kLeft, bgr), examples::Encode(message)).equal);
}

TEST(MessageDiff, NamesWhatDiffers) {
  const auto text = [](Part part, const PartValue& a, const PartValue& b) {
    const MessageDiff diff = Compare(Encoded(part, a), Encoded(part, b));
    EXPECT_FALSE(diff.equal);
    return diff.text;
  };
  cv::Mat image = std::get<cv::Mat>(LogValue(Part::kRight, 1)).clone();
  image.at<uint8_t>(3, 3) = 250;
  EXPECT_EQ(text(Part::kRight, LogValue(Part::kRight, 1), image),
            "1 of 768 pixels differ, by at most 240 grey levels");
  EXPECT_EQ(text(Part::kRight, image, LogValue(Part::kLeft, 1)),
            "32x24 in 1 colours and 32x24 in 3");
  SeedSet seeds = std::get<SeedSet>(LogValue(Part::kSeeds, 1));
  seeds.seeds[1].u += 1;
  EXPECT_EQ(text(Part::kSeeds, LogValue(Part::kSeeds, 1), seeds),
            "2 and 2 seeds, first difference at number 1");
  TofImage tof = examples::Tof(true);
  tof.depth_m(0, 0) += 1;
  EXPECT_EQ(text(Part::kTof, examples::Tof(true), tof), "1 of 6 depths differ");
  EXPECT_EQ(text(Part::kTof, examples::Tof(true), examples::Tof(false)), "amplitudes differ");
  EXPECT_EQ(text(Part::kDisparity, LogDisparity(1), DisparityImage(cv::Size(3, 3))),
            "32x24 and 3x3");
  EXPECT_EQ(text(Part::kPrior, LogPrior(1), PriorMap(cv::Size(3, 3))), "32x24 and 3x3");
  PriorMap prior = LogPrior(1);
  prior.sigma(5, 6) = 24;
  EXPECT_EQ(text(Part::kPrior, LogPrior(1), prior),
            "same disparities, but 1 of 768 standard deviations differ, by at most 0.500 px");
  prior.disparity.counts()(5, 6) += 32;
  EXPECT_EQ(text(Part::kPrior, LogPrior(1), prior),
            "1 of 768 pixels differ: 1 changed (mean 1.000 px, max 1.000 px), 0 newly valid, 0 "
            "newly invalid; first at (6, 5); 1 of 768 standard deviations differ, by at most "
            "0.500 px");
}

TEST(MessageDiff, ComparesHeadersAndSurvivesDamage) {
  const Bytes good = Encoded(Part::kTof, LogValue(Part::kTof, 1));
  FrameId other = LogFrameId(1);
  other.rig_id = "beef";
  const Bytes other_rig = EncodePart(other, Part::kTof, LogValue(Part::kTof, 1));
  EXPECT_EQ(Compare(good, other_rig).text, "rig_id cafe and beef");
  Bytes cut = good;
  cut.pop_back();
  EXPECT_THAT(Compare(good, cut).text, HasSubstr("undecodable in B"));
  EXPECT_THAT(Compare(cut, good).text, HasSubstr("undecodable in A"));
  EXPECT_EQ(Compare(good, Encoded(Part::kSeeds, LogValue(Part::kSeeds, 1))).text, "types differ");
  EXPECT_EQ(Compare(Bytes{1, 2}, Bytes{1, 2, 3}).text, "2 and 3 bytes differ");
}

}  // namespace
}  // namespace sprout::log
