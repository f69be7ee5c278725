#include "common/ros/cdr.h"

#include <gmock/gmock.h>

#include <random>

#include "common/ros/from_ros.h"
#include "tests/common/ros/fast_cdr.h"
#include "tests/common/ros/ros_examples.h"
#include "tests/common/testing/allocation_guard.h"

namespace sprout {
namespace {

using examples::ForEachRosExample;
using examples::Json;
using fast_cdr::Cdr;

std::vector<uint8_t> Written(const AnyRosMessage& message) {
  std::vector<uint8_t> bytes;
  WriteCdr(message, bytes);
  return bytes;
}

// The fields that were read, or the reason why not.
template <typename T>
Json ValueOf(const RosMessage<T>& /*like*/, std::span<const uint8_t> bytes) {
  const Result<RosMessage<T>> message = ReadCdr<T>(bytes);
  return message ? examples::Value(**message) : Json(message.error().text);
}

TEST(Cdr, GivesBackWhatWasWritten) {
  int types = 0;
  ForEachRosExample([&](const auto& message, const Json& value) {
    EXPECT_EQ(ValueOf(message, Written(message)), value);
    ++types;
  });
  EXPECT_EQ(types, 8);
}

TEST(Cdr, HasTheBytesOfFastCdr) {
  ForEachRosExample([](const auto& message, const Json&) {
    EXPECT_EQ(Written(message), fast_cdr::Write(*message, Cdr::LITTLE_ENDIANNESS))
        << message.type().name;
  });
}

TEST(Cdr, ReadsFastCdrsBytesOfEitherByteOrder) {
  ForEachRosExample([](const auto& message, const Json& value) {
    for (const auto order : {Cdr::BIG_ENDIANNESS, Cdr::LITTLE_ENDIANNESS}) {
      EXPECT_EQ(ValueOf(message, fast_cdr::Write(*message, order)), value) << message.type().name;
    }
  });
}

// Every beginning is refused, but for those that lack only what nothing needs: none does.
TEST(Cdr, RefusesEveryBeginning) {
  ForEachRosExample([](const auto& message, const Json&) {
    const std::vector<uint8_t> bytes = Written(message);
    for (size_t size = 0; size < bytes.size(); ++size) {
      const Json read = ValueOf(message, std::span(bytes).first(size));
      ASSERT_TRUE(read.is_string()) << message.type().name << ", first " << size << " bytes";
    }
  });
}

TEST(Cdr, RefusesAnotherEncapsulation) {
  const auto message = ToRosImage(examples::Place(), examples::GreyImage());
  std::vector<uint8_t> bytes = Written(message);
  bytes[1] = 3;  // PL_CDR
  EXPECT_EQ(ValueOf(message, bytes),
            "sensor_msgs/msg/Image: encapsulation 3; allowed: 0 (CDR, big endian) and 1 (CDR, "
            "little endian)");
}

TEST(Cdr, TakesNoMemoryForALengthThatCannotBe) {
  const auto message = ToRosImage(examples::Place(), examples::GreyImage());
  std::vector<uint8_t> bytes = Written(message);
  const size_t length = bytes.size() - 35 - 4;
  ASSERT_EQ(bytes[length], 35);
  bytes[length + 3] = 0x7f;  // 2 GB
  const AllocationGuard guard;
  EXPECT_TRUE(ValueOf(message, bytes).is_string());
  EXPECT_LT(AllocationGuard::largest(), size_t{1} << 20);
}

template <typename T>
void Convert(const T& message) {
  if constexpr (std::is_same_v<T, RosImage>) {
    (void)FromRosImage(message);
    (void)FromRosDepth(message);
    (void)FromRosStamp(message.header);
  } else if constexpr (std::is_same_v<T, RosCompressedImage>) {
    (void)FromRosImage(message, cv::Size(7, 5));
    (void)FromRosDepth(message, std::nullopt);
  } else if constexpr (std::is_same_v<T, RosCameraInfo>) {
    (void)FromRosInfo(message);
  } else if constexpr (std::is_same_v<T, RosPointCloud>) {
    (void)FromRosCloud(message);
  } else if constexpr (std::is_same_v<T, RosTransforms>) {
    for (const RosTransform& one : RosSpan(message.transforms)) (void)FromRosTransform(one);
  }
}

// 20 000 in all; what is still a message goes through the conversions, under AddressSanitizer in
// CI.
TEST(Cdr, SurvivesMutations) {
  std::mt19937 random(1);
  int64_t read = 0;
  int64_t refused = 0;
  ForEachRosExample([&](const auto& message, const Json&) {
    using T = std::remove_cvref_t<decltype(*message)>;
    for (const auto order : {Cdr::BIG_ENDIANNESS, Cdr::LITTLE_ENDIANNESS}) {
      const std::vector<uint8_t> whole = fast_cdr::Write(*message, order);
      for (int i = 0; i < 1250; ++i) {
        std::vector<uint8_t> bytes = whole;
        for (uint32_t k = random() % 4 + 1; k > 0; --k) {
          bytes[random() % bytes.size()] =
              static_cast<uint8_t>(random() % 3 == 0 ? 0xff : random());
        }
        if (random() % 4 == 0) bytes.resize(random() % bytes.size());
        const Result<RosMessage<T>> result = ReadCdr<T>(bytes);
        result ? ++read : ++refused;
        if (result) Convert(**result);
      }
    }
  });
  EXPECT_EQ(read + refused, 20'000);
  EXPECT_GT(read, 1000);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace sprout
