// A small prior with one fault at choice, to see that check_stage finds it; with "none" it has
// none. Those of *_confidence are a grow's. usage: wrong_stage FAULT
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <set>
#include <string>
#include <thread>

#include "common/bus/channels.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/messages/codec.h"
#include "tests/common/core/even_prior.h"

namespace sprout {
namespace {

const std::set<std::string> kFaults = {
    "none",           "drops_a_frame",    "answers_twice",     "changes_seq",     "changes_utime",
    "changes_rig_id", "half_size",        "other_type",        "out_of_range",    "empty",
    "remembers",      "silent_if_poor",   "crashes_on_bad",    "hangs_on_bad",    "believes_bad",
    "other_channel",  "own_channel",      "ignores_sigterm",   "ends_at_once",    "ends_early",
    "fails",          "small_confidence", "colour_confidence", "two_confidences", "stands_still"};

class WrongPrior {
 public:
  WrongPrior(const std::string& url, std::string fault)
      : fault_(std::move(fault)),
        publisher_(url, ""),
        receiver_(url, "", {ChannelOf(Part::kSeeds), ChannelOf(Part::kRig)},
                  [this](std::string_view channel, std::span<const uint8_t> bytes) {
                    const Part part = channel == ChannelOf(Part::kRig) ? Part::kRig : Part::kSeeds;
                    Take(part, bytes);
                  }) {}

 private:
  bool Has(const char* fault) const { return fault_ == fault; }

  void Take(Part part, std::span<const uint8_t> bytes) {
    Result<DecodedPart> decoded = DecodePart(part, bytes);
    if (!decoded) {
      TakeBad(part, bytes);
    } else if (part == Part::kRig) {
      size_ = std::get<Rig>(decoded->value).pair.size();
    } else if (!size_.empty()) {
      Answer(decoded->id, std::get<SeedSet>(decoded->value));
    }
  }

  void TakeBad(Part part, std::span<const uint8_t> bytes) {
    if (Has("crashes_on_bad")) std::abort();
    if (Has("hangs_on_bad")) std::this_thread::sleep_for(std::chrono::hours(1));
    const Result<FrameId> id = DecodeFrameId(bytes);
    if (Has("believes_bad") && part == Part::kSeeds && id) Answer(*id, {.seeds = {{1, 1, 0}}});
  }

  // Every pixel has the mean disparity of the seeds.
  DisparityImage Map(const SeedSet& set) {
    const cv::Size size = Has("half_size") ? size_ / 2 : size_;
    if (set.seeds.empty() || Has("empty")) return DisparityImage(size);
    double disparity = 0;
    for (const Seed& seed : set.seeds) {
      disparity += seed.disparity() / static_cast<double>(set.seeds.size());
    }
    if (Has("stands_still")) disparity = 5;
    if (Has("out_of_range")) disparity = -3;
    if (Has("remembers")) disparity += static_cast<double>(count_ % 7);
    return DisparityImage(cv::Mat1s(size, ToCounts(disparity)));
  }

  void Answer(FrameId id, const SeedSet& set) {
    ++count_;
    if (Has("fails")) {
      StageStatus status;
      status.stage = "prior";
      status.frames_failed = count_;
      status.last_error = "frame " + std::to_string(id.seq) + ": failed: no licence";
      if (!publisher_.Publish(kStatusChannel, EncodeStatus(status))) std::abort();
      return;
    }
    if (Has("drops_a_frame") && count_ % 4 == 0) return;
    if (Has("silent_if_poor") && set.seeds.size() < 3) return;
    if (Has("changes_seq")) id.seq += 1000;
    if (Has("changes_utime")) id.utime += 1;
    if (Has("changes_rig_id")) id.rig_id += "x";
    std::vector<uint8_t> bytes = EncodePart(id, Part::kPrior, EvenPrior(Map(set), 1));
    if (Has("own_channel")) {
      if (!publisher_.Publish("MY_PRIOR", bytes)) std::abort();
      return;
    }
    if (fault_.ends_with("confidence") || fault_.ends_with("confidences")) {
      const cv::Mat confidence(Has("small_confidence") ? size_ / 2 : size_,
                               Has("colour_confidence") ? CV_8UC3 : CV_8UC1, cv::Scalar::all(9));
      for (int i = 0; i < (Has("two_confidences") ? 2 : 1); ++i) {
        Publish(Part::kConfidence, EncodePart(id, Part::kConfidence, confidence));
      }
      return Publish(Part::kDisparity, EncodePart(id, Part::kDisparity, Map(set)));
    }
    if (Has("other_type")) bytes = EncodePart(id, Part::kSeeds, set);
    Publish(Has("other_channel") ? Part::kDisparity : Part::kPrior, bytes);
    if (Has("answers_twice")) Publish(Part::kPrior, bytes);
    if (Has("ends_early") && count_ == 30) std::_Exit(0);
  }

  void Publish(Part part, std::span<const uint8_t> bytes) {
    if (!publisher_.Publish(ChannelOf(part), bytes)) std::abort();
  }

  std::string fault_;
  cv::Size size_;  // of the left image, from the newest calibration
  int count_ = 0;
  Publisher publisher_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

int Main(const std::string& fault) {
  if (!kFaults.contains(fault)) {
    std::cerr << "wrong_stage: no fault '" << fault << "'\n";
    return 2;
  }
  if (fault == "ends_at_once") return 3;
  if (fault == "ignores_sigterm") std::signal(SIGTERM, SIG_IGN);
  const WrongPrior prior(std::getenv("LCM_DEFAULT_URL"), fault);
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));  // SIGTERM ends it
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc == 2 ? argv[1] : ""); }
