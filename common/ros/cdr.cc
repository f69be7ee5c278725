#include "common/ros/cdr.h"

#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsrt/endian.h>
#include <dds/ddsrt/heap.h>

#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

namespace sprout {
namespace {

// Two bytes for plain CDR, big or little endian, and two for options, which are 0.
constexpr size_t kHeaderBytes = 4;
constexpr uint8_t kBigEndian = 0;
constexpr uint8_t kLittleEndian = 1;
constexpr bool kIsLittle = std::endian::native == std::endian::little;

// DDS carries no longer ones, and dds_ostream counts with 32 bits.
constexpr size_t kMaxBytes = size_t{1} << 31;

// The layout of a type, in Cyclone's words.
const uint32_t* OpsOf(const RosType& type) { return type.dds->m_ops; }

}  // namespace

void FreeRosFields(const RosType& type, void* message) {
  dds_stream_free_sample(message, OpsOf(type));
}

void SetRosText(char*& field, std::string_view text) {
  ddsrt_free(field);
  field = static_cast<char*>(ddsrt_malloc(text.size() + 1));
  std::memcpy(field, text.data(), text.size());
  field[text.size()] = '\0';
}

void* NewRosElements(size_t count, size_t bytes_each) { return ddsrt_calloc(count, bytes_each); }

void WriteCdr(const AnyRosMessage& message, std::vector<uint8_t>& bytes) {
  dds_ostream_t stream;
  dds_ostream_init(&stream, 0, CDR_ENC_VERSION_1);
  const uint32_t* const end =
      dds_stream_write(&stream, static_cast<const char*>(message.data()), OpsOf(message.type()));
  const size_t size = stream.m_index;
  const bool fits = end != nullptr && size <= kMaxBytes;
  if (fits) {
    bytes.resize(kHeaderBytes + size);
    bytes[0] = 0;
    bytes[1] = kIsLittle ? kLittleEndian : kBigEndian;
    bytes[2] = 0;
    bytes[3] = 0;
    std::memcpy(bytes.data() + kHeaderBytes, stream.m_buffer, size);
  }
  dds_ostream_fini(&stream);
  if (!fits) throw std::runtime_error(std::string(message.type().name) + ": too long for CDR");
}

Result<void> ReadCdr(const RosType& type, std::span<const uint8_t> bytes, void* message) {
  const std::string name = type.name;
  if (bytes.size() <= kHeaderBytes || bytes.size() > kMaxBytes) {
    return Fail(name + ": " + std::to_string(bytes.size()) +
                " bytes; allowed: 4 bytes of header and CDR behind them, up to 2 GB");
  }
  if (bytes[0] != 0 || bytes[1] > kLittleEndian) {
    return Fail(name + ": encapsulation " + std::to_string(256 * bytes[0] + bytes[1]) +
                "; allowed: 0 (CDR, big endian) and 1 (CDR, little endian)");
  }
  // Cyclone checks and swaps in place, in memory that is aligned as the fields are.
  std::vector<uint64_t> words((bytes.size() - kHeaderBytes + 7) / 8);
  const auto size = static_cast<uint32_t>(bytes.size() - kHeaderBytes);
  std::memcpy(words.data(), bytes.data() + kHeaderBytes, size);
  uint32_t used = 0;
  const bool swap = (bytes[1] == kLittleEndian) != kIsLittle;
  if (dds_stream_normalize_data(reinterpret_cast<char*>(words.data()), &used, size, swap,
                                CDR_ENC_VERSION_1, OpsOf(type)) == nullptr) {
    return Fail(name + ": not whole CDR: a length, string or boolean in its " +
                std::to_string(size) + " bytes cannot be");
  }
  dds_istream_t stream;
  dds_istream_init(&stream, size, words.data(), CDR_ENC_VERSION_1);
  dds_stream_read(&stream, static_cast<char*>(message), OpsOf(type));
  dds_istream_fini(&stream);
  return {};
}

}  // namespace sprout
