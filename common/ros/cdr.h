#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/core/result.h"
#include "common/ros/ros_type.h"

namespace sprout {

/// Any message, for those who only pass it on.
class AnyRosMessage {
 public:
  virtual ~AnyRosMessage() = default;
  virtual const RosType& type() const = 0;
  virtual const void* data() const = 0;  ///< idlc's structure
};

/// Frees what a structure holds, by its type's layout.
void FreeRosFields(const RosType& type, void* message);

/// A message: idlc's structure, with what its strings and sequences point to. The functions below
/// fill it; bulk data is borrowed from an image that it keeps alive, not copied.
template <typename T>
class RosMessage : public AnyRosMessage {
 public:
  RosMessage() = default;
  ~RosMessage() override { Free(); }
  RosMessage(RosMessage&& other) noexcept
      : value_(std::exchange(other.value_, {})), keep_(std::move(other.keep_)) {}
  RosMessage& operator=(RosMessage&& other) noexcept {
    if (this != &other) {
      Free();
      value_ = std::exchange(other.value_, {});
      keep_ = std::move(other.keep_);
    }
    return *this;
  }

  T& operator*() { return value_; }
  const T& operator*() const { return value_; }
  T* operator->() { return &value_; }
  const T* operator->() const { return &value_; }

  /// Keeps alive what borrowed data points to.
  void Keep(std::shared_ptr<const void> what) { keep_ = std::move(what); }

  const RosType& type() const override { return RosTypeOf<T>(); }
  const void* data() const override { return &value_; }

 private:
  void Free() { FreeRosFields(RosTypeOf<T>(), &value_); }

  T value_{};
  std::shared_ptr<const void> keep_;
};

/// Sets a string of a message, whose own is freed.
void SetRosText(char*& field, std::string_view text);

/// The text of a string of a message; empty when there is none.
inline std::string_view RosText(const char* field) { return field ? field : ""; }

/// The elements of a sequence of a message.
template <typename Sequence>
auto RosSpan(const Sequence& sequence) {
  return std::span(sequence._buffer, sequence._buffer ? sequence._length : 0);
}

/// Memory for a sequence of a message, all zero.
void* NewRosElements(size_t count, size_t bytes_each);

/// Makes a sequence of `count` elements that are all zero. @pre it had none.
template <typename Sequence>
auto ResizeRos(Sequence& sequence, size_t count) {
  using Element = std::remove_pointer_t<decltype(sequence._buffer)>;
  sequence._buffer =
      count == 0 ? nullptr : static_cast<Element*>(NewRosElements(count, sizeof(Element)));
  sequence._length = static_cast<uint32_t>(count);
  sequence._maximum = sequence._length;
  sequence._release = true;
  return std::span(sequence._buffer, count);
}

/// Lets a sequence of bytes point to memory that somebody else owns.
template <typename Sequence>
void BorrowRos(Sequence& sequence, const uint8_t* bytes, size_t count) {
  sequence._buffer = const_cast<uint8_t*>(bytes);  // NOLINT: never written through
  sequence._length = static_cast<uint32_t>(count);
  sequence._maximum = sequence._length;
  sequence._release = false;
}

/// The message as CDR (XCDR version 1) in this machine's byte order, behind the four bytes that
/// say so: what travels and what rosbag2 stores. By Cyclone DDS's own serializer, so the bytes are
/// those of the live topic.
/// @throws std::runtime_error when a message is longer than 2 GB.
/// @param bytes  is overwritten; its memory is used again.
void WriteCdr(const AnyRosMessage& message, std::vector<uint8_t>& bytes);

/// Reads a message of either byte order into an empty structure. Lengths are checked before memory
/// is taken, and strings and booleans are what they must be; the values may be any.
Result<void> ReadCdr(const RosType& type, std::span<const uint8_t> bytes, void* message);

template <typename T>
Result<RosMessage<T>> ReadCdr(std::span<const uint8_t> bytes) {
  RosMessage<T> message;
  if (Result<void> read = ReadCdr(RosTypeOf<T>(), bytes, &*message); !read) {
    return tl::unexpected(read.error());
  }
  return message;
}

}  // namespace sprout
