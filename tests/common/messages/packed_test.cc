#include "common/messages/packed.h"

#include <gmock/gmock.h>

#include <cmath>
#include <lcmtypes/sprout/packed_t.hpp>
#include <lcmtypes/sprout/point_cloud_t.hpp>
#include <random>

#include "common/messages/compressor.h"
#include "tests/common/messages/examples.h"
#include "tests/common/testing/allocation_guard.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using Bytes = std::vector<uint8_t>;
using testing::HasSubstr;

// A scene like a photograph's: smooth, with edges and noise.
cv::Mat Scene(cv::Size size, int type, int noise) {
  std::mt19937 random(7);
  cv::Mat image(size, type);
  const int channels = image.channels();
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width * channels; ++u) {
      const int wave = static_cast<int>(100 + 60 * std::sin(u * 0.01 / channels) + 0.1 * v);
      const int edge = u / channels > size.width / 2 ? 40 : 0;
      image.ptr(v)[u] = static_cast<uint8_t>(wave + edge + 10 * (u % channels) +
                                             static_cast<int>(random() % (noise + 1)));
    }
  }
  return image;
}

Bytes ImageMessage(const cv::Mat& image) { return EncodePart(examples::Id(), Part::kLeft, image); }

void ExpectComesBack(const Bytes& message, const std::string& what) {
  MessagePacker packer;
  for (int i = 0; i < 2; ++i) {  // the second time in memory that is there already
    const std::optional<Bytes> packed = packer.Pack(message);
    ASSERT_TRUE(packed) << what;
    EXPECT_LT(packed->size(), message.size()) << what;
    const Result<Bytes> back = Unpack(*packed);
    ASSERT_TRUE(back) << what << ": " << back.error().text;
    EXPECT_TRUE(*back == message) << what;
    EXPECT_EQ(DecodeFrameId(*packed).value(), DecodeFrameId(message).value()) << what;
    EXPECT_EQ(TypeOf(*packed), TypeOf(message)) << what;
  }
}

TEST(PackedMessage, GivesBackTheVeryImage) {
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(1, 900), cv::Size(900, 1),
                              cv::Size(101, 63), cv::Size(16384, 2)}) {
    for (const int type : {CV_8UC1, CV_8UC3}) {
      for (const int noise : {0, 1, 9}) {
        ExpectComesBack(
            ImageMessage(Scene(size, type, noise)),
            cv::format("%dx%d, type %d, noise %d", size.width, size.height, type, noise));
      }
    }
  }
  cv::Mat3b extremes(40, 50);
  std::mt19937 random(1);
  for (cv::Vec3b& pixel : extremes) {
    for (int k = 0; k < 3; ++k) pixel[k] = random() % 9 == 0 ? uint8_t{255} : uint8_t{0};
  }
  ExpectComesBack(ImageMessage(extremes), "0 and 255");
}

TEST(PackedMessage, TakesAnImagesRedFirstToo) {
  Bytes message = ImageMessage(Scene({64, 48}, CV_8UC3, 3));
  const size_t format = examples::kRigIdLengthOffset + 4 + 17 + 12;
  message = examples::Patched(message, format, image_t::PIXEL_FORMAT_RGB3);
  ExpectComesBack(message, "RGB3");
}

TEST(PackedMessage, MakesPhotographsAtMostThreeFifths) {
  MessagePacker packer;
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const Bytes message = ImageMessage(Scene({640, 480}, type, 6));
    EXPECT_LT(static_cast<double>(packer.Pack(message)->size()),
              0.6 * static_cast<double>(message.size()));
  }
}

