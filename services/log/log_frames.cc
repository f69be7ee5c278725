#include "services/log/log_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "common/config/config.h"
#include "common/messages/codec.h"
#include "services/log/channels.h"
#include "services/log/damage_text.h"
#include "services/log/read_progress.h"

namespace sprout::log {
namespace {

// As many as a recorder sees in flight when the stages are slow.
constexpr size_t kMaxPending = 16;

}  // namespace

LogFrames::LogFrames(const PicturesOptions& options, PartSet parts, Visit visit)
    : options_(options), parts_(parts), visit_(std::move(visit)) {
  if (!options_.frames.empty()) range_ = ParseFrameRange("--frames", options_.frames);
}

void LogFrames::Read() {
  LogReader reader(options_.file);
  ReadProgress progress("reading " + options_.file.string(), reader.size());
  for (LogEvent event; reader.Next(event); progress.Update(reader.position())) Add(event);
  for (Frame& frame : pending_) Emit(std::move(frame));
  pending_.clear();
  progress.Clear();
  WarnOfDamage(options_.file, reader.damage());
}

void LogFrames::Add(const LogEvent& event) {
  const auto part = PartOfChannel(event.channel, options_.prefix);
  if (!part) {
    if (TypeOfChannel(event.channel)) other_channel_ = event.channel;
    return;
  }
  channel_seen_ = true;
  if (*part != Part::kRig) {
    const auto id = DecodeFrameId(event.data);
    if (!parts_.Has(*part) || (id && !range_.Has(id->seq))) return;
  }
  Result<DecodedPart> decoded = DecodePart(*part, event.data);
  if (!decoded) {
    if (undecodable_++ == 0) {
      first_error_ = fmt::format("{}, event {} at byte {}: {}", event.channel, event.number,
                                 event.offset, decoded.error().text);
    }
  } else if (*part == Part::kRig) {
    rigs_[decoded->id.rig_id] = std::get<Rig>(std::move(decoded->value));
  } else {
    Put(decoded->id, *part, std::move(decoded->value));
  }
}

void LogFrames::Put(const FrameId& id, Part part, PartValue value) {
  auto frame = std::find_if(pending_.begin(), pending_.end(),
                            [&](const Frame& other) { return other.id == id; });
  if (frame == pending_.end()) {
    if (pending_.size() == kMaxPending) {
      Emit(std::move(pending_.front()));
      pending_.pop_front();
    }
    frame = pending_.emplace(pending_.end());
    frame->id = id;
  }
  SetPart(*frame, part, std::move(value));
}

void LogFrames::Emit(Frame frame) {
  if (parts_.Has(Part::kRig)) frame.rig = FindRig(frame.id.rig_id);
  visit_(frame);
}

// Calibrations come once a second: that of the first frames may stand far behind them.
std::optional<Rig> LogFrames::FindRig(const std::string& rig_id) {
  const auto known = rigs_.find(rig_id);
  if (known != rigs_.end()) return known->second;
  LogReader reader(options_.file);
  for (LogEvent event; reader.Next(event);) {
    if (PartOfChannel(event.channel, options_.prefix) != Part::kRig) continue;
    Result<DecodedPart> decoded = DecodePart(Part::kRig, event.data);
    if (!decoded || decoded->id.rig_id != rig_id) continue;
    return rigs_[rig_id] = std::get<Rig>(std::move(decoded->value));
  }
  return rigs_[rig_id] = std::nullopt;
}

std::string LogFrames::Complaint() const {
  if (undecodable_ > 0) {
    return fmt::format("undecodable messages: {}, the first {}", undecodable_, first_error_);
  }
  if (!channel_seen_ && !other_channel_.empty()) {
    return "there are channels as " + other_channel_ + ", see --channel-prefix";
  }
  return "";
}

std::filesystem::path FrameFileNames::Of(const FrameId& id, const std::string& what) {
  if (utimes_.empty()) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error)
      throw ConfigError(folder_.string() + ": cannot be written (" + error.message() + ")");
  }
  ++files_;
  const auto [first, added] = utimes_.emplace(id.seq, id.utime);
  const std::string number = fmt::format("{:06}", id.seq);
  const bool other = !added && first->second != id.utime;
  return folder_ / (number + (other ? fmt::format("_{}", id.utime) : "") + "_" + what);
}

}  // namespace sprout::log
