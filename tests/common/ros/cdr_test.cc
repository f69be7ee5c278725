#include "common/ros/cdr.h"

#include <gmock/gmock.h>

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

}  // namespace
}  // namespace sprout