// Noise that knows nothing of numbers: NaN of any bits, -0, denormals.
TEST(PackedMessage, GivesBackTheVeryMaps) {
  std::mt19937 random(3);
  TofImage tof{.depth_m = cv::Mat1f(60, 80), .amplitude = cv::Mat1f(60, 80)};
  for (int i = 0; i < 60 * 80; ++i) {
    tof.depth_m(i / 80, i % 80) = 1 + 0.001F * static_cast<float>(i);
    tof.amplitude(i / 80, i % 80) = i % 5 == 0 ? NAN : static_cast<float>(i % 80);
  }
  Bytes message = EncodePart(examples::Id(), Part::kTof, tof);
  ExpectComesBack(message, "ToF");
  for (int i = 0; i < 500; ++i) message[200 + random() % 20000] = static_cast<uint8_t>(random());
  ExpectComesBack(message, "ToF of any bits");

  PriorMap prior(cv::Size(80, 60));
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) {
      prior.disparity.counts()(v, u) = static_cast<int16_t>((u * 37) % 2000 - (v % 7 == 0) * 32768);
      prior.sigma(v, u) = static_cast<uint8_t>(1 + u % 3);
    }
  }
  ExpectComesBack(EncodePart(examples::Id(), Part::kPrior, prior), "prior");
  ExpectComesBack(EncodePart(examples::Id(), Part::kDisparity, prior.disparity), "disparity");
  DepthImage depth = examples::Depth();
  depth.counts = cv::Mat1w(60, 80, uint16_t{4000});
  depth.counts(cv::Rect(3, 4, 20, 20)) = 65535;
  ExpectComesBack(EncodePart(examples::Id(), Part::kDepth, depth), "depth");
  SeedSet seeds;
  PointCloud cloud;
  for (int i = 0; i < 1000; ++i) {
    const auto x = static_cast<float>(i);
    seeds.seeds.push_back({.u = x, .v = 5, .u_right = x - 3});
    cloud.points.push_back({.position_m = {x, 1, 2}, .bgr = {1, 2, 3}, .confidence = 9});
  }
  seeds.raw = 1000;
  ExpectComesBack(EncodePart(examples::Id(), Part::kSeeds, seeds), "seeds");
  ExpectComesBack(EncodePart(examples::Id(), Part::kCloud, cloud), "cloud");
}

TEST(PackedMessage, IsDecodedAsTheMessageInside) {
  const cv::Mat image = Scene({64, 48}, CV_8UC3, 2);
  const Bytes packed = *MessagePacker().Pack(ImageMessage(image));
  const Result<DecodedPart> part = DecodePart(Part::kLeft, packed, cv::Size(64, 48));
  ASSERT_TRUE(part) << part.error().text;
  EXPECT_EQ(cv::norm(std::get<cv::Mat>(part->value), image, cv::NORM_INF), 0);
  EXPECT_EQ(part->id, examples::Id());
  EXPECT_TRUE(DecodeAs(MessageType::kImage, packed));
  EXPECT_FALSE(DecodePart(Part::kPrior, packed));
}

TEST(PackedMessage, LeavesWhatWouldNotBecomeSmaller) {
  MessagePacker packer;
  for (const examples::Wire& wire : examples::AllWires()) {  // all too small, or compressed
    const std::optional<Bytes> packed = packer.Pack(wire.bytes);
    EXPECT_TRUE(!packed || packed->size() < wire.bytes.size()) << wire.name;
  }
  EXPECT_FALSE(packer.Pack({}));
  EXPECT_FALSE(packer.Pack(Bytes(1000, 7)));
  cv::Mat1b noise(100, 100);
  cv::randu(noise, 0, 256);
  EXPECT_FALSE(packer.Pack(ImageMessage(noise)));
  // Rows with a gap.
  const Bytes message = ImageMessage(Scene({64, 48}, CV_8UC1, 0));
  const size_t width = examples::kRigIdLengthOffset + 4 + 17;
  EXPECT_FALSE(packer.Pack(examples::Patched(message, width, 63)));
  Bytes longer = message;
  longer.push_back(0);
  EXPECT_FALSE(packer.Pack(longer));
  EXPECT_FALSE(packer.Pack(std::span(message).first(40)));
  // Not twice.
  EXPECT_FALSE(packer.Pack(*packer.Pack(message)));
}

std::string ErrorOf(const packed_t& message, std::optional<cv::Size> expected = {}) {
  return WhyNot(Unpack(examples::Encode(message), expected));
}

