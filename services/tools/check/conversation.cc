#include "services/tools/check/conversation.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/bus/channels.h"
#include "common/core/printable.h"

namespace sprout::check {
namespace {

using std::chrono::milliseconds;

// Captures of a camera at 10 Hz.
constexpr int64_t kFirstUtime = 1'700'000'000'000'000;
constexpr int64_t kFrameUtime = 100'000;
constexpr std::chrono::seconds kRigPeriod{1};  // as capture sends it

}  // namespace

Conversation::Sent& Conversation::Begin(const TestFrame& frame, AnswerCheck check) {
  const int64_t seq = std::ssize(sent_);
  Sent& sent = sent_[seq];
  sent.id = {
      .utime = kFirstUtime + pause_utime_ + seq * kFrameUtime, .seq = seq, .rig_id = frame.rig_id};
  sent.name = frame.name;
  sent.pair = frame.rig().pair;
  sent.check = check;
  return sent;
}

void Conversation::SendPart(Part part, std::span<const uint8_t> bytes) {
  ++own_[part];
  bus_.Send(ChannelOf(part), bytes);
}

std::optional<PartValue> Conversation::Ask(const TestFrame& frame, DisparityEncoding encoding,
                                           AnswerCheck check, Rule rule, milliseconds timeout) {
  Sent& sent = Begin(frame, check);
  for (const Part part : contract_.inputs) {
    if (part == Part::kRig) {
      const bool due = frame.rig_id != rig_id_ || Clock::now() >= rig_due_;
      if (!due) continue;
      rig_id_ = frame.rig_id;
      rig_due_ = Clock::now() + kRigPeriod;
    }
    SendPart(part, EncodePart(sent.id, part, frame.parts.at(part), encoding));
  }
  const Clock::time_point asked = Clock::now();
  awaited_ = &sent;
  while (sent.answers == 0 && !over() && Clock::now() < asked + timeout) {
    if (const auto heard = bus_.Next(std::min(Clock::now() + kPoll, asked + timeout))) {
      Take(*heard);
    } else {
      NoticeEnd(rule, sent.name);
    }
  }
  awaited_ = nullptr;
  if (sent.answers == 0 && check != AnswerCheck::kIfAnswered && !ended_) {
    ++frames_missed_;
    found_.Add(
        rule, fmt::format("{}: no answer on {} within {} s", sent.name, ChannelOf(contract_.answer),
                          std::chrono::duration<double>(timeout).count()));
  }
  if (sent.answers > 0 && check == AnswerCheck::kAll) {
    times_ms_.push_back(std::chrono::duration<double, std::milli>(sent.answered - asked).count());
  }
  return sent.answer;
}

void Conversation::SendBad(const TestFrame& frame, Part part, const Corruption& corruption) {
  Sent& sent = Begin(frame, AnswerCheck::kIfAnswered);
  sent.bad = true;
  sent.name = fmt::format("{}, {}", ChannelOf(part), corruption.name);
  SendPart(part, corruption.apply(EncodePart(sent.id, part, frame.parts.at(part))));
}

void Conversation::Listen(milliseconds time) {
  const Clock::time_point end = Clock::now() + time;
  while (const auto heard = bus_.Next(end)) Take(*heard);
}

void Conversation::NoticeEnd(Rule rule, const std::string& when) {
  const std::optional<std::string> how = HowItEnded(process_);
  if (!how || ended_) return;
  ended_ = true;
  found_.Add(rule, fmt::format("{}: the program {}", when, *how));
}

void Conversation::Take(const Heard& heard) {
  if (heard.channel == ChannelOf(contract_.answer)) {
    TakeAnswer(heard);
  } else {
    TakeOther(heard);
  }
}

// The frame that an answer belongs to: by its header, or else the one that is waited for.
Conversation::Sent* Conversation::Attribute(const Result<FrameId>& id) {
  if (!id) return awaited_;
  const auto found = sent_.find(id->seq);
  if (found == sent_.end()) {
    found_.Add(Rule::kHeader, fmt::format("an answer with seq = {}; {} was sent", id->seq,
                                          awaited_ ? awaited_->id.seq : std::ssize(sent_) - 1));
    return awaited_;
  }
  const FrameId& sent = found->second.id;
  if (id->utime != sent.utime) {
    found_.Add(Rule::kHeader, fmt::format("{}: answered with utime = {}; {} was sent",
                                          found->second.name, id->utime, sent.utime));
  }
  if (id->rig_id != sent.rig_id) {
    found_.Add(Rule::kHeader, fmt::format("{}: answered with rig_id = '{}'; '{}' was sent",
                                          found->second.name, id->rig_id, sent.rig_id));
  }
  return &found->second;
}

void Conversation::TakeAnswer(const Heard& heard) {
  ++answers_heard_;
  Sent* sent = Attribute(DecodeFrameId(heard.bytes));
  const std::string what =
      fmt::format("{}, {}", heard.channel, sent ? sent->name : std::string("unasked for"));
  Result<DecodedPart> decoded = DecodePart(contract_.answer, heard.bytes);
  if (!decoded) found_.Add(Rule::kForm, what + ": " + decoded.error().text);
  if (sent == nullptr) return;
  if (sent->bad) {
    found_.Add(Rule::kBadMessages, sent->name + ": was answered as if it were valid");
    return;
  }
  sent->answered = heard.when;
  if (++sent->answers > 1) {
    found_.Add(Rule::kOneAnswer, fmt::format("{}: {} answers", sent->name, sent->answers));
    return;
  }
  if (!decoded) return;
  if (sent->check == AnswerCheck::kAll) {
    CheckAnswer(decoded->value, sent->pair, what, found_);
    if (IsEmptyAnswer(decoded->value)) found_.Add(Rule::kValues, what + ": an empty answer");
  }
  sent->answer = std::move(decoded->value);
}

// What a stage may publish besides its answer.
void Conversation::TakeExtra(Part part, const Heard& heard) {
  const Result<DecodedPart> decoded = DecodePart(part, heard.bytes);
  extras_heard_.Add(part);
  if (!decoded) return found_.Add(Rule::kForm, heard.channel + ": " + decoded.error().text);
  Sent* const sent = Attribute(decoded->id);
  if (sent == nullptr || sent->bad) return;
  const std::string what = heard.channel + ", " + sent->name;
  if (const int count = ++sent->extras[part]; count > 1) {
    found_.Add(Rule::kOneAnswer, fmt::format("{}: {} messages", what, count));
  } else if (sent->check == AnswerCheck::kAll) {
    CheckExtra(part, decoded->value, sent->pair, what, found_);
  }
}

void Conversation::TakeOther(const Heard& heard) {
  if (heard.channel == kStatusChannel) {
    if (const Result<StageStatus> status = DecodeStatus(heard.bytes)) newest_status_ = *status;
  }
  if (CheckReport(heard, found_)) return;
  for (const Part part : kAllParts) {
    if (heard.channel != ChannelOf(part)) continue;
    if (contract_.may_publish.Has(part)) return TakeExtra(part, heard);
    if (own_[part]-- > 0) return;  // sent by this program
    return found_.Add(Rule::kChannels, fmt::format("published on {}; allowed is {}", heard.channel,
                                                   ChannelOf(contract_.answer)));
  }
  if (others_heard_.size() < kMaxOthers) others_heard_.insert(Printable(heard.channel));
}

}  // namespace sprout::check
