#define ZSTD_STATIC_LINKING_ONLY  // for ZSTD_c_literalCompressionMode
#include "common/messages/packed.h"

#include <zstd.h>

#include <algorithm>
#include <cassert>
#include <lcmtypes/sprout/disparity_image_t.hpp>
#include <lcmtypes/sprout/image_t.hpp>
#include <lcmtypes/sprout/packed_t.hpp>
#include <lcmtypes/sprout/prior_t.hpp>
#include <stdexcept>
#include <string>

#include "common/core/image.h"
#include "common/messages/compressor.h"
#include "common/messages/convert.h"
#include "common/messages/packed_layout.h"
#include "common/messages/pixel_prediction.h"

namespace sprout {
namespace {

using PackedBytes = std::vector<uint8_t>;

// Errors of prediction do not repeat, so all that is left is to give frequent ones short codes: by
// a level that hardly looks for repetitions, and codes that such levels leave out. Measured in
// services/record/NOTES.md.
constexpr int kPixelLevel = -1000;
// Differences of maps repeat where they are 0.
constexpr int kMapLevel = 1;
// What is left of a message must be worth the unpacking.
constexpr double kWorthWhile = 0.95;
constexpr size_t kCountBytes = 4;

// Bytes of a packed_t from the end of its header to its data.
constexpr size_t kFieldBytes = 8 + 5 * 4;

void AppendInt32(PackedBytes& bytes, size_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<uint8_t>(number >> shift & 0xff));
  }
}

// An element of an array as a number, and back.
uint32_t ElementAt(const uint8_t* bytes, const PackedArray& array) {
  uint32_t number = 0;
  for (size_t k = 0; k < array.element_bytes; ++k) {
    const size_t at = array.little_endian ? array.element_bytes - 1 - k : k;
    number = number << 8 | bytes[at];
  }
  return number;
}

void PutElement(uint32_t number, const PackedArray& array, uint8_t* bytes) {
  for (size_t k = array.element_bytes; k-- > 0; number >>= 8) {
    bytes[array.little_endian ? array.element_bytes - 1 - k : k] =
        static_cast<uint8_t>(number & 0xff);
  }
}

// Differences to the left neighbour, byte by byte of all elements: METHOD_DIFFERENCES.
void PutDifferences(const uint8_t* from, const PackedArray& array, uint8_t* to) {
  uint32_t before = 0;
  for (size_t i = 0; i < array.count; ++i) {
    if (i % array.row == 0) before = 0;
    const uint32_t element = ElementAt(from + i * array.element_bytes, array);
    uint32_t difference = element - before;
    before = element;
    for (size_t k = array.element_bytes; k-- > 0; difference >>= 8) {
      to[k * array.count + i] = static_cast<uint8_t>(difference & 0xff);
    }
  }
}

void TakeDifferences(const uint8_t* from, const PackedArray& array, uint8_t* to) {
  uint32_t element = 0;
  for (size_t i = 0; i < array.count; ++i) {
    if (i % array.row == 0) element = 0;
    uint32_t difference = 0;
    for (size_t k = 0; k < array.element_bytes; ++k) {
      difference = difference << 8 | from[k * array.count + i];
    }
    element += difference;
    PutElement(element, array, to + i * array.element_bytes);
  }
}

bool IsWhole(const PackedArray& array) {
  return array.count == 0 || (array.row > 0 && array.count % array.row == 0);
}

// The layout of a message with arrays; nothing if their rows are not whole.
std::optional<PackedLayout> UsableLayoutOf(std::span<const uint8_t> head, size_t message_bytes) {
  std::optional<PackedLayout> layout = LayoutOf(head, message_bytes);
  if (layout && !std::ranges::all_of(layout->arrays, IsWhole)) layout.reset();
  return layout;
}

int32_t MethodOf(const PackedLayout& layout) {
  if (layout.channels > 0) return packed_t::METHOD_PREDICTED_PIXELS;
  return packed_t::METHOD_DIFFERENCES;
}

// Types whose compressed encodings DecodePart() checks in the same way.
bool IsMapOfTheImages(uint64_t fingerprint) {
  return fingerprint == static_cast<uint64_t>(image_t::getHash()) ||
         fingerprint == static_cast<uint64_t>(prior_t::getHash()) ||
         fingerprint == static_cast<uint64_t>(disparity_image_t::getHash());
}

// The fields of a packed message, and its data.
struct PackedFields {
  uint64_t fingerprint = 0;
  int32_t width = 0;
  int32_t height = 0;
  size_t message_bytes = 0;
  int32_t method = 0;
  std::span<const uint8_t> header;  // of the message
  std::span<const uint8_t> data;
};

