#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/app/process.h"
#include "common/messages/codec.h"
#include "services/tools/check/contract.h"
#include "services/tools/check/program_check.h"
#include "services/tools/check/test_frames.h"

namespace sprout::check {

/// What to check in the answer to a frame.
enum class AnswerCheck {
  kIfAnswered,  ///< header and form, if an answer comes
  kForm,        ///< header and form; an answer must come
  kAll,         ///< also size and values; it must not be empty
};

/// Sends frames to a program that claims to be a stage, and receives its answers. Each frame is
/// sent as a new capture, and the next one only after the answer, so that the program must not skip
/// any. All received messages are checked.
class Conversation {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param process  the program.
  /// @param found    gets the findings. All must outlive the conversation.
  Conversation(const StageContract& contract, BusConnection& bus, Process& process, Findings& found)
      : contract_(contract), bus_(bus), process_(process), found_(found) {}

  /// Sends a frame and waits for its answer.
  ///
  /// @param encoding  of the maps in the frame.
  /// @param check      what to check.
  /// @param rule      that is broken when no answer comes.
  /// @param timeout   for the answer.
  /// @returns the answer; nothing when none came, or one that cannot be decoded.
  std::optional<PartValue> Ask(const TestFrame& frame, DisparityEncoding encoding,
                               AnswerCheck check, Rule rule, std::chrono::milliseconds timeout);

  /// Sends a corrupted message of the frame as a new capture; any answer to it is wrong.
  void SendBad(const TestFrame& frame, Part part, const Corruption& corruption);

  /// Lets an hour pass between the frames so far and the next one: a stage with memory forgets.
  void LetTimePass() { pause_utime_ += kPauseUtime; }

  /// Waits for messages that should no longer come.
  void Listen(std::chrono::milliseconds time);

  /// Checks whether the program has ended, which breaks `rule`; reports it once.
  /// @param when  named in the finding.
  void NoticeEnd(Rule rule, const std::string& when);

  bool ended() const { return ended_; }

  /// Whether the program has ended, or left so many frames unanswered that it is
  /// useless to go on.
  bool over() const { return ended_ || frames_missed_ >= kMaxMissed; }

  /// Frames that had to be answered and were not.
  int frames_missed() const { return frames_missed_; }

  /// Messages on the stage's channel, good ones and bad ones.
  int answers_heard() const { return answers_heard_; }

  /// The newest status that it sent; nothing when it sends none.
  const std::optional<StageStatus>& newest_status() const { return newest_status_; }

  /// What the stage published besides its answers.
  const PartSet& extras_heard() const { return extras_heard_; }

  /// Channels outside of the graph on which it published: the first eight.
  const std::set<std::string>& others_heard() const { return others_heard_; }

  /// Times from the last message of a frame sent to its answer, ms, for frames with
  /// AnswerCheck::kAll.
  const std::vector<double>& times_ms() const { return times_ms_; }

 private:
  static constexpr int kMaxMissed = 3;
  static constexpr size_t kMaxOthers = 8;
  static constexpr int64_t kPauseUtime = 3'600'000'000;

  struct Sent {
    FrameId id;
    std::string name;
    RectifiedPair pair;
    AnswerCheck check = AnswerCheck::kIfAnswered;
    bool bad = false;  // not a valid frame: an answer is wrong
    int answers = 0;
    std::map<Part, int> extras;
    std::optional<PartValue> answer;
    Clock::time_point answered;
  };

  Sent& Begin(const TestFrame& frame, AnswerCheck check);
  void SendPart(Part part, std::span<const uint8_t> bytes);
  void Take(const Heard& heard);
  void TakeAnswer(const Heard& heard);
  void TakeExtra(Part part, const Heard& heard);
  void TakeOther(const Heard& heard);
  Sent* Attribute(const Result<FrameId>& id);

  const StageContract& contract_;
  BusConnection& bus_;
  Process& process_;
  Findings& found_;
  std::map<int64_t, Sent> sent_;  // by seq
  std::map<Part, int64_t> own_;   // own messages not yet received, by part
  Sent* awaited_ = nullptr;
  Clock::time_point rig_due_{};
  std::string rig_id_;
  int64_t pause_utime_ = 0;
  int answers_heard_ = 0;
  PartSet extras_heard_;
  std::set<std::string> others_heard_;
  std::optional<StageStatus> newest_status_;
  int frames_missed_ = 0;
  bool ended_ = false;
  std::vector<double> times_ms_;
};

}  // namespace sprout::check
