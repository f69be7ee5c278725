#include "common/messages/codec.h"

#include <algorithm>
#include <cassert>
#include <exception>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>

#include "common/messages/packed.h"

namespace sprout {
namespace {

// An array in a message: where its int32 count stands, in bytes behind the header, and how many
// bytes one element takes of each of the arrays that share the count.
struct CountedArray {
  size_t count_offset;
  size_t element_bytes;
};

// All counts of our types stand between the header and the first array, so that they can be read
// before the generated decoder believes them. A test compares each table with the encoder.
using Arrays = std::initializer_list<CountedArray>;
template <typename Message>
extern const Arrays kArrays;  // a type without a table does not link
template <>
constexpr Arrays kArrays<image_t> = {{16, 1}};
template <>
constexpr Arrays kArrays<tof_image_t> = {{8, sizeof(float)}, {12, sizeof(float)}};
template <>
constexpr Arrays kArrays<tof_zones_t> = {{8, 4 * sizeof(float)},
                                         {12, 2 * sizeof(float) + sizeof(int8_t)}};
template <>
constexpr Arrays kArrays<rig_t> = {};
template <>
constexpr Arrays kArrays<seeds_t> = {{0, 4 * sizeof(float) + sizeof(int8_t) + 2 * sizeof(int16_t)}};
template <>
constexpr Arrays kArrays<prior_t> = {{20, 1}, {28, 1}};
template <>
constexpr Arrays kArrays<disparity_image_t> = {{20, 1}};
template <>
constexpr Arrays kArrays<depth_image_t> = {{40, 1}};
template <>
constexpr Arrays kArrays<point_cloud_t> = {{0, 3 * sizeof(float) + 4}};
template <>
constexpr Arrays kArrays<motion_t> = {};
template <>
constexpr Arrays kArrays<depth_counts_t> = {};
template <>
constexpr Arrays kArrays<stage_status_t> = {};
template <>
constexpr Arrays kArrays<process_info_t> = {};
template <>
constexpr Arrays kArrays<rig_change_t> = {};

// Strings right behind the header, in their order; no type has others.
using Strings = std::initializer_list<const char*>;
template <typename Message>
constexpr Strings kStrings = {};
template <>
constexpr Strings kStrings<stage_status_t> = {"stage", "host", "version", "config_digest",
                                              "last_error"};
template <>
constexpr Strings kStrings<process_info_t> = {"stage", "host", "version", "config_digest",
                                              "config_text"};
template <>
constexpr Strings kStrings<rig_change_t> = {"reason"};

// Big-endian int32 at `offset`.
Result<int32_t> ReadInt32(std::span<const uint8_t> bytes, size_t offset) {
  int32_t value = 0;
  if (offset > bytes.size() ||
      __int32_t_decode_array(bytes.data(), static_cast<int>(offset),
                             static_cast<int>(bytes.size() - offset), &value, 1) < 0) {
    return Fail("message cut short");
  }
  return value;
}

template <typename Message>
Result<void> CheckFingerprint(std::span<const uint8_t> bytes) {
  int64_t fingerprint = 0;
  if (__int64_t_decode_array(bytes.data(), 0, static_cast<int>(bytes.size()), &fingerprint, 1) <
          0 ||
      fingerprint != Message::getHash()) {
    return Fail(std::string("fingerprint is not that of ") + Message::getTypeName());
  }
  return {};
}

// Where a string ends that starts, with its length, at `offset`; an error when its length does not
// fit, or when its text does not end where its length says: it would be another one when sent on.
Result<size_t> EndOfString(std::span<const uint8_t> bytes, size_t offset, const char* field) {
  const Result<int32_t> length = ReadInt32(bytes, offset);
  if (!length) return tl::unexpected(length.error());
  const size_t start = offset + 4;
  if (*length < 1 || static_cast<size_t>(*length) > bytes.size() - start) {
    return Fail(std::string(field) + ": length " + std::to_string(*length) + " does not fit");
  }
  const auto text = bytes.subspan(start, static_cast<size_t>(*length));
  if (std::find(text.begin(), text.end(), uint8_t{0}) != text.end() - 1) {
    return Fail(std::string(field) + ": does not end where its length says");
  }
  return start + text.size();
}

constexpr size_t kRigIdOffset = 8 + 8 + 8;  // fingerprint, utime, seq

// The generated decoder believes the length of a string (a negative one makes it read far outside
// the message) and allocates what a count says before it looks whether the message is that long.
// Checks all of them first.
template <typename Message>
Result<void> CheckLengths(std::span<const uint8_t> bytes) {
  Result<size_t> end = EndOfString(bytes, kRigIdOffset, "header.rig_id");
  if (!end) return tl::unexpected(end.error());
  const size_t body = *end;
  for (const char* field : kStrings<Message>) {
    end = EndOfString(bytes, *end, field);
    if (!end) return tl::unexpected(end.error());
  }
  for (const CountedArray& array : kArrays<Message>) {
    const Result<int32_t> count = ReadInt32(bytes, body + array.count_offset);
    if (!count) return tl::unexpected(count.error());
    if (*count < 0 || static_cast<size_t>(*count) > bytes.size() / array.element_bytes) {
      return Fail("array count " + std::to_string(*count) + " does not fit a message of " +
                  std::to_string(bytes.size()) + " bytes");
    }
  }
  return {};
}

template <typename Message>
Result<void> CheckBeforeDecoding(std::span<const uint8_t> bytes) {
  if (bytes.size() > kMaxMessageBytes) {
    return Fail("message of " + std::to_string(bytes.size()) + " bytes: allowed are up to " +
                std::to_string(kMaxMessageBytes));
  }
  return CheckFingerprint<Message>(bytes).and_then([&] { return CheckLengths<Message>(bytes); });
}

Result<void> CheckIsWhole(size_t used, size_t size) {
  if (used > size) return Fail("message cut short");
  if (used < size) return Fail("message has " + std::to_string(size - used) + " bytes too many");
  return {};
}

template <typename Message>
Result<Message> DecodeMessage(std::span<const uint8_t> bytes) {
  if (const Result<void> fits = CheckBeforeDecoding<Message>(bytes); !fits) {
    return tl::unexpected(fits.error());
  }
  Message message;
  int used = -1;
  try {
    used = message.decode(bytes.data(), 0, static_cast<int>(bytes.size()));
  } catch (const std::exception& e) {  // out of memory
    return Fail(std::string("message cannot be decoded: ") + e.what());
  }
  if (used < 0) return Fail("message cut short");
  if (const auto whole = CheckIsWhole(static_cast<size_t>(used), bytes.size()); !whole) {
    return tl::unexpected(whole.error());
  }
  return message;
}

// A message whose bytes of data, which come last, stay where they are: megabytes that are copied
// once, into the image, instead of into a vector first.
template <typename Message>
struct MessageInPlace {
  Message fields;  // without data
  std::span<const uint8_t> data;
};

// @pre the message ends with the only array of its type, of bytes, behind their count `size`.
template <typename Message>
Result<MessageInPlace<Message>> DecodeInPlace(std::span<const uint8_t> bytes) {
  static_assert(kArrays<Message>.size() == 1 && kArrays<Message>.begin()->element_bytes == 1);
  if (const Result<void> fits = CheckBeforeDecoding<Message>(bytes); !fits) {
    return tl::unexpected(fits.error());
  }
  const size_t body = *EndOfString(bytes, kRigIdOffset, "header.rig_id");
  const size_t size_offset = body + kArrays<Message>.begin()->count_offset;
  const size_t data_offset = size_offset + sizeof(int32_t);
  const int32_t size = *ReadInt32(bytes, size_offset);  // not negative: CheckLengths()
  const auto whole = CheckIsWhole(data_offset + static_cast<size_t>(size), bytes.size());
  if (!whole) return tl::unexpected(whole.error());
  // Decoded as a message that has no data.
  std::vector<uint8_t> without(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(data_offset));
  std::fill(without.end() - sizeof(int32_t), without.end(), uint8_t{0});
  MessageInPlace<Message> message;
  const int used = message.fields.decode(without.data(), 0, static_cast<int>(without.size()));
  if (used < 0) return Fail("message cut short");
  message.fields.size = size;
  message.data = bytes.subspan(data_offset);
  return message;
}

bool IsCompressed(const image_t& message) {
  return message.pixel_format == image_t::PIXEL_FORMAT_MJPG;
}
bool IsCompressed(const prior_t& message) {
  return message.encoding == prior_t::ENCODING_DELTA_ZSTD;
}
bool IsCompressed(const disparity_image_t& message) {
  return message.encoding == disparity_image_t::ENCODING_DELTA_ZSTD;
}

template <typename Message, typename ToValue>
Result<DecodedPart> ToPart(const Message& message,
                           [[maybe_unused]] std::optional<cv::Size> expected,
                           const ToValue& to_value) {
  Result<FrameId> id = FromMessage(message.header);
  if (!id) return tl::unexpected(id.error());
  if (id->seq < 0) return Fail("header.seq = " + std::to_string(id->seq) + ": allowed is >= 0");
  if constexpr (requires { IsCompressed(message); }) {
    if (IsCompressed(message)) {
      const auto fits = CheckCompressedSize({message.width, message.height}, expected);
      if (!fits) return tl::unexpected(fits.error());
    }
  }
  auto value = to_value();
  if (!value) return tl::unexpected(value.error());
  return DecodedPart{std::move(*id), std::move(*value)};
}

// Values of images share the pixels with `memory`, in which `bytes` are, if it is not empty.
template <typename Message>
Result<DecodedPart> Decode(std::span<const uint8_t> bytes, std::optional<cv::Size> expected,
                           [[maybe_unused]] const cv::Mat1b& memory) {
  if constexpr (requires(const Message& message) { FromMessage(message, bytes); }) {
    return DecodeInPlace<Message>(bytes).and_then([&](const MessageInPlace<Message>& message) {
      return ToPart(message.fields, expected, [&] {
        if constexpr (std::is_same_v<Message, image_t>) {
          return FromMessage(message.fields, message.data, memory);
        } else {
          return FromMessage(message.fields, message.data);
        }
      });
    });
  } else {
    return DecodeMessage<Message>(bytes).and_then([&](const Message& message) {
      return ToPart(message, expected, [&] { return FromMessage(message); });
    });
  }
}

constexpr auto kFromMessage = [](const auto& message) { return FromMessage(message); };

// The message that carries a value of a part.
template <typename Value>
auto MessageOf(const FrameId& id, const Value& value, DisparityEncoding encoding) {
  if constexpr (requires { ToMessage(id, value, encoding); }) {
    return ToMessage(id, value, encoding);
  } else {
    return ToMessage(id, value);
  }
}

// The value in a member of Frame.
const cv::Mat& ValueIn(const cv::Mat& member) { return member; }
template <typename Value>
const Value& ValueIn(const std::optional<Value>& member) {
  return *member;
}

template <typename Member>
using MessageFor = decltype(MessageOf({}, ValueIn(std::declval<Member>()), {}));

}  // namespace

std::vector<uint8_t> EncodePart(const FrameId& id, [[maybe_unused]] Part part,
                                const PartValue& value, DisparityEncoding encoding) {
  assert(value.index() == RowOf(part).member.index());
  return std::visit(
      [&](const auto& content) { return EncodeMessage(MessageOf(id, content, encoding)); }, value);
}

Result<DecodedPart> DecodePart(Part part, std::span<const uint8_t> bytes,
                               std::optional<cv::Size> expected, const cv::Mat1b& memory) {
  if (IsPacked(bytes)) {
    return Unpack(bytes, expected).and_then([&](const std::vector<uint8_t>& message) {
      return DecodePart(part, message, expected);  // which is not packed: no such type is
    });
  }
  Result<DecodedPart> decoded = std::visit(
      [&]<typename Member>(Member Frame::*) {
        return Decode<MessageFor<Member>>(bytes, expected, memory);
      },
      RowOf(part).member);
  // Only in the robot's frame may a point lie behind the origin.
  if (!decoded || part == Part::kBaseCloud) return decoded;
  if (const PointCloud* const cloud = std::get_if<PointCloud>(&decoded->value)) {
    if (const Result<void> in_front = CheckInFront(*cloud); !in_front) {
      return tl::unexpected(in_front.error());
    }
  }
  return decoded;
}

std::vector<uint8_t> EncodeStatus(const StageStatus& status) {
  return EncodeMessage(ToMessage(status));
}

Result<StageStatus> DecodeStatus(std::span<const uint8_t> bytes) {
  return DecodeMessage<stage_status_t>(bytes).and_then(kFromMessage);
}

std::vector<uint8_t> EncodeProcessInfo(const ProcessInfo& info) {
  return EncodeMessage(ToMessage(info));
}

Result<ProcessInfo> DecodeProcessInfo(std::span<const uint8_t> bytes) {
  return DecodeMessage<process_info_t>(bytes).and_then(kFromMessage);
}

std::vector<uint8_t> EncodeRigChange(const RigChange& change) {
  return EncodeMessage(ToMessage(change));
}

Result<RigChange> DecodeRigChange(std::span<const uint8_t> bytes) {
  return DecodeMessage<rig_change_t>(bytes).and_then(kFromMessage);
}

Result<FrameId> DecodeFrameId(std::span<const uint8_t> bytes) {
  const Result<size_t> end = EndOfString(bytes, kRigIdOffset, "header.rig_id");
  if (!end) return tl::unexpected(end.error());
  header_t header;
  const auto size = static_cast<int>(*end);
  __int64_t_decode_array(bytes.data(), 8, size, &header.utime, 1);
  __int64_t_decode_array(bytes.data(), 16, size, &header.seq, 1);
  header.rig_id.assign(reinterpret_cast<const char*>(&bytes[kRigIdOffset + 4]),
                       *end - kRigIdOffset - 4 - 1);
  return FromMessage(header);
}

}  // namespace sprout