Result<PackedFields> FieldsOf(std::span<const uint8_t> packed) {
  const std::optional<size_t> begin = EndOfHeader(packed);
  if (!begin || packed.size() - *begin < kFieldBytes) return Fail("message cut short");
  const auto number = [&](size_t place) { return *Int32At(packed, *begin + 8 + 4 * place); };
  const int32_t bytes = number(2);
  const size_t data_offset = *begin + kFieldBytes;
  if (number(4) < 0 || static_cast<size_t>(number(4)) != packed.size() - data_offset) {
    return Fail("size = " + std::to_string(number(4)) + ": allowed is the number of bytes in data");
  }
  if (bytes < 1 || static_cast<size_t>(bytes) > kMaxMessageBytes) {
    return Fail("message_size = " + std::to_string(bytes) + ": allowed are 1 to " +
                std::to_string(kMaxMessageBytes));
  }
  return PackedFields{.fingerprint = FingerprintAt(packed, *begin),
                      .width = number(0),
                      .height = number(1),
                      .message_bytes = static_cast<size_t>(bytes),
                      .method = number(3),
                      .header = packed.subspan(8, *begin - 8),
                      .data = packed.subspan(data_offset)};
}

// The pixels from what follows the head in the frame: counts, then errors.
Result<void> UnpackPixels(std::span<const uint8_t> frame, const PackedLayout& layout,
                          std::span<uint8_t> pixels) {
  size_t at = kCountBytes * kPixelClasses * layout.channels;
  std::vector<ClassedErrors> errors(layout.channels);
  for (size_t i = 0; i < layout.channels * kPixelClasses; ++i) {
    const auto count = static_cast<size_t>(*Int32At(frame, kCountBytes * i));
    if (count > frame.size() - at) return Fail("data: a class has more pixels than the image");
    errors[i / kPixelClasses][i % kPixelClasses] = frame.subspan(at, count);
    at += count;
  }
  const auto width = static_cast<size_t>(layout.width);
  if (at != frame.size() || !Reconstruct(errors, width, pixels)) {
    return Fail("data: the classes have other pixels than the image");
  }
  return {};
}

}  // namespace

struct MessagePacker::Scratch {
  struct Deleter {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };

  // Begins a frame of so many bytes.
  void Begin(size_t bytes, int level) {
    ZSTD_CCtx_reset(zstd.get(), ZSTD_reset_session_and_parameters);
    ZSTD_CCtx_setParameter(zstd.get(), ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(zstd.get(), ZSTD_c_literalCompressionMode, ZSTD_ps_enable);
    ZSTD_CCtx_setPledgedSrcSize(zstd.get(), bytes);
    // Each piece may end a block.
    frame.resize(ZSTD_compressBound(bytes) + 64 * (3 * kPixelClasses + 2));
    out = {frame.data(), frame.size(), 0};
  }

  // A piece has codes of its own.
  void Add(std::span<const uint8_t> piece, ZSTD_EndDirective end) {
    ZSTD_inBuffer in{piece.data(), piece.size(), 0};
    const size_t left = ZSTD_compressStream2(zstd.get(), &out, &in, end);
    if (ZSTD_isError(left) != 0) {
      throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(left));
    }
    assert(left == 0 && in.pos == in.size);
  }

  void PackPixels(std::span<const uint8_t> message, const PackedLayout& layout) {
    const auto classed = predictor.Predict(message.subspan(layout.head_bytes),
                                           static_cast<size_t>(layout.width), layout.channels);
    transformed.assign(message.begin(),
                       message.begin() + static_cast<std::ptrdiff_t>(layout.head_bytes));
    for (const ClassedErrors& channel : classed) {
      for (const auto& errors : channel) AppendInt32(transformed, errors.size());
    }
    Begin(message.size() + kCountBytes * kPixelClasses * layout.channels, kPixelLevel);
    Add(transformed, ZSTD_e_flush);
    for (const ClassedErrors& channel : classed) {
      for (const auto& errors : channel) Add(errors, ZSTD_e_flush);
    }
    Add({}, ZSTD_e_end);
  }

  void PackArrays(std::span<const uint8_t> message, const PackedLayout& layout) {
    transformed.resize(message.size());
    std::ranges::copy(message.first(layout.head_bytes), transformed.begin());
    size_t at = layout.head_bytes;
    for (const PackedArray& array : layout.arrays) {
      PutDifferences(message.data() + at, array, transformed.data() + at);
      at += array.bytes();
    }
    Begin(message.size(), kMapLevel);
    Add(transformed, ZSTD_e_end);
  }

  std::unique_ptr<ZSTD_CCtx, Deleter> zstd{ZSTD_createCCtx()};
  PixelPredictor predictor;
  PackedBytes transformed;
  PackedBytes frame;
  ZSTD_outBuffer out{};
};

MessagePacker::MessagePacker() : scratch_(std::make_unique<Scratch>()) {}

MessagePacker::~MessagePacker() = default;

