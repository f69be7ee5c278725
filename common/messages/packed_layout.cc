#include "common/messages/packed_layout.h"

#include <lcmtypes/sprout/depth_image_t.hpp>
#include <lcmtypes/sprout/disparity_image_t.hpp>
#include <lcmtypes/sprout/image_t.hpp>
#include <lcmtypes/sprout/point_cloud_t.hpp>
#include <lcmtypes/sprout/prior_t.hpp>
#include <lcmtypes/sprout/seeds_t.hpp>
#include <lcmtypes/sprout/tof_image_t.hpp>

#include "common/core/image.h"

namespace sprout {
namespace {

// The int32 fields behind the header, by their places among them. Doubles take two.
class Int32Fields {
 public:
  Int32Fields(std::span<const uint8_t> head, size_t begin) : head_(head), begin_(begin) {}

  /// 0 behind the end: no message has it where it matters.
  int32_t operator[](size_t place) const { return Int32At(head_, begin_ + 4 * place).value_or(0); }
  size_t Count(size_t place) const {
    const int32_t count = (*this)[place];
    return count < 0 ? 0 : static_cast<size_t>(count);
  }
  size_t EndOf(size_t count) const { return begin_ + 4 * count; }

 private:
  std::span<const uint8_t> head_;
  size_t begin_;
};

constexpr bool kLittleEndian = true;

// Layout of a type that begins with width and height.
PackedLayout MapLayout(const Int32Fields& fields, size_t count) {
  PackedLayout layout;
  layout.head_bytes = fields.EndOf(count);
  layout.width = fields[0];
  layout.height = fields[1];
  return layout;
}

// The layouts of the types, by their fields; the caller compares them with the message's size.
PackedLayout OfImage(const Int32Fields& fields) {
  PackedLayout layout = MapLayout(fields, 5);
  const int32_t format = fields[3];
  if (format == image_t::PIXEL_FORMAT_GREY) layout.channels = 1;
  if (format == image_t::PIXEL_FORMAT_RGB3 || format == image_t::PIXEL_FORMAT_BGR3) {
    layout.channels = 3;
  }
  const size_t row = fields.Count(0) * layout.channels;
  if (row == fields.Count(2) && row * fields.Count(1) == fields.Count(4)) {
    layout.arrays = {{row * fields.Count(1), 1, row}};
  }
  return layout;
}

PackedLayout OfTof(const Int32Fields& fields) {
  const size_t row = fields.Count(0);
  PackedLayout layout = MapLayout(fields, 4);
  layout.arrays = {{fields.Count(2), 4, row}, {fields.Count(3), 4, row}};
  return layout;
}

PackedLayout OfPrior(const Int32Fields& fields) {
  PackedLayout layout = MapLayout(fields, 8);
  if (fields[2] != prior_t::ENCODING_RAW || fields.Count(5) % 2 != 0) return layout;
  const size_t row = fields.Count(0);
  layout.arrays = {{fields.Count(5) / 2, 2, row, kLittleEndian}, {fields.Count(7), 1, row}};
  return layout;
}

PackedLayout OfDisparity(const Int32Fields& fields) {
  PackedLayout layout = MapLayout(fields, 6);
  if (fields[2] != disparity_image_t::ENCODING_RAW_INT16 || fields.Count(5) % 2 != 0) return layout;
  layout.arrays = {{fields.Count(5) / 2, 2, fields.Count(0), kLittleEndian}};
  return layout;
}

PackedLayout OfDepth(const Int32Fields& fields) {
  PackedLayout layout = MapLayout(fields, 11);
  if (fields.Count(10) % 2 != 0) return layout;
  layout.arrays = {{fields.Count(10) / 2, 2, fields.Count(0), kLittleEndian}};
  return layout;
}

PackedLayout OfCloud(const Int32Fields& fields) {
  const size_t count = fields.Count(0);
  PackedLayout layout;
  layout.head_bytes = fields.EndOf(1);
  for (const size_t bytes : {4, 4, 4, 1, 1, 1, 1}) layout.arrays.push_back({count, bytes, count});
  return layout;
}

PackedLayout OfSeeds(const Int32Fields& fields) {
  const size_t count = fields.Count(0);
  PackedLayout layout;
  layout.head_bytes = fields.EndOf(8);
  for (const size_t bytes : {4, 4, 4, 4, 1, 2, 2}) layout.arrays.push_back({count, bytes, count});
  return layout;
}

struct LayoutRow {
  uint64_t fingerprint;
  PackedLayout (*layout)(const Int32Fields& fields);
};

template <typename Message>
LayoutRow RowFor(PackedLayout (*layout)(const Int32Fields&)) {
  return {static_cast<uint64_t>(Message::getHash()), layout};
}

bool Fits(const PackedLayout& layout, size_t message_bytes) {
  size_t bytes = layout.head_bytes;
  for (const PackedArray& array : layout.arrays) bytes += array.bytes();
  const bool is_map = layout.width > 0 && layout.height > 0 && layout.width <= kMaxSide &&
                      layout.height <= kMaxSide &&
                      int64_t{layout.width} * layout.height <= kMaxPixels;
  const bool is_none = layout.width == 0 && layout.height == 0;
  return !layout.arrays.empty() && bytes == message_bytes && (is_map || is_none);
}

}  // namespace

uint64_t FingerprintAt(std::span<const uint8_t> bytes, size_t offset) {
  uint64_t fingerprint = 0;
  for (const uint8_t byte : bytes.subspan(offset, 8)) fingerprint = fingerprint << 8 | byte;
  return fingerprint;
}

std::optional<int32_t> Int32At(std::span<const uint8_t> bytes, size_t offset) {
  if (offset > bytes.size() || bytes.size() - offset < 4) return std::nullopt;
  uint32_t number = 0;
  for (const uint8_t byte : bytes.subspan(offset, 4)) number = number << 8 | byte;
  return static_cast<int32_t>(number);
}

std::optional<size_t> EndOfHeader(std::span<const uint8_t> message) {
  constexpr size_t kRigIdOffset = 8 + 8 + 8;
  const std::optional<int32_t> length = Int32At(message, kRigIdOffset);
  if (!length || *length < 1) return std::nullopt;
  const size_t end = kRigIdOffset + 4 + static_cast<size_t>(*length);
  return end <= message.size() ? std::optional(end) : std::nullopt;
}

std::optional<PackedLayout> LayoutOf(std::span<const uint8_t> head, size_t message_bytes) {
  static const LayoutRow rows[] = {
      RowFor<image_t>(&OfImage),       RowFor<tof_image_t>(&OfTof),
      RowFor<prior_t>(&OfPrior),       RowFor<disparity_image_t>(&OfDisparity),
      RowFor<depth_image_t>(&OfDepth), RowFor<point_cloud_t>(&OfCloud),
      RowFor<seeds_t>(&OfSeeds)};
  const std::optional<size_t> begin = EndOfHeader(head);
  if (!begin) return std::nullopt;
  const uint64_t fingerprint = FingerprintAt(head, 0);
  for (const LayoutRow& row : rows) {
    if (row.fingerprint != fingerprint) continue;
    PackedLayout layout = row.layout(Int32Fields(head, *begin));
    if (Fits(layout, message_bytes) && layout.head_bytes <= head.size()) return layout;
  }
  return std::nullopt;
}

}  // namespace sprout
