#include "tests/system/hostile_messages.h"

#include <algorithm>
#include <limits>

#include "common/bus/channels.h"
#include "common/core/image.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout {
namespace {

constexpr int64_t kUtime = 1'700'000'000'000'000;

// Largest image that is sent, px: a frame takes seconds, not minutes.
constexpr size_t kMaxColumns = 2000;
constexpr size_t kMaxRows = 1500;
constexpr size_t kMaxTofSide = 500;

DepthImage DepthOf(const cv::Mat1w& counts) {
  return {.counts = counts, .metres_per_count = 0.001, .focal_px = 500, .cx = 1, .cy = 1};
}

}  // namespace

HostileMessages::HostileMessages(const check::TestFrame& good, uint32_t seed)
    : good_(good), values_(good.parts), random_(seed) {
  values_[Part::kDisparity] = good.recorded.value();
  values_[Part::kUnfilled] = good.recorded.value();
  values_[Part::kDepth] = values_[Part::kDepthSigma] =
      DepthOf(cv::Mat1w(good.rig().pair.size(), uint16_t{1500}));
  values_[Part::kCloud] = PointCloud{{{.position_m = {0, 0, 1}, .bgr = {}}}};
  values_[Part::kSigma] = cv::Mat(good.rig().pair.size(), CV_8UC1, cv::Scalar(8));
  values_[Part::kFused] = good.recorded.value();
  values_[Part::kMotion] = values_[Part::kOdometry] = CameraMotion{};
  values_[Part::kDepthCounts] = DepthCounts{};
  values_[Part::kBaseCloud] = values_[Part::kTargetCloud] = values_[Part::kCloud];
  values_[Part::kTargetDepth] = values_[Part::kDepth];
  values_[Part::kTofZones] = TofZones{.columns = 1,
                                      .rows = 1,
                                      .left_from_sensor = {},
                                      .views = {{-1, 1, -1, 1}},
                                      .targets = {{2, 0.1F, TargetStatus::kValid}}};
  values_[Part::kFusedConfidence] = values_[Part::kConfidence] =
      cv::Mat(good.rig().pair.size(), CV_8UC1, cv::Scalar(200));
}

// Numbers that break sums, products and indices.
double HostileMessages::Extreme() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double values[] = {std::numeric_limits<double>::quiet_NaN(),
                           kInfinity,
                           -kInfinity,
                           0,
                           -0.0,
                           -1,
                           1e-300,
                           1e-6,
                           1e6,
                           1e30,
                           1e300,
                           3.4e38,
                           2147483648.0,
                           65536};
  return values[Below(std::size(values))];
}

FrameId HostileMessages::RandomId() {
  const int64_t values[] = {INT64_MAX, INT64_MIN, -1, 0, 1, Below(1000)};
  FrameId id{.utime = kUtime + Below(1000), .seq = Below(1000), .rig_id = good_.rig_id};
  if (Below(4) == 0) id.utime = values[Below(std::size(values))];
  if (Below(4) == 0) id.seq = values[Below(std::size(values))];
  if (Below(8) == 0) id.rig_id = std::string(Below(2) == 0 ? Below(100) : Below(1 << 20), 'r');
  return id;
}

HostileMessages::Bytes HostileMessages::Encode(const FrameId& id, Part part,
                                               const PartValue& value) {
  return EncodePart(id, part, value,
                    Below(2) == 0 ? DisparityEncoding::kRawInt16 : DisparityEncoding::kDeltaZstd);
}

HostileMessages::Bytes HostileMessages::Status() {
  StageStatus status;
  status.newest_frame = RandomId();
  const char* const stages[] = {"refine", "prior", "grow", "capture", "", "nobody"};
  status.stage = stages[Below(std::size(stages))] + std::to_string(Below(1000));
  if (Below(4) == 0) status.stage.resize(Below(1 << 20), 's');
  status.last_error.resize(Below(4) == 0 ? Below(1 << 20) : 10, 'e');
  status.rate_hz = Extreme();
  status.age.p50_ms = Extreme();
  status.tof_coverage = static_cast<float>(Extreme());
  status.frames_in = random_();
  return EncodeStatus(status);
}