std::optional<PackedBytes> MessagePacker::Pack(std::span<const uint8_t> message) {
  const std::optional<PackedLayout> layout = UsableLayoutOf(message, message.size());
  if (!layout || message.size() > kMaxMessageBytes ||
      int64_t{layout->width} * layout->height > kMaxCompressedPixels) {
    return std::nullopt;
  }
  layout->channels > 0 ? scratch_->PackPixels(message, *layout)
                       : scratch_->PackArrays(message, *layout);
  const size_t frame_bytes = scratch_->out.pos;
  const size_t header_end = *EndOfHeader(message);
  if (static_cast<double>(header_end + kFieldBytes + frame_bytes) >
      kWorthWhile * static_cast<double>(message.size())) {
    return std::nullopt;
  }
  PackedBytes packed;
  packed.reserve(header_end + kFieldBytes + frame_bytes);
  const auto fingerprint = static_cast<uint64_t>(packed_t::getHash());
  AppendInt32(packed, fingerprint >> 32);
  AppendInt32(packed, fingerprint & 0xffffffff);
  packed.insert(packed.end(), message.begin() + 8,
                message.begin() + static_cast<std::ptrdiff_t>(header_end));
  packed.insert(packed.end(), message.begin(), message.begin() + 8);
  const int32_t numbers[] = {layout->width, layout->height, static_cast<int32_t>(message.size()),
                             MethodOf(*layout), static_cast<int32_t>(frame_bytes)};
  for (const int32_t number : numbers) AppendInt32(packed, static_cast<uint32_t>(number));
  packed.insert(packed.end(), scratch_->frame.begin(),
                scratch_->frame.begin() + static_cast<std::ptrdiff_t>(frame_bytes));
  return packed;
}

bool IsPacked(std::span<const uint8_t> message) {
  return message.size() >= 8 &&
         FingerprintAt(message, 0) == static_cast<uint64_t>(packed_t::getHash());
}

std::optional<uint64_t> PackedFingerprint(std::span<const uint8_t> message) {
  const std::optional<size_t> begin = EndOfHeader(message);
  if (!begin || message.size() - *begin < 8) return std::nullopt;
  return FingerprintAt(message, *begin);
}

Result<void> CheckCompressedSize(cv::Size size, std::optional<cv::Size> expected) {
  if (int64_t{size.width} * size.height > kMaxCompressedPixels) {
    return Fail("width x height = " + SizeText(size) + ": allowed for compressed data are up to " +
                std::to_string(kMaxCompressedPixels) + " pixels");
  }
  if (!expected || size == *expected) return {};
  return Fail("width x height = " + SizeText(size) +
              ": allowed for compressed data is the size of the frame's images, " +
              SizeText(*expected));
}

Result<PackedBytes> Unpack(std::span<const uint8_t> packed, std::optional<cv::Size> expected) {
  if (!IsPacked(packed)) return Fail("fingerprint is not that of packed_t");
  const Result<PackedFields> fields = FieldsOf(packed);
  if (!fields) return tl::unexpected(fields.error());
  if (IsMapOfTheImages(fields->fingerprint)) {
    const Result<void> fits = CheckCompressedSize({fields->width, fields->height}, expected);
    if (!fits) return tl::unexpected(fits.error());
  }
  // Packed pixels also have the counts of the classes, of one or three channels.
  const uint64_t declared = ZSTD_getFrameContentSize(fields->data.data(), fields->data.size());
  const bool has_pixels = fields->method == packed_t::METHOD_PREDICTED_PIXELS;
  const size_t most_counts = has_pixels ? 3 * kPixelClasses * kCountBytes : 0;
  const size_t frame_bytes =
      declared >= fields->message_bytes && declared <= fields->message_bytes + most_counts
          ? static_cast<size_t>(declared)
          : fields->message_bytes;
  const Result<PackedBytes> frame =
      DecompressZstd(fields->data, frame_bytes, "data", "message_size");
  if (!frame) return tl::unexpected(frame.error());

  const std::optional<PackedLayout> layout = UsableLayoutOf(*frame, fields->message_bytes);
  const std::span<const uint8_t> head = *frame;
  if (!layout || MethodOf(*layout) != fields->method ||
      FingerprintAt(head, 0) != fields->fingerprint || layout->width != fields->width ||
      layout->height != fields->height || fields->header.size() > head.size() - 8 ||
      !std::ranges::equal(head.subspan(8, fields->header.size()), fields->header)) {
    return Fail("data: not the message that the other fields describe");
  }
  const size_t counts = kCountBytes * kPixelClasses * layout->channels;
  if (frame->size() != fields->message_bytes + counts) {
    return Fail("data: of " + std::to_string(frame->size()) + " bytes");
  }
  PackedBytes message(fields->message_bytes);
  std::copy_n(frame->begin(), layout->head_bytes, message.begin());
  if (layout->channels > 0) {
    const Result<void> done = UnpackPixels(head.subspan(layout->head_bytes), *layout,
                                           std::span(message).subspan(layout->head_bytes));
    if (!done) return tl::unexpected(done.error());
    return message;
  }
  size_t at = layout->head_bytes;
  for (const PackedArray& array : layout->arrays) {
    TakeDifferences(frame->data() + at, array, message.data() + at);
    at += array.bytes();
  }
  return message;
}

}  // namespace sprout
