#include "services/tools/check/capture_listener.h"

#include <fmt/core.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "common/bus/channels.h"
#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/core/quantile.h"
#include "common/messages/codec.h"

namespace sprout::check {
namespace {

constexpr Part kFrameParts[] = {Part::kLeft, Part::kRight, Part::kTof};

// Beyond these a number is in another unit than the message type says.
constexpr double kMaxMedianDepthM = 300;  // farther than ToF cameras and lidars see
constexpr double kMaxBaselineM = 10;
constexpr double kMinFocalPerWidth = 0.1;  // 157 degrees

bool IsPartOfFrame(Part part) {
  return std::find(std::begin(kFrameParts), std::end(kFrameParts), part) != std::end(kFrameParts);
}

std::string NameOf(int64_t seq) { return fmt::format("frame {}", seq); }

double SecondsSinceEpoch() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

template <typename Value>
const Value* Find(const std::map<Part, PartValue>& values, Part part) {
  const auto found = values.find(part);
  return found == values.end() ? nullptr : &std::get<Value>(found->second);
}

}  // namespace

void CaptureListener::Take(const Heard& heard) {
  channels_.insert(heard.channel);
  const std::optional<Part> part = PartOf(heard.channel);
  if (part && IsPartOfFrame(*part)) {
    TakeImage(*part, heard);
  } else if (part == Part::kRig) {
    TakeRig(heard);
  } else if (!CheckReport(heard, found_) && heard.channel.starts_with("SPROUT_")) {
    // Channels that are not the graph's are allowed: there may be an IMU.
    found_.Add(Rule::kChannels,
               fmt::format("published on {}; allowed are {}, {}, {} and {}", heard.channel,
                           ChannelOf(Part::kLeft), ChannelOf(Part::kRight), ChannelOf(Part::kTof),
                           ChannelOf(Part::kRig)));
  }
}

void CaptureListener::TakeImage(Part part, const Heard& heard) {
  Result<DecodedPart> decoded = DecodePart(part, heard.bytes);
  const Result<FrameId> id = DecodeFrameId(heard.bytes);
  if (!decoded) {
    found_.Add(Rule::kForm,
               fmt::format("{}, {}: {}", heard.channel, id ? NameOf(id->seq) : "header unreadable",
                           decoded.error().text));
  }
  if (!id) return;
  Frame* const frame = FrameOf(part, *id, heard.when);
  if (frame == nullptr) return;
  frame->heard.Add(part);
  if (decoded) frame->values[part] = std::move(decoded->value);
  const bool whole = std::all_of(std::begin(kFrameParts), std::end(kFrameParts),
                                 [&](Part each) { return frame->heard.Has(each); });
  if (whole) Complete(*frame, heard.when);
}

// The frame that a message belongs to; nothing when that has the part already, or is over.
CaptureListener::Frame* CaptureListener::FrameOf(Part part, const FrameId& id,
                                                 Clock::time_point when) {
  const auto known = frames_.find(id.seq);
  if (known == frames_.end()) return &Begin(part, id, when);
  Frame& frame = known->second;
  if (frame.heard.Has(part) && id.utime != frame.id.utime) {
    found_.Add(Rule::kRising, fmt::format("{}: seq = {} again, with another utime; allowed is {}",
                                          ChannelOf(part), id.seq, newest_->seq + 1));
    return nullptr;
  }
  if (frame.heard.Has(part)) {
    found_.Add(Rule::kWhole, fmt::format("{}: {} twice", NameOf(id.seq), ChannelOf(part)));
    return nullptr;
  }
  const auto compare = [&](const char* field, const auto& value, const auto& first) {
    if (value == first) return;
    found_.Add(Rule::kSameHeader,
               fmt::format("{}: {} has {} = {}; {} has {}", NameOf(id.seq), ChannelOf(part), field,
                           value, frame.first_channel, first));
  };
  compare("utime", id.utime, frame.id.utime);
  compare("rig_id", id.rig_id, frame.id.rig_id);
  return frame.over ? nullptr : &frame;
}

CaptureListener::Frame& CaptureListener::Begin(Part part, const FrameId& id,
                                               Clock::time_point when) {
  if (newest_ && id.seq != newest_->seq + 1) {
    found_.Add(Rule::kRising, fmt::format("{}: seq = {} after {}; allowed is {}", ChannelOf(part),
                                          id.seq, newest_->seq, newest_->seq + 1));
  }
  if (newest_ && id.utime <= newest_->utime) {
    found_.Add(Rule::kRising, fmt::format("{}: utime = {} after {}; it must rise", NameOf(id.seq),
                                          id.utime, newest_->utime));
  }
  if (!rigs_.contains(id.rig_id)) {
    found_.Add(Rule::kCalibration,
               fmt::format("{}: no {} with its rig_id = '{}' before it; the graph cannot use it",
                           NameOf(id.seq), ChannelOf(Part::kRig), id.rig_id));
  }
  newest_ = id;
  Frame& frame = frames_[id.seq];
  frame.id = id;
  frame.first_channel = ChannelOf(part);
  frame.begun = when;
  return frame;
}

void CaptureListener::Complete(Frame& frame, Clock::time_point when) {
  // A stage does not wait for older frames when a newer one is whole.
  for (auto& [seq, older] : frames_) {
    if (seq >= frame.id.seq) break;
    if (older.over) continue;
    older.over = true;
    older.values.clear();
    for (const Part part : kFrameParts) {
      if (older.heard.Has(part)) continue;
      found_.Add(Rule::kWhole, fmt::format("{}: no {} before {} was whole", NameOf(seq),
                                           ChannelOf(part), NameOf(frame.id.seq)));
    }
  }
  CheckSizes(frame);
  CheckImages(frame);
  CheckTof(frame);
  frame.over = true;
  frame.values.clear();

  if (whole_frames_++ == 0) {
    first_whole_ = when;
    first_utime_ = frame.id.utime;
  }
  last_whole_ = when;
  last_utime_ = frame.id.utime;
  const auto milliseconds = [](Clock::duration time) {
    return std::chrono::duration<double, std::milli>(time).count();
  };
  spreads_ms_.push_back(milliseconds(when - frame.begun));
  const double begun_s = SecondsSinceEpoch() - milliseconds(Clock::now() - frame.begun) / 1e3;
  ages_s_.push_back(begun_s - static_cast<double>(frame.id.utime) / 1e6);
}

void CaptureListener::CheckSizes(const Frame& frame) {
  const auto calibration = rigs_.find(frame.id.rig_id);
  if (calibration == rigs_.end()) return;
  const Rig& rig = calibration->second.rig;
  const auto compare = [&](Part part, cv::Size size, cv::Size expected) {
    if (size == expected) return;
    found_.Add(Rule::kForm,
               fmt::format("{}, {}: {}; {} says {}", ChannelOf(part), NameOf(frame.id.seq),
                           SizeText(size), ChannelOf(Part::kRig), SizeText(expected)));
  };
  for (const Part part : {Part::kLeft, Part::kRight}) {
    if (const auto* image = Find<cv::Mat>(frame.values, part)) {
      compare(part, image->size(), rig.pair.size());
    }
  }
  // A ToF camera that gave no image sends 0x0.
  const auto* tof = Find<TofImage>(frame.values, Part::kTof);
  if (tof != nullptr && !tof->depth_m.empty()) {
    compare(Part::kTof, tof->depth_m.size(), rig.tof.lens().size());
  }
}

void CaptureListener::CheckImages(const Frame& frame) {
  const auto* left = Find<cv::Mat>(frame.values, Part::kLeft);
  const auto* right = Find<cv::Mat>(frame.values, Part::kRight);
  if (left != nullptr) size_ = left->size();
  if (left == nullptr || right == nullptr || left->size() != right->size()) return;
  if (cv::countNonZero(ToGrey(*left) != ToGrey(*right)) == 0) {
    found_.Add(Rule::kValues,
               fmt::format("{}: {} and {} are the same picture", NameOf(frame.id.seq),
                           ChannelOf(Part::kLeft), ChannelOf(Part::kRight)));
  }
}

void CaptureListener::CheckTof(const Frame& frame) {
  const auto* tof = Find<TofImage>(frame.values, Part::kTof);
  if (tof == nullptr || tof->depth_m.empty()) return;
  tof_size_ = tof->depth_m.size();
  std::vector<double> depths_m;
  for (const float depth_m : tof->depth_m) {
    if (IsReturn(depth_m)) depths_m.push_back(depth_m);
  }
  tof_pixels_ += static_cast<int64_t>(tof->depth_m.total());
  tof_returns_ += std::ssize(depths_m);
  if (depths_m.empty()) return;
  tof_depths_m_.push_back(Median(depths_m));
  if (tof_depths_m_.back() > kMaxMedianDepthM) {
    found_.Add(Rule::kValues,
               fmt::format("{}, {}: the median of depth_m is {:.4g}; it must be in metres",
                           ChannelOf(Part::kTof), NameOf(frame.id.seq), tof_depths_m_.back()));
  }
}

void CaptureListener::TakeRig(const Heard& heard) {
  CheckRigSilence(heard.when);
  ++rigs_heard_;
  last_rig_ = heard.when;
  const Result<DecodedPart> decoded = DecodePart(Part::kRig, heard.bytes);
  if (!decoded) {
    found_.Add(Rule::kForm, heard.channel + ": " + decoded.error().text);
    return;
  }
  const Rig& rig = std::get<Rig>(decoded->value);
  const std::string digest = RigId(rig);
  const std::string& id = decoded->id.rig_id;
  const auto known = rigs_.find(id);
  if (known == rigs_.end()) {
    rigs_[id] = {rig, digest};
    CheckRigValues(rig);
  } else if (known->second.digest != digest) {
    found_.Add(Rule::kCalibration,
               fmt::format("{}: rig_id = '{}' again, with other numbers; they need another rig_id",
                           heard.channel, id));
  }
}

void CaptureListener::CheckRigValues(const Rig& rig) {
  if (rig.pair.baseline_m > kMaxBaselineM) {
    found_.Add(Rule::kValues, fmt::format("{}: baseline_m = {:.4g}; it must be in metres",
                                          ChannelOf(Part::kRig), rig.pair.baseline_m));
  }
  if (rig.pair.focal_px < kMinFocalPerWidth * rig.pair.width) {
    found_.Add(Rule::kValues,
               fmt::format("{}: focal_px = {:.4g} for {} columns; it must be in pixels",
                           ChannelOf(Part::kRig), rig.pair.focal_px, rig.pair.width));
  }
}

void CaptureListener::CheckRigSilence(Clock::time_point now) {
  if (!last_rig_ || now - *last_rig_ <= kMaxRigSilence) return;
  found_.Add(Rule::kCalibration,
             fmt::format("no {} for {:.1f} s; it is due once a second", ChannelOf(Part::kRig),
                         std::chrono::duration<double>(now - *last_rig_).count()));
}

void CaptureListener::CheckUnitOfUtime() {
  constexpr double kOtherUnit = 300;  // recordings are played faster or slower, but not so much
  const double ratio = utime_s() / time_s();
  if (whole_frames_ < 2 || utime_s() <= 0 || (ratio < kOtherUnit && ratio > 1 / kOtherUnit)) return;
  found_.Add(Rule::kRising, fmt::format("utime rises by {:.3g} s in {:.3g} s; it must be in µs",
                                        utime_s(), time_s()));
}

void CaptureListener::Finish(Clock::time_point now) {
  CheckRigSilence(now);
  CheckUnitOfUtime();
}

double CaptureListener::time_s() const {
  return std::chrono::duration<double>(last_whole_ - first_whole_).count();
}

double CaptureListener::utime_s() const {
  return static_cast<double>(last_utime_ - first_utime_) / 1e6;
}

std::string CaptureListener::HeardChannels() const {
  return channels_.empty() ? "nothing" : Joined(", ", channels_);
}

std::string CaptureListener::Figures() const {
  if (whole_frames_ == 0) return "";
  const auto rate = [&](double seconds) { return seconds > 0 ? (whole_frames_ - 1) / seconds : 0; };
  std::string text = fmt::format(
      "capture: {} frames of {}, {:.1f} a second; by their utime {:.1f} a second\n"
      "capture: {:.1f} ms from a frame's first message to its last in the median; the first comes "
      "{:.3g} s after utime\n",
      whole_frames_, SizeText(size_), rate(time_s()), rate(utime_s()),
      Median(std::vector(spreads_ms_)), Median(std::vector(ages_s_)));
  if (tof_pixels_ == 0) {
    text += "capture: no ToF image\n";
  } else {
    text +=
        fmt::format("capture: ToF of {}, returns in {:.0f} % of the pixels", SizeText(tof_size_),
                    100.0 * static_cast<double>(tof_returns_) / static_cast<double>(tof_pixels_));
    text += tof_depths_m_.empty()
                ? "\n"
                : fmt::format(", at {:.3g} m in the median\n", Median(std::vector(tof_depths_m_)));
  }
  if (!rigs_.empty()) {
    const RectifiedPair& pair = rigs_.begin()->second.rig.pair;
    text += fmt::format("capture: RIG {} times; baseline {:.4g} m, focal length {:.5g} px\n",
                        rigs_heard_, pair.baseline_m, pair.focal_px);
  }
  return text;
}

}  // namespace sprout::check
