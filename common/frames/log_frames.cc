#include "common/frames/log_frames.h"

#include <algorithm>

#include "common/logfile/log_error.h"
#include "common/messages/codec.h"

namespace sprout {

std::vector<ReadPart> FetchParts(EventFetcher& log, const IndexedFrame& places,
                                 const PartSet& parts, const Refuse& refuse) {
  std::vector<ReadPart> read;
  for (const Part part : kAllParts) {
    if (!parts.Has(part) || !places.Has(part)) continue;
    const LogEvent event = log.Fetch(places.offset(part));
    if (Result<DecodedPart> decoded = DecodePart(part, event.data)) {
      read.emplace_back(part, std::move(decoded->value));
    } else if (refuse) {
      refuse(event, decoded.error().text);
    }
  }
  return read;
}

LogFrames::LogFrames(const std::filesystem::path& path, FrameChoice choice, Refuse refuse)
    : path_(path),
      choice_(std::move(choice)),
      refuse_(std::move(refuse)),
      reader_(path),
      fetcher_(path),
      index_(choice_) {}

std::optional<Frame> LogFrames::Next(const Progress& progress) {
  const auto is_over = [&] { return index_.frames().size() - next_ > choice_.look_back; };
  while (true) {
    for (LogEvent event; !is_over() && reader_.Next(event);) {
      index_.Add(event, refuse_);
      RequireOneAnswer();
      if (progress) progress(reader_.position());
    }
    if (next_ == index_.frames().size()) return std::nullopt;
    const IndexedFrame places = PlacesOf(next_++);
    Frame frame;
    frame.id = places.id;
    bool is_there = false;  // anything but the calibration
    for (auto& [part, value] : FetchParts(fetcher_, places, choice_.parts, refuse_)) {
      is_there = is_there || part != Part::kRig;
      SetPart(frame, part, std::move(value));
    }
    if (is_there) return frame;
  }
}

void LogFrames::RequireOneAnswer() {
  for (; checked_repeats_ < index_.repeats().size(); ++checked_repeats_) {
    const RepeatedPart& repeat = index_.repeats()[checked_repeats_];
    const auto earlier = fetcher_.Fetch(repeat.earlier).data;
    const std::vector<uint8_t> bytes(earlier.begin(), earlier.end());
    if (std::ranges::equal(bytes, fetcher_.Fetch(repeat.later).data)) continue;
    throw LogError(path_, "two answers for frame " + std::to_string(repeat.id.seq) + ": " +
                              std::string(ChannelOf(repeat.part)) + " at bytes " +
                              std::to_string(repeat.earlier) + " and " +
                              std::to_string(repeat.later) +
                              " differ; `sprout-log merge --replace` keeps those of one log");
  }
}

// The positions of a frame's parts. The first frames may stand before their calibration, which
// comes once a second, so this is searched further on.
IndexedFrame LogFrames::PlacesOf(size_t number) {
  IndexedFrame places = index_.At(number);
  if (places.Has(Part::kRig) || !choice_.parts.Has(Part::kRig) || knows_all_rigs_) return places;
  knows_all_rigs_ = true;
  LogReader ahead(path_);
  for (LogEvent event; ahead.Next(event);) index_.AddRig(event);
  return index_.At(number);
}

WholeFrames::WholeFrames(const std::filesystem::path& path, std::string prefix, PartSet needed,
                         Refuse refuse)
    : prefix_(std::move(prefix)),
      needed_(needed),
      refuse_(std::move(refuse)),
      reader_(path),
      joiner_(needed) {}

void WholeFrames::AddRig(std::span<const uint8_t> message) {
  static_cast<void>(joiner_.AddMessage(Part::kRig, message));
}

std::optional<WholeFrame> WholeFrames::Next() {
  for (LogEvent event; ready_.empty() && reader_.Next(event);) Take(event);
  if (ready_.empty()) {
    joiner_.DropPending();
    return std::nullopt;
  }
  WholeFrame next = std::move(ready_.front());
  ready_.pop_front();
  return next;
}

void WholeFrames::Take(const LogEvent& event) {
  channels_.Add(event.channel);
  const std::optional<Part> part = PartOf(event.channel, prefix_);
  if (!part || (part != Part::kRig && !needed_.Has(*part))) return;
  Result<std::vector<Frame>> whole = joiner_.AddMessage(*part, event.data);
  if (!whole) return refuse_(event, whole.error().text);
  if (part == Part::kRig) {
    newest_rig_ = event.offset;
  } else {
    PlacesOf(*DecodeFrameId(event.data)).offset(*part) = event.offset;
  }
  for (Frame& frame : *whole) {
    IndexedFrame places = PlacesOf(frame.id);
    ready_.push_back({std::move(frame), std::move(places)});
  }
  std::erase_if(pending_, [&](const IndexedFrame& one) { return !joiner_.IsPending(one.id); });
}

IndexedFrame& WholeFrames::PlacesOf(const FrameId& id) {
  const auto found = std::ranges::find(pending_, id, &IndexedFrame::id);
  return found != pending_.end() ? *found : pending_.emplace_back(id);
}

}  // namespace sprout
