#include "services/capture/image_encoder.h"

#include <gtest/gtest.h>

#include "common/messages/codec.h"
#include "common/messages/packed.h"
#include "common/scenes/dataset.h"

namespace sprout::capture {
namespace {

class ImageEncoderTest : public testing::Test {
 protected:
  ImageEncoderTest() {
    config_.set_source("synthetic:160x120");
    const auto dataset = scenes::OpenDataset(config_);
    const scenes::DatasetFrame captured = dataset->Get(0);
    raw_.id = {.utime = 5, .seq = 7, .rig_id = "rig"};
    const std::pair<Part, PartValue> parts[] = {
        {Part::kLeft, captured.left}, {Part::kRight, captured.right}, {Part::kTof, captured.tof}};
    for (const auto& [part, value] : parts) {
      raw_.messages.emplace_back(part,
                                 EncodePart(raw_.id, part, value, DisparityEncoding::kRawInt16));
    }
  }

  CaptureMessages Encoded(CaptureConfig::ImageEncoding encoding) {
    config_.set_image_encoding(encoding);
    CaptureMessages frame = raw_;
    ImageEncoder(config_).Encode(frame);
    return frame;
  }

  CaptureConfig config_;
  CaptureMessages raw_;
};

TEST_F(ImageEncoderTest, LosesNothingUnlessItMay) {
  const CaptureMessages frame = Encoded(CaptureConfig::LOSSLESS);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_LT(10 * frame.messages[i].second.size(), 7 * raw_.messages[i].second.size());
    EXPECT_EQ(*Unpack(frame.messages[i].second), raw_.messages[i].second);
  }
  EXPECT_EQ(frame.messages[2], raw_.messages[2]);
}

TEST_F(ImageEncoderTest, MakesJpegOfTheQualityThatIsAskedFor) {
  const CaptureMessages good = Encoded(CaptureConfig::JPEG);
  config_.set_jpeg_quality(30);
  const CaptureMessages small = Encoded(CaptureConfig::JPEG);
  for (size_t i = 0; i < 2; ++i) {
    const auto& [part, bytes] = good.messages[i];
    EXPECT_LT(10 * bytes.size(), 3 * raw_.messages[i].second.size());
    EXPECT_LT(small.messages[i].second.size(), bytes.size());
    const auto image = std::get<cv::Mat>(DecodePart(part, bytes)->value);
    const auto before = std::get<cv::Mat>(DecodePart(part, raw_.messages[i].second)->value);
    EXPECT_GT(cv::PSNR(image, before), 28);
  }
  EXPECT_EQ(good.messages[2], raw_.messages[2]);
}

}  // namespace
}  // namespace sprout::capture
