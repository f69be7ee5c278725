#include <gmock/gmock.h>
#include <turbojpeg.h>

#include <fstream>
#include <string>

#include "tests/common/messages/examples.h"
#include "tests/common/testing/allocation_guard.h"
#include "tests/common/testing/thrown.h"

// The memory that a few bytes can ask for: README of common/messages.
namespace sprout {
namespace {

constexpr int kColumns = 8000;
constexpr int kMaxRows = 4000;
static_assert(int64_t{kColumns} * kMaxRows == kMaxCompressedPixels);

constexpr int64_t kBytesPerPixel = 9;           // of decoding, as the README states
constexpr int64_t kBesides = 16 * 1024 * 1024;  // the message itself, the decoder, the allocator

// "VmHWM", "VmRSS": bytes; of this process.
int64_t StatusBytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != key + ":") continue;
    int64_t kilobytes = 0;
    status >> kilobytes;
    return 1024 * kilobytes;
  }
  return 0;
}

// Sets the peak to what is taken now. @returns whether this kernel can.
bool ForgetPeak() {
  std::ofstream file("/proc/self/clear_refs");
  return static_cast<bool>(file << "5" << std::flush);
}

std::vector<uint8_t> CompressedMap(cv::Size size) {
  return EncodePart(examples::Id(), Part::kDisparity, DisparityImage(size),
                    DisparityEncoding::kDeltaZstd);
}

std::vector<uint8_t> CompressedPrior(cv::Size size) {
  return EncodePart(examples::Id(), Part::kPrior, PriorMap(size), DisparityEncoding::kDeltaZstd);
}

// Progressive and without subsampling: libjpeg keeps the coefficients of the whole picture.
std::vector<uint8_t> CompressedPicture(cv::Size size) {
  image_t message;
  message.header = ToMessage(examples::Id());
  message.width = size.width;
  message.height = size.height;
  message.pixel_format = image_t::PIXEL_FORMAT_MJPG;
  message.row_stride = 0;
  const cv::Mat3b image(size, cv::Vec3b(20, 120, 220));
  void* const encoder = tjInitCompress();
  unsigned char* stream = nullptr;
  unsigned long bytes = 0;
  EXPECT_EQ(tjCompress2(encoder, image.data, size.width, 0, size.height, TJPF_BGR, &stream, &bytes,
                        TJSAMP_444, 90, TJFLAG_PROGRESSIVE),
            0);
  message.data.assign(stream, stream + bytes);
  tjFree(stream);
  tjDestroy(encoder);
  message.size = static_cast<int32_t>(message.data.size());
  return examples::Encode(message);
}

struct Bomb {
  const char* name;
  Part part;
  std::vector<uint8_t> (*make)(cv::Size);
};
constexpr Bomb kBombs[] = {{"map", Part::kDisparity, CompressedMap},
                           {"prior", Part::kPrior, CompressedPrior},
                           {"picture", Part::kLeft, CompressedPicture}};

void PrintTo(const Bomb& bomb, std::ostream* out) { *out << bomb.name; }

class CompressedMessage : public ::testing::TestWithParam<Bomb> {};

TEST_P(CompressedMessage, TakesNoMoreThanNineBytesForEachOfItsPixels) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer takes memory of its own";
#endif
  const std::vector<uint8_t> bytes = GetParam().make({kColumns, kMaxRows});
  if (!ForgetPeak()) GTEST_SKIP() << "/proc/self/clear_refs cannot be written here";
  const int64_t before = StatusBytes("VmRSS");
  const Result<DecodedPart> decoded = DecodePart(GetParam().part, bytes);
  const int64_t taken = StatusBytes("VmHWM") - before;
  ASSERT_TRUE(decoded) << decoded.error().text;
  RecordProperty("megabytes", static_cast<int>(taken / 1'000'000));
  EXPECT_LT(taken, kBytesPerPixel * kMaxCompressedPixels + kBesides);
  EXPECT_GT(taken, kMaxCompressedPixels) << "the peak was not seen";
}

TEST_P(CompressedMessage, IsRefusedBeforeItTakesMemoryWhenItIsLarger) {
  const cv::Size larger(kColumns, kMaxRows + 1);
  std::vector<uint8_t> bytes = GetParam().make({8, 8});
  // Width and height stand right behind the header.
  const size_t width = examples::kRigIdLengthOffset + 4 + examples::Id().rig_id.size() + 1;
  bytes = examples::Patched(bytes, width, larger.width);
  bytes = examples::Patched(bytes, width + 4, larger.height);
  for (const std::optional<cv::Size>& expected : {std::optional<cv::Size>(), {larger}}) {
    const AllocationGuard guard;
    const std::string error = WhyNot(DecodePart(GetParam().part, bytes, expected));
    EXPECT_LT(guard.largest(), 4096U);
    EXPECT_THAT(error, ::testing::HasSubstr(
                           "8000x4001: allowed for compressed data are up to 32000000 pixels"));
  }
}

INSTANTIATE_TEST_SUITE_P(OfThreeKinds, CompressedMessage, ::testing::ValuesIn(kBombs),
                         [](const auto& bomb) { return std::string(bomb.param.name); });

}  // namespace
}  // namespace sprout
