#include "services/tools/check/test_frames.h"

#include <functional>
#include <limits>
#include <utility>

#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/frames/log_frames.h"

namespace sprout::check {
namespace {

// Copies of images and maps share their pixels: replaced here, never written to.
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
    TestFrame frame{.name = "frame " + std::to_string(places.id.seq),
                    .rig_id = places.id.rig_id,
                    .parts = {},
                    .recorded = {}};
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

}  // namespace sprout::check
