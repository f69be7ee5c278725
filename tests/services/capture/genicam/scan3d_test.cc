#include "services/capture/genicam/scan3d.h"

#include <gmock/gmock.h>

#include <cstring>
#include <limits>
#include <vector>

#include "common/config/required.h"
#include "common/geometry/lens.h"

namespace sprout::capture {
namespace {

using testing::HasSubstr;

template <typename T>
std::vector<uint8_t> Bytes(const std::vector<T>& numbers) {
  std::vector<uint8_t> bytes(numbers.size() * sizeof(T));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

PayloadPart Part(PixelFormat format, int width, int height, const std::vector<uint8_t>& bytes,
                 PartContent content = PartContent::kUnknown) {
  return {.format = static_cast<uint32_t>(format),
          .width = width,
          .height = height,
          .row_padding = 0,
          .bytes = bytes,
          .content = content};
}

TEST(Scan3d, NumbersBecomeMetres) {
  const auto bytes = Bytes<uint16_t>({0, 4000, 8000, 65535});
  const Scan3d scan3d{.scale = 0.25, .offset = 10, .unit_m = 1e-3, .invalid = 65535};
  const TofImage image =
      Required(ToTofImage(std::vector{Part(PixelFormat::kCoord3dC16, 2, 2, bytes)}, scan3d));
  EXPECT_EQ(image.depth_m(0, 0), 0.01F);
  EXPECT_EQ(image.depth_m(0, 1), 1.01F);
  EXPECT_EQ(image.depth_m(1, 0), 2.01F);
  EXPECT_EQ(image.depth_m(1, 1), 0.0F);
  EXPECT_TRUE(image.amplitude.empty());
}

TEST(Scan3d, TheLargestCountIsNoReturnEvenWhereTheDeviceNamesAnother) {
  const auto counts = Bytes<uint16_t>({1, 65534, 65535});
  const auto floats = Bytes<float>({1, 65534, 65535});
  for (const std::optional<double> invalid : {std::optional<double>(), std::optional<double>(1)}) {
    const Scan3d scan3d{.invalid = invalid};
    const Result<TofImage> integers =
        ToTofImage(std::vector{Part(PixelFormat::kCoord3dC16, 3, 1, counts)}, scan3d);
    const Result<TofImage> metres =
        ToTofImage(std::vector{Part(PixelFormat::kCoord3dC32f, 3, 1, floats)}, scan3d);
    ASSERT_TRUE(integers && metres);
    EXPECT_EQ(integers->depth_m(0, 0), invalid ? 0 : 0.001F);
    EXPECT_EQ(integers->depth_m(0, 1), 65.534F);
    EXPECT_EQ(integers->depth_m(0, 2), 0.0F);
    EXPECT_EQ(metres->depth_m(0, 2), 65.535F);
  }
}

TEST(Scan3d, TheIntensityBesideCIsTheAmplitude) {
  const auto bytes = Bytes<uint16_t>({1, 2, 3000, 700, 4, 5, 65535, 65535});
  const TofImage image =
      Required(ToTofImage(std::vector{Part(PixelFormat::kCoord3dAbcy16, 2, 1, bytes)},
                          {.scale = 0.5, .invalid = 65535}));
  EXPECT_EQ(image.depth_m(0, 0), 1.5F);
  EXPECT_EQ(image.depth_m(0, 1), 0.0F);
  EXPECT_EQ(image.amplitude(0, 0), 700.0F);
  EXPECT_EQ(image.amplitude(0, 1), 65535.0F);
}

TEST(Scan3d, CIsTheLastOfThreeCoordinates) {
  const auto integers = Bytes<uint16_t>({1, 2, 3000, 4, 5, 6000});
  const auto floats = Bytes<float>({1, 2, 3000, 4, 5, std::numeric_limits<float>::quiet_NaN()});
  const TofImage first =
      Required(ToTofImage(std::vector{Part(PixelFormat::kCoord3dAbc16, 2, 1, integers)}, {}));
  EXPECT_EQ(first.depth_m(0, 0), 3.0F);
  EXPECT_EQ(first.depth_m(0, 1), 6.0F);
  const TofImage second =
      Required(ToTofImage(std::vector{Part(PixelFormat::kCoord3dAbc32f, 2, 1, floats)}, {}));
  EXPECT_EQ(second.depth_m(0, 0), 3.0F);
  EXPECT_EQ(second.depth_m(0, 1), 0.0F);
}

TEST(Scan3d, PartsOfAMultipartPayloadAreToldApart) {
  const auto range = Bytes<uint16_t>({1000, 2000, 3000, 4000});
  const auto amplitude = Bytes<uint16_t>({10, 20, 30, 40});
  const auto confidence = Bytes<uint16_t>({7, 0, 9, 9});
  const auto confidence8 = Bytes<uint8_t>({7, 0, 9, 9});
  // Parts may come in any order; the amplitude is taken rather than the confidence.
  const TofImage all = Required(ToTofImage(
      std::vector{Part(PixelFormat::kMono16, 2, 2, amplitude, PartContent::kImage),
                  Part(PixelFormat::kConfidence16, 2, 2, confidence, PartContent::kConfidence),
                  Part(PixelFormat::kCoord3dC16, 2, 2, range, PartContent::kRange)},
      {}));
  EXPECT_EQ(all.depth_m(0, 0), 1.0F);
  EXPECT_EQ(all.depth_m(0, 1), 0.0F) << "confidence 0";
  EXPECT_EQ(all.amplitude(1, 1), 40.0F);
  const TofImage two =
      Required(ToTofImage(std::vector{Part(PixelFormat::kCoord3dC16, 2, 2, range),
                                      Part(PixelFormat::kConfidence8, 2, 2, confidence8)},
                          {}));
  EXPECT_EQ(two.amplitude(0, 0), 7.0F);
}

TEST(Scan3d, Mono16HoldsRangesWhenNothingElseDoes) {
  const auto range = Bytes<uint16_t>({1000, 2000});
  const auto confidence = Bytes<uint16_t>({1, 1});
  const TofImage alone =
      Required(ToTofImage(std::vector{Part(PixelFormat::kMono16, 2, 1, range)}, {}));
  EXPECT_EQ(alone.depth_m(0, 1), 2.0F);
  const TofImage two = Required(ToTofImage(
      std::vector{Part(PixelFormat::kMono16, 2, 1, range, PartContent::kRange),
                  Part(PixelFormat::kMono16, 2, 1, confidence, PartContent::kConfidence)},
      {}));
  EXPECT_EQ(two.depth_m(0, 0), 1.0F);
  EXPECT_EQ(two.amplitude(0, 0), 1.0F);
  EXPECT_THAT(
      ToTofImage(std::vector{Part(PixelFormat::kMono16, 2, 1, range, PartContent::kImage)}, {})
          .error()
          .text,
      HasSubstr("no range in the payload's Mono16; allowed: Coord3D_C16"));
}

TEST(Scan3d, SaysWhatIsWrongWithAPayload) {
  const auto range = Bytes<uint16_t>({1000, 2000});
  const auto error = [](const std::vector<PayloadPart>& parts) {
    return ToTofImage(parts, {}).error().text;
  };
  EXPECT_THAT(error({}), HasSubstr("no range"));
  EXPECT_THAT(error({Part(PixelFormat::kCoord3dC16, 2, 2, range)}), HasSubstr("needed: 8"));
  EXPECT_EQ(error({Part(PixelFormat::kCoord3dC16, 2, 1, range),
                   Part(PixelFormat::kConfidence16, 1, 2, range)}),
            "Confidence16 is 1x2, Coord3D_C16 is 2x1; allowed: one size");
}

TEST(Scan3d, RefusesRangesAndConfidencesInAFormatOfColours) {
  const auto range = Bytes<uint16_t>({1000, 2000});
  const auto bytes =
      Bytes<uint8_t>({1, 2});  // as 16-bit numbers they would be read beyond their end
  for (const PixelFormat format : {PixelFormat::kBayerRG8, PixelFormat::kBayerBG8}) {
    const PayloadPart as_range = Part(format, 2, 1, bytes, PartContent::kRange);
    const PayloadPart as_confidence = Part(format, 2, 1, bytes, PartContent::kConfidence);
    const std::string error =
        "pixel format " + PixelFormatName(static_cast<uint32_t>(format)) + " holds no ranges";
    EXPECT_THAT(ToTofImage(std::vector{as_range}, {}).error().text, HasSubstr(error));
    EXPECT_THAT(
        ToTofImage(std::vector{Part(PixelFormat::kCoord3dC16, 2, 1, range), as_confidence}, {})
            .error()
            .text,
        HasSubstr(error));
  }
}

TEST(Scan3d, RangesBecomeDepths) {
  const Lens lens{.width = 4, .height = 3, .fx = 2, .fy = 2, .cx = 0, .cy = 0, .distortion = {}};
  TofImage image;
  image.depth_m = cv::Mat1f(3, 4, 3.0F);
  image.depth_m(1, 1) = 0;
  RangesToDepths(image, RangePerDepth(lens));
  EXPECT_EQ(image.depth_m(0, 0), 3.0F);
  EXPECT_EQ(image.depth_m(1, 1), 0.0F);
  // Pixel (2, 2) looks into (1, 1, 1).
  EXPECT_NEAR(image.depth_m(2, 2), 3 / std::sqrt(3.0), 1e-6);
}

}  // namespace
}  // namespace sprout::capture
