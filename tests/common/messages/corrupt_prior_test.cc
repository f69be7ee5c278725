#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include <functional>

#include "tests/common/messages/examples.h"
#include "tests/common/testing/allocation_guard.h"

// Priors that the border must refuse; what a disparity map has in common with them is tested there.
namespace sprout {
namespace {

using ::testing::HasSubstr;

constexpr DisparityEncoding kPriorEncodings[] = {DisparityEncoding::kRawInt16,
                                                 DisparityEncoding::kDeltaZstd};

prior_t PriorMessage(DisparityEncoding encoding) {
  return ToMessage(examples::Id(), examples::Prior(), encoding);
}

std::string ErrorOf(const prior_t& message) {
  const Result<DecodedPart> decoded = DecodePart(Part::kPrior, examples::Encode(message));
  return decoded ? "" : decoded.error().text;
}

void SetSigma(prior_t& message, std::vector<uint8_t> sigma) {
  message.sigma = std::move(sigma);
  message.sigma_size = static_cast<int32_t>(message.sigma.size());
}

std::vector<uint8_t> Compressed(const std::vector<uint8_t>& content) {
  std::vector<uint8_t> data(ZSTD_compressBound(content.size()));
  data.resize(ZSTD_compress(data.data(), data.size(), content.data(), content.size(), 1));
  return data;
}

TEST(PriorBorder, RefusesFieldsThatDoNotFitAndNamesThem) {
  using M = prior_t;
  const struct {
    std::function<void(M&)> apply;
    const char* error;
  } table[] = {
      {[](M& m) { m.width = 0; }, "width = 0: allowed is 1 to 16384"},
      {[](M& m) { m.height = 16385; }, "height = 16385: allowed is 1 to 16384"},
      {[](M& m) { m.counts_per_px = 16; }, "counts_per_px = 16: allowed is 32"},
      {[](M& m) { m.invalid = 0; }, "invalid = 0: allowed is -32768"},
      {[](M& m) { m.sigma_counts_per_px = 32; }, "sigma_counts_per_px = 32: allowed is 16"},
      {[](M& m) { m.encoding = 2; }, "encoding = 2: allowed is RAW or DELTA_ZSTD"},
      {[](M& m) { m.encoding = -1; }, "encoding = -1: allowed is RAW or DELTA_ZSTD"},
  };
  for (const DisparityEncoding encoding : kPriorEncodings) {
    for (const auto& corruption : table) {
      prior_t message = PriorMessage(encoding);
      corruption.apply(message);
      EXPECT_EQ(ErrorOf(message), corruption.error);
    }
  }
}

TEST(PriorBorder, RefusesMorePixelsThanItsEncodingMayHave) {
  prior_t message = PriorMessage(DisparityEncoding::kRawInt16);
  message.width = message.height = 16384;
  EXPECT_EQ(ErrorOf(message), "width × height = 268435456: allowed is up to 100000000 pixels");
  message = PriorMessage(DisparityEncoding::kDeltaZstd);
  message.width = message.height = 16384;
  EXPECT_EQ(ErrorOf(message),
            "width x height = 16384x16384: allowed for compressed data are up to 32000000 pixels");
}

TEST(PriorBorder, RefusesRawSigmaOfAnotherSize) {
  prior_t message = PriorMessage(DisparityEncoding::kRawInt16);
  for (const size_t size : {0, 11, 13, 24}) {
    SetSigma(message, std::vector<uint8_t>(size, 255));
    EXPECT_EQ(ErrorOf(message),
              "sigma_size = " + std::to_string(size) + ": allowed is width × height = 12");
  }
}

TEST(PriorBorder, RefusesCompressedSigmaOfAnotherSize) {
  prior_t message = PriorMessage(DisparityEncoding::kDeltaZstd);
  for (const size_t size : {0, 11, 13, 24}) {
    SetSigma(message, Compressed(std::vector<uint8_t>(size, 7)));
    EXPECT_EQ(ErrorOf(message), "sigma: not a Zstandard frame of width × height = 12 bytes");
  }
}

TEST(PriorBorder, RefusesCompressedSigmaThatIsDamagedOrHasMoreBehindIt) {
  const prior_t valid =
      ToMessage(examples::Id(), PriorMap(cv::Size(400, 300)), DisparityEncoding::kDeltaZstd);
  for (size_t size = 0; size < valid.sigma.size(); ++size) {
    prior_t message = valid;
    SetSigma(message, {valid.sigma.begin(), valid.sigma.begin() + static_cast<int>(size)});
    EXPECT_THAT(ErrorOf(message), HasSubstr("sigma: ")) << "cut at " << size;
  }
  prior_t message = valid;
  std::vector<uint8_t> longer = valid.sigma;
  const std::vector<uint8_t> empty_frame = Compressed({});
  longer.insert(longer.end(), empty_frame.begin(), empty_frame.end());
  SetSigma(message, longer);
  EXPECT_THAT(ErrorOf(message), HasSubstr("sigma: damaged Zstandard frame, or bytes behind it"));
}

TEST(PriorBorder, RefusesSigmaThatSaysMoreOrLessThanItCan) {
  for (const DisparityEncoding encoding : kPriorEncodings) {
    PriorMap certain(examples::Prior().disparity, examples::Prior().sigma.clone());
    certain.sigma(1, 2) = 0;
    EXPECT_EQ(ErrorOf(ToMessage(examples::Id(), certain, encoding)),
              "sigma at (2, 1) = 0: allowed is 1 to 255");
    PriorMap of_nothing(examples::Prior().disparity, examples::Prior().sigma.clone());
    of_nothing.sigma(2, 0) = 254;
    EXPECT_EQ(ErrorOf(ToMessage(examples::Id(), of_nothing, encoding)),
              "sigma at (0, 2) = 254: allowed is 255 where there is no disparity");
  }
}

TEST(PriorBorder, RefusesACompressedPriorOfAnotherSizeThanTheFramesBeforeItIsDecoded) {
  const PriorMap map(cv::Size(4000, 3000));  // 36 MB in a few hundred bytes
  const auto bomb = EncodePart(examples::Id(), Part::kPrior, map, DisparityEncoding::kDeltaZstd);
  ASSERT_LT(bomb.size(), 100'000U);
  const AllocationGuard guard;
  const auto decoded = DecodePart(Part::kPrior, bomb, cv::Size(640, 480));
  EXPECT_LT(guard.largest(), 200'000U);
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().text,
            "width x height = 4000x3000: allowed for compressed data is the size of the frame's "
            "images, 640x480");
  EXPECT_TRUE(DecodePart(Part::kPrior, bomb, cv::Size(4000, 3000)));
}

TEST(PriorBorder, TakesNoMemoryForAHugeSigmaWithTinyData) {
  prior_t message =
      ToMessage(examples::Id(), PriorMap(cv::Size(1, 1)), DisparityEncoding::kDeltaZstd);
  message.width = message.height = 5000;
  EXPECT_THAT(ErrorOf(message), HasSubstr("2 × width × height = 50000000"));
  // Disparities of that size are there; the standard deviations are one byte.
  message =
      ToMessage(examples::Id(), PriorMap(cv::Size(3000, 2000)), DisparityEncoding::kDeltaZstd);
  SetSigma(message, Compressed({255}));
  EXPECT_THAT(ErrorOf(message), HasSubstr("sigma: not a Zstandard frame"));
}

TEST(PriorBorder, LeavesAWholePriorOfAnotherSizeToTheStage) {
  const auto bytes =
      EncodePart(examples::Id(), Part::kPrior, examples::Prior(), DisparityEncoding::kRawInt16);
  EXPECT_TRUE(DecodePart(Part::kPrior, bytes, cv::Size(640, 480)));
}

}  // namespace
}  // namespace sprout