// Bytes of a good message, with damage that knows nothing of its type.
HostileMessages::Bytes HostileMessages::Damaged(Bytes bytes, std::string& way, bool& bad) {
  const size_t size = bytes.size();
  const auto change = [&](size_t begin, size_t end, size_t times) {
    for (size_t i = 0; i < times && begin < end; ++i) {
      bytes[begin + Below(end - begin)] = static_cast<uint8_t>(random_());
    }
  };
  switch (Below(5)) {
    case 0:
      way = "truncated";
      bytes.resize(Below(size));
      bad = true;
      break;
    case 1:
      way = "changed in its head";  // which has all sizes and counts
      change(8, std::min<size_t>(size, 150), 1 + Below(8));
      break;
    case 2:
      way = "changed anywhere";
      change(8, size, 1 + Below(200));
      break;
    case 3:
      way = "random behind its type";
      change(8, size, 4 * size);
      break;
    default:
      way = "oversized";
      bytes.resize(size + Below(4 << 20), static_cast<uint8_t>(random_()));
      change(8, std::min<size_t>(size, 150), Below(4));
  }
  return bytes;
}

Rig HostileMessages::OddRig(cv::Size size) {
  Rig rig = good_.rig();
  rig.pair.width = size.width;
  rig.pair.height = size.height;
  const double scale = 1.0 * size.width / good_.rig().pair.width;
  for (double* number : {&rig.pair.focal_px, &rig.pair.cx, &rig.pair.cy, &rig.pair.cx_right}) {
    *number *= scale;
  }
  double* const numbers[] = {&rig.pair.focal_px,
                             &rig.pair.cx,
                             &rig.pair.cy,
                             &rig.pair.cx_right,
                             &rig.pair.baseline_m,
                             &rig.tof.fx,
                             &rig.tof.fy,
                             &rig.tof.cx,
                             &rig.tof.cy,
                             &rig.tof.distortion[0],
                             &rig.tof.distortion[3],
                             &rig.tof.left_from_tof_translation_m.x(),
                             &rig.tof.left_from_tof_translation_m.z()};
  for (uint32_t i = Below(3); i > 0; --i) *numbers[Below(std::size(numbers))] = Extreme();
  if (Below(4) == 0) rig.tof.fx = rig.tof.fy = 1e6;  // all ToF points in one pixel
  if (Below(2) == 0) {
    rig.tof.width = 1 + static_cast<int>(Below(kMaxTofSide));
    rig.tof.height = 1 + static_cast<int>(Below(kMaxTofSide));
  }
  return rig;
}

