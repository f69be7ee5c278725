#include "services/tools/check/bad_messages.h"

#include <limits>
#include <random>
#include <utility>

#include "common/messages/message_type.h"

namespace sprout::check {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr size_t kFingerprintBytes = 8;
constexpr size_t kRigIdOffset = 24;  // length of header.rig_id, behind fingerprint, utime and seq
constexpr unsigned kRandomMessages = 4;

int32_t ReadInt32(const Bytes& bytes, size_t offset) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | bytes[offset + i];
  return static_cast<int32_t>(value);
}

Bytes WithInt32(Bytes bytes, size_t offset, int32_t value) {
  for (size_t i = 0; i < 4; ++i) {
    bytes[offset + i] = static_cast<uint8_t>(static_cast<uint32_t>(value) >> (24 - 8 * i));
  }
  return bytes;
}

// Offset of the first byte behind the header.
size_t BodyOf(const Bytes& good) {
  return kRigIdOffset + 4 + static_cast<size_t>(ReadInt32(good, kRigIdOffset));
}

Bytes Cut(Bytes bytes, size_t length) {
  bytes.resize(length);
  return bytes;
}

Bytes WithRandomBytes(Bytes bytes, size_t from, unsigned seed) {
  std::mt19937 random(seed);
  for (size_t i = from; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(random());
  return bytes;
}

// The int32 fields right behind the header of which any other value makes the message bad.
std::vector<std::string> SizeFields(Part part) {
  switch (TypeOf(part)) {
    case MessageType::kImage:
      return {"width", "height", "row_stride", "pixel_format", "size"};
    case MessageType::kTof:
      return {"width", "height", "count", "amplitude_count"};
    case MessageType::kRig:
      return {"width", "height"};
    case MessageType::kSeeds:
      return {"count"};
    case MessageType::kPrior:
      return {"width",
              "height",
              "encoding",
              "counts_per_px",
              "invalid",
              "size",
              "sigma_counts_per_px",
              "sigma_size"};
    case MessageType::kDisparity:
      return {"width", "height", "encoding", "counts_per_px", "invalid", "size"};
    case MessageType::kDepth:
      return {"width", "height"};
    case MessageType::kCloud:
      return {"count"};
    case MessageType::kMotion:
      return {"tracked", "reset"};
    case MessageType::kDepthCounts:
      return {"pixels"};
    case MessageType::kTofZones:
      return {"columns", "rows", "zone_count", "target_count", "targets_per_zone", "mode"};
    case MessageType::kStatus:
    case MessageType::kProcess:
    case MessageType::kRigChange:
      break;
  }
  return {};
}

void AddCuts(std::vector<Corruption>& ways) {
  ways.push_back({"no bytes", [](const Bytes&) { return Bytes(); }});
  ways.push_back({"cut in its fingerprint", [](Bytes b) { return Cut(std::move(b), 4); }});
  ways.push_back({"cut in its header", [](Bytes b) { return Cut(std::move(b), kRigIdOffset); }});
  ways.push_back({"cut behind its header", [](const Bytes& b) { return Cut(b, BodyOf(b)); }});
  ways.push_back({"cut in half", [](const Bytes& b) { return Cut(b, b.size() / 2); }});
  ways.push_back({"without its last byte", [](const Bytes& b) { return Cut(b, b.size() - 1); }});
}

void AddRandomBytes(std::vector<Corruption>& ways) {
  ways.push_back({"fingerprint of another type", [](Bytes b) {
                    for (size_t i = 0; i < kFingerprintBytes; ++i) b[i] ^= 0x5a;
                    return b;
                  }});
  for (unsigned seed = 0; seed < kRandomMessages; ++seed) {
    ways.push_back(
        {"random bytes", [seed](Bytes b) { return WithRandomBytes(std::move(b), 0, seed); }});
    ways.push_back({"random bytes behind its fingerprint", [seed](Bytes b) {
                      return WithRandomBytes(std::move(b), kFingerprintBytes, seed);
                    }});
    ways.push_back({"random bytes behind its header",
                    [seed](const Bytes& b) { return WithRandomBytes(b, BodyOf(b), seed); }});
  }
}

void AddSizes(Part part, std::vector<Corruption>& ways) {
  const std::vector<std::string> fields = SizeFields(part);
  for (size_t i = 0; i < fields.size(); ++i) {
    for (const int32_t value : {-1, std::numeric_limits<int32_t>::max()}) {
      ways.push_back({fields[i] + " = " + std::to_string(value), [i, value](const Bytes& b) {
                        return WithInt32(b, BodyOf(b) + 4 * i, value);
                      }});
    }
    if (part == Part::kRig) continue;  // another size of the images is no error in a calibration
    ways.push_back({fields[i] + " one too large", [i](const Bytes& b) {
                      const size_t offset = BodyOf(b) + 4 * i;
                      return WithInt32(b, offset, ReadInt32(b, offset) + 1);
                    }});
  }
}

// Writes into the first seed of a seeds_t, behind the arrays that take `bytes_before` a seed.
void AddBadSeed(const char* name, size_t bytes_before, int32_t value,
                std::vector<Corruption>& ways) {
  ways.push_back({name, [=](const Bytes& b) {
                    const size_t body = BodyOf(b);
                    const auto count = static_cast<size_t>(ReadInt32(b, body));
                    if (count == 0) return Cut(b, b.size() - 1);  // there is none to corrupt
                    constexpr size_t kCountsBytes = 8 * sizeof(int32_t);
                    return WithInt32(b, body + kCountsBytes + count * bytes_before, value);
                  }});
}

void AddBadValues(Part part, std::vector<Corruption>& ways) {
  constexpr int32_t kNan = 0x7ff80000;  // as float and as the first half of a double
  if (part == Part::kRig) {
    ways.push_back(
        {"focal_px = NaN", [](const Bytes& b) { return WithInt32(b, BodyOf(b) + 2 * 4, kNan); }});
  }
  if (TypeOf(part) == MessageType::kSeeds) {
    // The arrays, one behind the other: u, v, u_right, sigma_px; origin; tof_u, tof_v.
    AddBadSeed("u_right of the first seed = NaN", 2 * sizeof(float), kNan, ways);
    AddBadSeed("sigma_px of the first seed = NaN", 3 * sizeof(float), kNan, ways);
    AddBadSeed("sigma_px of the first seed = 0", 3 * sizeof(float), 0, ways);
    AddBadSeed("origin of the first seed = 2", 4 * sizeof(float), 0x02000000, ways);
    AddBadSeed("tof_u of the first seed = -2", 4 * sizeof(float) + 1, -2 << 16, ways);
  }
  if (part == Part::kPrior) {
    ways.push_back({"sigma of the last pixel = 0", [](Bytes b) {
                      b.back() = 0;
                      return b;
                    }});
  }
}

}  // namespace

std::vector<Corruption> CorruptionsOf(Part part) {
  std::vector<Corruption> ways;
  AddCuts(ways);
  AddRandomBytes(ways);
  AddSizes(part, ways);
  AddBadValues(part, ways);
  return ways;
}

}  // namespace sprout::check
