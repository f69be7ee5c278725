#include "tests/system/graph_record.h"

#include <fmt/core.h>

#include <opencv2/core.hpp>

#include "common/bus/channels.h"
#include "services/depth/depth_map.h"
#include "services/pipeline/pipeline.h"

namespace sprout {
namespace {

constexpr Part kCaptured[] = {Part::kLeft, Part::kRight, Part::kTof};

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         (a.empty() || cv::countNonZero(a != b) == 0);
}

// Empty when the answers are right.
std::string Difference(const Frame& heard, const DepthFrame& computed, const SproutConfig& config) {
  if (!SamePixels(heard.disparity->counts(), computed.disparity.counts())) {
    return "other disparities";
  }
  if (!heard.confidence.empty() && !SamePixels(heard.confidence, computed.confidence)) {
    return "another confidence";
  }
  if (!heard.sigma.empty() && !SamePixels(heard.sigma, computed.sigma)) return "another sigma";
  if (!heard.depth) return "";
  const DepthImage depth =
      depth::DepthOf(computed.disparity, heard.rig->pair, config.depth().mm_per_count() / 1000,
                     config.depth().scale());
  return SamePixels(heard.depth->counts, depth.counts) ? "" : "another depth";
}

}  // namespace

GraphRecord::GraphRecord(const std::string& url, const std::string& prefix)
    : receiver_(url, prefix, AllChannels(),
                [this](std::string_view channel, std::span<const uint8_t> bytes) {
                  OnMessage(channel, bytes);
                }) {}

void GraphRecord::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  if (channel == kStatusChannel) {
    if (const Result<StageStatus> status = DecodeStatus(bytes)) statuses[status->pid] = *status;
  }
  if (const std::optional<Part> part = PartOf(channel)) {
    if (Result<DecodedPart> decoded = DecodePart(*part, bytes)) Add(*part, std::move(*decoded));
  }
  changed_.notify_all();
}

void GraphRecord::Add(Part part, DecodedPart decoded) {
  if (part == Part::kRig) {
    rigs_[decoded.id.rig_id] = std::get<Rig>(decoded.value);
    return;
  }
  const Key key{decoded.id.utime, decoded.id.seq};
  if (!frames.contains(key)) sent.push_back(key);
  Heard& heard = frames[key];
  heard.frame.id = decoded.id;
  heard.frame.rig = rigs_[decoded.id.rig_id];
  SetPart(heard.frame, part, std::move(decoded.value));
  heard.at.try_emplace(part, Clock::now());
}

bool GraphRecord::WaitUntil(const std::function<bool(GraphRecord&)>& condition,
                            std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] { return condition(*this); });
}

Comparison CompareWithPipeline(const std::map<GraphRecord::Key, GraphRecord::Heard>& frames,
                               const SproutConfig& config) {
  Pipeline pipeline(config);
  Comparison comparison;
  for (const auto& [key, heard] : frames) {
    if (!heard.at.contains(Part::kDisparity)) continue;
    ++comparison.maps;
    bool whole = true;
    for (const Part part : kCaptured) whole = whole && heard.at.contains(part);
    if (!whole) {
      ++comparison.unknown;
      continue;
    }
    const Frame& frame = heard.frame;
    const auto computed = pipeline.Compute(frame.left, frame.right, *frame.tof, *frame.rig);
    const std::string difference =
        computed ? Difference(frame, *computed, config) : computed.error().text;
    if (difference.empty()) continue;
    if (comparison.wrong++ == 0) {
      comparison.first_wrong = fmt::format("frame {}: {}", frame.id.seq, difference);
    }
  }
  return comparison;
}

std::string Objection(const Comparison& comparison, int64_t least) {
  if (comparison.wrong > 0) return comparison.first_wrong;
  if (comparison.unknown > 0) return "an answer to a frame that was not sent whole";
  return comparison.maps < least ? fmt::format("only {} maps", comparison.maps) : "";
}

std::string AccountText(const StageStatus& status, const StageStatus& before) {
  return fmt::format(
      "{} answered, {} skipped, {} incomplete, {} left out, {} failed",
      status.frames_out - before.frames_out, status.frames_skipped - before.frames_skipped,
      status.frames_incomplete - before.frames_incomplete,
      status.sequence_gaps - before.sequence_gaps, status.frames_failed - before.frames_failed);
}

int64_t CountedLost(const StageStatus& status) {
  return status.frames_skipped + status.frames_incomplete + status.frames_failed +
         status.sequence_gaps;
}

}  // namespace sprout