// A value of the right form that makes no sense.
PartValue HostileMessages::Odd(Part part, cv::Size size) {
  const auto number = [&] {
    return Below(8) == 0 ? static_cast<float>(Extreme()) : static_cast<float>(Below(4000)) / 8;
  };
  switch (part) {
    case Part::kLeft:
    case Part::kRight:
    case Part::kConfidence:
    case Part::kSigma:
    case Part::kFusedConfidence: {
      const bool grey = part == Part::kConfidence || part == Part::kSigma ||
                        part == Part::kFusedConfidence || Below(2) == 0;
      cv::Mat image(size, grey ? CV_8UC1 : CV_8UC3);
      cv::RNG(random_()).fill(image, cv::RNG::UNIFORM, 0, Below(2) == 0 ? 256 : 2);
      return image;
    }
    case Part::kRig:
      return OddRig(size);
    case Part::kTof: {
      TofImage tof{.depth_m = cv::Mat1f(size), .amplitude = {}};
      for (float& depth_m : tof.depth_m) depth_m = number() / 50;
      if (Below(2) == 0) {
        tof.amplitude = cv::Mat1f(size);
        for (float& amplitude : tof.amplitude) amplitude = number();
      }
      return tof;
    }
    case Part::kSeeds:
    case Part::kLeftSeeds: {
      SeedSet set;
      const bool numbers = Below(4) != 0;  // else one NaN spoils all of them
      const auto place = [&](int side) {
        return Below(64) == 0 && !numbers
                   ? number()
                   : static_cast<float>(Below(64 * static_cast<uint32_t>(side))) / 64;
      };
      const bool crowded = Below(2) == 0;
      for (uint32_t i = Below(20'000); i > 0; --i) {
        const float u = crowded ? 5 + place(1) : place(size.width);
        set.seeds.push_back({.u = u,
                             .v = crowded ? 5 + place(1) : place(size.height),
                             .u_right = u - place(size.width),
                             .sigma_px = static_cast<float>(1 + Below(64 * 1023)) / 64,
                             .origin = Below(4) == 0 ? SeedOrigin::kStereo : SeedOrigin::kTof});
        if (set.seeds.back().origin == SeedOrigin::kStereo) continue;
        set.seeds.back().tof_u = static_cast<int16_t>(Below(kMaxSide));
        set.seeds.back().tof_v = static_cast<int16_t>(Below(kMaxSide));
      }
      set.raw = CountTofSeeds(set.seeds);
      return set;
    }
    case Part::kPrior: {
      PriorMap prior(std::get<DisparityImage>(Odd(Part::kDisparity, size)), cv::Mat1b(size));
      cv::RNG(random_()).fill(prior.sigma, cv::RNG::UNIFORM, Below(16) == 0 ? 0 : 1, 256);
      prior.sigma.setTo(kMaxSigmaCounts, prior.disparity.counts() == DisparityImage::kInvalid);
      return prior;
    }
    case Part::kDepth:
    case Part::kDepthSigma:
    case Part::kTargetDepth: {
      cv::Mat1w counts(size);
      cv::RNG(random_()).fill(counts, cv::RNG::UNIFORM, 0, 65536);
      return DepthOf(counts);
    }
    case Part::kCloud:
    case Part::kBaseCloud:
    case Part::kTargetCloud: {
      PointCloud cloud;
      cloud.points.resize(Below(20'000), {.position_m = {0, 0, 1}, .bgr = {}});
      return cloud;
    }
    case Part::kDepthCounts:
      return DepthCounts{.pixels = static_cast<int32_t>(Below(1 << 20))};
    case Part::kMotion:
    case Part::kOdometry: {
      CameraMotion motion;
      for (int i = 0; i < 3; ++i) motion.last_from_left.translation_m[i] = Below(1 << 20);
      for (int i = 0; i < 3; ++i) motion.start_from_left.translation_m[i] = Extreme();
      motion.resets = Below(1000);
      return motion;
    }
    case Part::kTofZones: {
      const auto side = [&] { return static_cast<int>(1 + Below(kMaxZonesPerSide)); };
      TofZones zones{.columns = side(),
                     .rows = Below(2) == 0 ? 1 : side(),
                     .targets_per_zone = static_cast<int>(1 + Below(kMaxTargetsPerZone)),
                     .mode = Below(2) == 0 ? ZoneMode::kMean : ZoneMode::kNearest,
                     .left_from_sensor = {},
                     .views = {},
                     .targets = {}};
      const auto tangent = [&] { return static_cast<float>(Below(6400)) / 64 - 100; };
      const int most = Below(2) == 0 ? 1 : 100;  // also all zones in one place
      for (int i = 0; i < zones.columns * zones.rows; ++i) {
        const float left = tangent();
        const float top = tangent();
        zones.views.push_back(most == 1 ? ZoneView{-1, 1, -1, 1}
                                        : ZoneView{left, left + 0.5F, top, top + 100});
        for (int k = 0; k < zones.targets_per_zone; ++k) {
          zones.targets.push_back({.depth_m = (1 + number()) / 50,
                                   .sigma_m = (1 + number()) / 100,
                                   .status = static_cast<TargetStatus>(Below(3))});
        }
      }
      return zones;
    }
    default: {
      DisparityImage map(size);
      const int largest = Below(2) == 0 ? INT16_MAX : 32 * size.width;
      cv::RNG(random_()).fill(map.counts(), cv::RNG::UNIFORM, Below(2) == 0 ? INT16_MIN : 0,
                              std::min<int>(largest, INT16_MAX));
      return map;
    }
  }
}

HostileMessage HostileMessages::Corrupted(Part part) {
  const std::vector<check::Corruption> ways = check::CorruptionsOf(part);
  const Bytes bytes = EncodePart(RandomId(), part, values_.at(part));
  return {"spoiled field by field", std::string(ChannelOf(part)),
          ways[Below(ways.size())].apply(bytes), true};
}

HostileMessage HostileMessages::OfAnotherSize(Part part) {
  const cv::Size size(static_cast<int>(1 + Below(kMaxColumns)), static_cast<int>(1 + Below(300)));
  return {"of another size", std::string(ChannelOf(part)),
          Encode(RandomId(), part, Odd(part, size)), false};
}

HostileMessage HostileMessages::OnWrongChannel(Part part) {
  const Part other = kAllParts[Below(kPartCount)];
  return {"on a wrong channel", std::string(ChannelOf(other)),
          Encode(RandomId(), part, values_.at(part)), TypeOf(part) != TypeOf(other)};
}

// All messages of a frame that agree with each other: gets past the border and into the stages.
std::vector<HostileMessage> HostileMessages::OddFrame() {
  const cv::Size size =
      Below(8) == 0 ? cv::Size(static_cast<int>(1 + Below(kMaxColumns)),
                               static_cast<int>(1 + Below(kMaxRows)))
                    : cv::Size(static_cast<int>(1 + Below(300)), static_cast<int>(1 + Below(200)));
  const Rig rig = OddRig(size);
  const FrameId id{.utime = kUtime + Below(1000), .seq = Below(1000), .rig_id = RigId(rig)};
  std::vector<HostileMessage> frame;
  for (const auto& [part, unused] : values_) {
    if (Below(30) == 0) continue;  // never complete
    const cv::Size own = part == Part::kTof ? cv::Size(rig.tof.width, rig.tof.height) : size;
    const PartValue value = part == Part::kRig ? PartValue(rig) : Odd(part, own);
    frame.push_back({"whole frame without sense", std::string(ChannelOf(part)),
                     Encode(id, part, value), false});
  }
  std::shuffle(frame.begin(), frame.end(), random_);
  return frame;
}

std::vector<HostileMessage> HostileMessages::Next() {
  const Part part = kAllParts[Below(kPartCount)];
  switch (Below(8)) {
    case 0:
    case 1:
      return {Corrupted(part)};
    case 2:
      return {OfAnotherSize(part)};
    case 3:
      return {OnWrongChannel(part)};
    case 4:
      return OddFrame();
    case 5: {
      HostileMessage again{"good, many times", std::string(ChannelOf(part)),
                           Encode(RandomId(), part, values_.at(part)), false};
      return std::vector<HostileMessage>(1 + Below(20), again);
    }
    default: {
      HostileMessage message{"", std::string(ChannelOf(part)), {}, false};
      message.bytes = Damaged(Encode(RandomId(), part, values_.at(part)), message.way, message.bad);
      return {message};
    }
  }
}

HostileMessage HostileMessages::NextForCapture() {
  const bool status = Below(2) == 0;
  HostileMessage message{
      "", std::string(status ? kStatusChannel : ChannelOf(Part::kDisparity)), {}, false};
  Bytes bytes =
      status ? Status() : Encode(RandomId(), Part::kDisparity, values_.at(Part::kDisparity));
  if (Below(3) == 0) {
    message.way = status ? "status without sense" : "answer to nothing";
    message.bytes = std::move(bytes);
  } else {
    message.bytes = Damaged(std::move(bytes), message.way, message.bad);
  }
  return message;
}

std::vector<HostileMessage> HostileMessages::GoodFrame(int64_t seq) {
  const FrameId id{.utime = kUtime + seq, .seq = seq, .rig_id = good_.rig_id};
  std::vector<HostileMessage> frame;
  for (const Part part : {Part::kRig, Part::kLeft, Part::kRight, Part::kTof}) {
    const HostileMessage message{"good frames", std::string(ChannelOf(part)),
                                 Encode(id, part, values_.at(part)), false};
    frame.insert(frame.end(), 1 + Below(3), message);
  }
  std::shuffle(frame.begin(), frame.end(), random_);
  return frame;
}

}  // namespace sprout
