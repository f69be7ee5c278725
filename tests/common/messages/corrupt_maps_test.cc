#include <gmock/gmock.h>
#include <zstd.h>

#include <functional>
#include <random>

#include "tests/common/messages/examples.h"
#include "tests/common/testing/allocation_guard.h"
#include "tests/common/testing/thrown.h"

// Disparity maps and priors that the border must refuse, hostile Zstandard frames among them.
namespace sprout {
namespace {

using ::testing::HasSubstr;

disparity_image_t Message(DisparityEncoding encoding) {
  return ToMessage(examples::Id(), examples::Disparity(), encoding);
}

prior_t PriorMessage(DisparityEncoding encoding) {
  return ToMessage(examples::Id(), examples::Prior(), encoding);
}

template <typename Message>
std::string ErrorOf(const Message& message) {
  constexpr bool kIsPrior = std::is_same_v<Message, prior_t>;
  const examples::Wire wire{"", {}, kIsPrior ? Part::kPrior : Part::kDisparity};
  return wire.ErrorOf(examples::Encode(message));
}

void SetData(disparity_image_t& message, std::vector<uint8_t> data) {
  message.data = std::move(data);
  message.size = static_cast<int32_t>(message.data.size());
}

std::vector<uint8_t> Compressed(const std::vector<uint8_t>& content) {
  std::vector<uint8_t> data(ZSTD_compressBound(content.size()));
  data.resize(ZSTD_compress(data.data(), data.size(), content.data(), content.size(), 1));
  return data;
}

template <typename Message>
struct MapCorruption {
  std::function<void(Message&)> apply;
  const char* error;
};

template <typename Message>
void ExpectMapRefused(Message (*make)(DisparityEncoding),
                      const std::vector<MapCorruption<Message>>& table) {
  for (const DisparityEncoding encoding : examples::kEncodings) {
    for (const MapCorruption<Message>& corruption : table) {
      Message message = make(encoding);
      corruption.apply(message);
      EXPECT_EQ(ErrorOf(message), corruption.error);
    }
  }
}

TEST(DisparityBorder, RefusesFieldsThatDoNotFitAndNamesThem) {
  using M = disparity_image_t;
  ExpectMapRefused<M>(
      Message,
      {
          {[](M& m) { m.width = 0; }, "width = 0: allowed is 1 to 16384"},
          {[](M& m) { m.width = 16385; }, "width = 16385: allowed is 1 to 16384"},
          {[](M& m) { m.height = 0; }, "height = 0: allowed is 1 to 16384"},
          {[](M& m) { m.height = 16385; }, "height = 16385: allowed is 1 to 16384"},
          {[](M& m) { m.height = INT32_MIN; }, "height = -2147483648: allowed is 1 to 16384"},
          {[](M& m) { m.counts_per_px = 16; }, "counts_per_px = 16: allowed is 32"},
          {[](M& m) { m.invalid = 0; }, "invalid = 0: allowed is -32768"},
          {[](M& m) { m.encoding = 2; }, "encoding = 2: allowed is RAW_INT16 or DELTA_ZSTD"},
          {[](M& m) { m.encoding = -1; }, "encoding = -1: allowed is RAW_INT16 or DELTA_ZSTD"},
      });
}

TEST(DisparityBorder, RefusesRawDataOfAnotherSize) {
  disparity_image_t message = Message(DisparityEncoding::kRawInt16);
  SetData(message, std::vector<uint8_t>(23));
  EXPECT_EQ(ErrorOf(message), "size = 23: allowed is 2 × width × height = 24");
  SetData(message, std::vector<uint8_t>(25));
  EXPECT_EQ(ErrorOf(message), "size = 25: allowed is 2 × width × height = 24");
  SetData(message, {});
  EXPECT_EQ(ErrorOf(message), "size = 0: allowed is 2 × width × height = 24");
}

TEST(DisparityBorder, RefusesZstandardFramesOfAnotherSize) {
  disparity_image_t message = Message(DisparityEncoding::kDeltaZstd);
  for (const size_t size : {0, 1, 23, 25, 48}) {
    SetData(message, Compressed(std::vector<uint8_t>(size, 7)));
    EXPECT_THAT(ErrorOf(message), HasSubstr("2 × width × height = 24")) << size;
  }
}

TEST(DisparityBorder, RefusesAnythingBehindTheZstandardFrame) {
  disparity_image_t message = Message(DisparityEncoding::kDeltaZstd);
  std::vector<uint8_t> data = message.data;
  const std::vector<uint8_t> empty_frame = Compressed({});
  data.insert(data.end(), empty_frame.begin(), empty_frame.end());
  SetData(message, data);
  EXPECT_THAT(ErrorOf(message), HasSubstr("data: "));
}

TEST(DisparityBorder, RefusesDataThatIsNoZstandardFrame) {
  disparity_image_t message = Message(DisparityEncoding::kDeltaZstd);
  std::mt19937 random(6);
  for (size_t size = 0; size < 200; ++size) {
    std::vector<uint8_t> data(size);
    for (uint8_t& byte : data) byte = static_cast<uint8_t>(random());
    SetData(message, data);
    EXPECT_THAT(ErrorOf(message), HasSubstr("data: ")) << size << " random bytes";
  }
}

TEST(DisparityBorder, RefusesDamagedZstandardFrames) {
  const disparity_image_t valid =
      ToMessage(examples::Id(), DisparityImage(cv::Size(400, 300)), DisparityEncoding::kDeltaZstd);
  for (size_t size = 0; size < valid.data.size(); ++size) {
    disparity_image_t message = valid;
    message.data.resize(size);
    message.size = static_cast<int32_t>(size);
    EXPECT_THAT(ErrorOf(message), HasSubstr("data: ")) << "cut at " << size;
  }
}

TEST(DisparityBorder, TakesNoMemoryForAHugeMapWithTinyData) {
  disparity_image_t message = Message(DisparityEncoding::kDeltaZstd);
  message.width = message.height = 5000;
  // A frame header that declares exactly the map: magic, single segment with 4 bytes of size.
  const uint32_t declared = 2U * 5000U * 5000U;
  std::vector<uint8_t> data = {0x28, 0xb5, 0x2f, 0xfd, 0xa0};
  for (int shift = 0; shift < 32; shift += 8)
    data.push_back(static_cast<uint8_t>(declared >> shift));
  // One last block: 2^17 times the byte 7.
  const uint32_t block = 1U | 1U << 1 | (1U << 17) << 3;
  for (int shift = 0; shift < 24; shift += 8) data.push_back(static_cast<uint8_t>(block >> shift));
  data.push_back(7);
  ASSERT_EQ(ZSTD_findFrameCompressedSize(data.data(), data.size()), data.size());
  ASSERT_EQ(ZSTD_getFrameContentSize(data.data(), data.size()), declared);
  SetData(message, data);
  const std::vector<uint8_t> bytes = examples::Encode(message);
  const AllocationGuard guard;
  const std::string error = WhyNot(DecodePart(Part::kDisparity, bytes));
  EXPECT_LT(guard.largest(), 100'000U);
  EXPECT_THAT(error, HasSubstr("2 × width × height = 50000000"));
}

TEST(DisparityBorder, TakesNoMemoryForAHugeRawMapWithTinyData) {
  disparity_image_t message = Message(DisparityEncoding::kRawInt16);
  message.width = message.height = 10000;
  EXPECT_EQ(ErrorOf(message), "size = 24: allowed is 2 × width × height = 200000000");
}

// --- Priors: what they have besides ---

void SetSigma(prior_t& message, std::vector<uint8_t> sigma) {
  message.sigma = std::move(sigma);
  message.sigma_size = static_cast<int32_t>(message.sigma.size());
}

TEST(PriorBorder, RefusesFieldsThatDoNotFitAndNamesThem) {
  using M = prior_t;
  ExpectMapRefused<M>(
      PriorMessage,
      {
          {[](M& m) { m.width = 0; }, "width = 0: allowed is 1 to 16384"},
          {[](M& m) { m.height = 16385; }, "height = 16385: allowed is 1 to 16384"},
          {[](M& m) { m.counts_per_px = 16; }, "counts_per_px = 16: allowed is 32"},
          {[](M& m) { m.invalid = 0; }, "invalid = 0: allowed is -32768"},
          {[](M& m) { m.sigma_counts_per_px = 32; }, "sigma_counts_per_px = 32: allowed is 16"},
          {[](M& m) { m.encoding = 2; }, "encoding = 2: allowed is RAW or DELTA_ZSTD"},
          {[](M& m) { m.encoding = -1; }, "encoding = -1: allowed is RAW or DELTA_ZSTD"},
      });
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
  for (const DisparityEncoding encoding : examples::kEncodings) {
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

// Maps of 12 megapixels in a few hundred bytes.
TEST(MapBorder, RefusesACompressedMapOfAnotherSizeThanTheFramesBeforeItIsDecoded) {
  const cv::Size size(4000, 3000);
  for (const auto& [part, map] : {std::pair<Part, PartValue>(Part::kUnfilled, DisparityImage(size)),
                                  std::pair<Part, PartValue>(Part::kPrior, PriorMap(size))}) {
    const auto bomb = EncodePart(examples::Id(), part, map, DisparityEncoding::kDeltaZstd);
    ASSERT_LT(bomb.size(), 100'000U);
    const AllocationGuard guard;
    const std::string error = WhyNot(DecodePart(part, bomb, cv::Size(640, 480)));
    EXPECT_LT(guard.largest(), 200'000U);
    EXPECT_EQ(error,
              "width x height = 4000x3000: allowed for compressed data is the size of the frame's "
              "images, 640x480");
    EXPECT_TRUE(DecodePart(part, bomb, size));
  }
}

TEST(MapBorder, LeavesAWholeMapOfAnotherSizeToTheStage) {
  for (const auto& [part, map] :
       {std::pair<Part, PartValue>(Part::kUnfilled, examples::Disparity()),
        std::pair<Part, PartValue>(Part::kPrior, examples::Prior())}) {
    const auto bytes = EncodePart(examples::Id(), part, map);
    EXPECT_TRUE(DecodePart(part, bytes, cv::Size(640, 480)));
  }
}

}  // namespace
}  // namespace sprout
