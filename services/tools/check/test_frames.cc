#include "services/tools/check/test_frames.h"

#include <limits>
#include <random>
#include <utility>

#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/frames/log_frames.h"
#include "common/messages/message_type.h"

namespace sprout::check {
namespace {

// Copies of images and maps share their pixels, so values are replaced and never written to.
template <typename Value>
Value* Find(TestFrame& frame, Part part) {
  const auto found = frame.parts.find(part);
  return found == frame.parts.end() ? nullptr : &std::get<Value>(found->second);
}

// Keeps the seeds that both cameras see and that `keep` accepts; the seeds of the left camera alone
// go.
void KeepSeeds(TestFrame& frame, const std::function<bool(size_t, const Seed&)>& keep) {
  if (auto* set = Find<SeedSet>(frame, Part::kLeftSeeds)) set->seeds.clear();
  if (auto* set = Find<SeedSet>(frame, Part::kSeeds)) {
    std::vector<Seed> kept;
    for (size_t i = 0; i < set->seeds.size(); ++i) {
      if (keep(i, set->seeds[i])) kept.push_back(set->seeds[i]);
    }
    set->seeds = std::move(kept);
  }
}

void KeepDepths(TestFrame& frame, const std::function<bool(int u, int v)>& keep) {
  if (auto* tof = Find<TofImage>(frame, Part::kTof)) {
    cv::Mat1f depth_m = tof->depth_m.clone();
    for (int v = 0; v < depth_m.rows; ++v) {
      for (int u = 0; u < depth_m.cols; ++u) {
        if (!keep(u, v)) depth_m(v, u) = std::numeric_limits<float>::quiet_NaN();
      }
    }
    tof->depth_m = depth_m;
  }
}

void EmptyPrior(TestFrame& frame) {
  if (auto* prior = Find<PriorMap>(frame, Part::kPrior)) {
    *prior = PriorMap(prior->size());
  }
}

cv::Mat BlackImage(cv::Size size) { return {size, CV_8UC1, cv::Scalar(0)}; }

TestFrame Variant(const TestFrame& good, const std::string& name) {
  TestFrame frame = good;
  frame.name += " " + name;
  frame.recorded.reset();
  return frame;
}

TestFrame WithoutReturn(const TestFrame& good) {
  TestFrame frame = Variant(good, "without any ToF return");
  KeepDepths(frame, [](int, int) { return false; });
  KeepSeeds(frame, [](size_t, const Seed&) { return false; });
  EmptyPrior(frame);
  return frame;
}

// A frame of a rig whose ToF camera fails. Later stages see no seeds, as without any return.
TestFrame WithoutTofImage(const TestFrame& good) {
  TestFrame frame = WithoutReturn(good);
  frame.name = good.name + " without a ToF image";
  if (auto* tof = Find<TofImage>(frame, Part::kTof)) *tof = TofImage();
  return frame;
}

TestFrame WithTwoPoints(const TestFrame& good) {
  TestFrame frame = Variant(good, "with two ToF points");
  KeepDepths(frame, [](int u, int v) { return v == 1 && (u == 1 || u == 2); });
  KeepSeeds(frame, [](size_t i, const Seed&) { return i < 2; });
  EmptyPrior(frame);
  return frame;
}

TestFrame WithPointsOnALine(const TestFrame& good) {
  TestFrame frame = Variant(good, "with ToF points on one line");
  KeepDepths(frame, [](int, int v) { return v == 1; });
  if (auto* set = Find<SeedSet>(frame, Part::kSeeds); set != nullptr && !set->seeds.empty()) {
    const float row = set->seeds[0].v;
    KeepSeeds(frame, [row](size_t, const Seed& seed) { return seed.v == row; });
  }
  EmptyPrior(frame);
  return frame;
}

TestFrame Black(const TestFrame& good) {
  TestFrame frame = Variant(good, "with black images");
  for (const Part part : {Part::kLeft, Part::kRight}) {
    if (auto* image = Find<cv::Mat>(frame, part)) *image = BlackImage(image->size());
  }
  return frame;
}

TestFrame WithSmallRight(const TestFrame& good) {
  TestFrame frame = Variant(good, "with a RIGHT of half the size");
  if (auto* image = Find<cv::Mat>(frame, Part::kRight)) {
    *image = BlackImage(image->size() / 2);
  }
  return frame;
}

TestFrame WithSeedsOutside(const TestFrame& good) {
  TestFrame frame = Variant(good, "with seeds outside the images");
  for (const Part part : {Part::kSeeds, Part::kLeftSeeds}) {
    auto* const set = Find<SeedSet>(frame, part);
    if (set == nullptr) continue;
    for (Seed& seed : set->seeds) {
      seed.u += 10000;
      seed.u_right -= 5000;
    }
  }
  return frame;
}

TestFrame WithSmallPrior(const TestFrame& good) {
  TestFrame frame = Variant(good, "with a PRIOR of half the size");
  if (auto* prior = Find<PriorMap>(frame, Part::kPrior)) {
    *prior = PriorMap(prior->size() / 2);
  }
  return frame;
}

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

std::vector<TestFrame> ReadTestFrames(const std::filesystem::path& log,
                                      const StageContract& contract) {
  FrameIndex index({.look_back = FrameChoice::kWholeLog});
  LogReader reader(log);
  for (LogEvent event; reader.Next(event);) index.Add(event);
  PartSet inputs;
  for (const Part part : contract.inputs) inputs.Add(part);
  EventFetcher fetcher(log);
  std::map<FrameId, TestFrame> by_time;
  for (size_t i = 0; i < index.frames().size(); ++i) {
    const IndexedFrame places = index.At(i);
    TestFrame frame{.name = "frame " + std::to_string(places.id.seq), .rig_id = places.id.rig_id};
    for (auto& part : FetchParts(fetcher, places, inputs)) frame.parts.insert(std::move(part));
    for (auto& [part, value] : FetchParts(fetcher, places, {contract.answer})) {
      frame.recorded = std::move(value);
    }
    if (frame.parts.size() == contract.inputs.size()) by_time.emplace(places.id, std::move(frame));
  }
  std::vector<TestFrame> frames;
  for (auto& [id, frame] : by_time) frames.push_back(std::move(frame));
  if (frames.empty()) {
    std::string channels;
    for (const Part part : contract.inputs) channels += " " + std::string(ChannelOf(part));
    throw ConfigError(log.string() + ": no frame that has all of" + channels);
  }
  return frames;
}

std::vector<TestFrame> DegenerateFrames(const TestFrame& good) {
  std::vector<TestFrame> frames = {WithoutReturn(good), WithoutTofImage(good),
                                   WithTwoPoints(good), WithPointsOnALine(good),
                                   Black(good),         WithSmallRight(good)};
  if (good.parts.contains(Part::kSeeds)) frames.push_back(WithSeedsOutside(good));
  if (good.parts.contains(Part::kPrior)) frames.push_back(WithSmallPrior(good));
  return frames;
}

std::vector<Corruption> CorruptionsOf(Part part) {
  std::vector<Corruption> ways;
  AddCuts(ways);
  AddRandomBytes(ways);
  AddSizes(part, ways);
  AddBadValues(part, ways);
  return ways;
}

}  // namespace sprout::check