TEST(PackedMessage, IsRefusedWhenItsFieldsDoNotFit) {
  packed_t good;
  const Bytes bytes = *MessagePacker().Pack(ImageMessage(Scene({64, 48}, CV_8UC1, 2)));
  ASSERT_GT(good.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
  EXPECT_EQ(ErrorOf(good), "");
  EXPECT_EQ(ErrorOf(good, cv::Size(64, 48)), "");
  EXPECT_THAT(ErrorOf(good, cv::Size(64, 47)),
              HasSubstr("64x48: allowed for compressed data is the size of the frame's images"));
  const auto error = [&](const auto& spoil) {
    packed_t message = good;
    spoil(message);
    message.size = static_cast<int32_t>(message.data.size());
    return ErrorOf(message);
  };
  const std::string other = "not the message that the other fields describe";
  EXPECT_THAT(error([](packed_t& m) { m.width = 65; }), HasSubstr(other));
  EXPECT_THAT(error([](packed_t& m) { m.method = 2; }), HasSubstr("message_size = "));
  EXPECT_THAT(error([](packed_t& m) { m.method = 9; }), HasSubstr("message_size = "));
  EXPECT_THAT(error([](packed_t& m) { m.header.seq = 43; }), HasSubstr(other));
  EXPECT_THAT(error([](packed_t& m) { m.header.rig_id = "x"; }), HasSubstr(other));
  EXPECT_THAT(error([](packed_t& m) { m.fingerprint += 1; }), HasSubstr(other));
  EXPECT_THAT(error([](packed_t& m) { m.width = m.height = 16384; }), HasSubstr("32000000 pixels"));
  EXPECT_THAT(error([](packed_t& m) { m.message_size += 1; }), HasSubstr("data"));
  EXPECT_THAT(error([](packed_t& m) { m.message_size = 1 << 29; }), HasSubstr("message_size = "));
  EXPECT_THAT(error([](packed_t& m) { m.message_size = -1; }), HasSubstr("message_size = -1"));
  EXPECT_THAT(error([](packed_t& m) { m.data.push_back(0); }), HasSubstr("bytes behind it"));
  EXPECT_THAT(error([](packed_t& m) { m.data.clear(); }), HasSubstr("data"));
  packed_t message = good;
  message.data.resize(10);
  EXPECT_FALSE(Unpack(std::span(bytes).first(bytes.size() - 1)));
}

TEST(PackedMessage, IsRefusedWhenItsHeaderIsLongerThanTheMessage) {
  point_cloud_t inner;
  inner.header.rig_id = "a";
  inner.count = 0;
  const Bytes bytes = examples::Encode(inner);
  packed_t outer;
  outer.header = inner.header;
  outer.header.rig_id = std::string(500, 'x');
  outer.fingerprint = point_cloud_t::getHash();
  outer.width = outer.height = 0;
  outer.message_size = static_cast<int32_t>(bytes.size());
  outer.method = packed_t::METHOD_DIFFERENCES;
  outer.data = CompressZstd(bytes);
  outer.size = static_cast<int32_t>(outer.data.size());
  EXPECT_THAT(ErrorOf(outer), HasSubstr("not the message that the other fields describe"));
}

TEST(PackedMessage, SurvivesMutations) {
  std::mt19937 random(1);
  const AllocationGuard guard;
  for (const Bytes& message :
       {ImageMessage(Scene({40, 30}, CV_8UC3, 4)),
        EncodePart(examples::Id(), Part::kPrior, PriorMap(cv::Size(40, 30)))}) {
    const Bytes packed = *MessagePacker().Pack(message);
    for (int i = 0; i < 4000; ++i) {
      Bytes mutated = packed;
      for (int k = 0; k < 1 + i % 3; ++k) {
        mutated[8 + random() % (mutated.size() - 8)] = static_cast<uint8_t>(random());
      }
      if (i % 5 == 0) mutated.resize(random() % mutated.size());
      if (!IsPacked(mutated)) continue;
      const Result<Bytes> back = Unpack(mutated);
      EXPECT_TRUE(!back || back->size() == message.size());
      static_cast<void>(DecodePart(Part::kLeft, mutated));
      static_cast<void>(DecodeFrameId(mutated));
      static_cast<void>(TypeOf(mutated));
    }
  }
  EXPECT_LT(AllocationGuard::largest(), size_t{1} << 20);
}

}  // namespace
}  // namespace sprout
