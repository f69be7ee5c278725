#ifndef SPROUT_SERVICES_CHECK_CONVERSATION_H_
#define SPROUT_SERVICES_CHECK_CONVERSATION_H_

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/app/process.h"
#include "common/messages/codec.h"
#include "services/check/bad_messages.h"
#include "services/check/contract.h"
#include "services/check/findings.h"
#include "services/check/test_frames.h"
#include "services/check/wire.h"

namespace sprout::check {

/// What one may look at in the answer to a frame.
enum class Look {
  kIfAnswered,  ///< at header and form of an answer, which need not come
  kForm,        ///< at that; it must come
  kAll,         ///< also at size and values, and it must not be empty
};

/// Talks with a program that claims to be a stage: frames out, answers in. Each frame is sent as a
/// new capture, and the next one only when the answer came, so that the program may never skip one.
/// Whatever is heard is checked.
class Conversation {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param process  the program.
  /// @param found    gets what is wrong.
  /// All must outlive the conversation.
  Conversation(const StageContract& contract, Wire& wire, Process& process, Findings& found)
      : contract_(contract), wire_(wire), process_(process), found_(found) {}

  /// Sends a frame and waits for its answer.
  ///
  /// @param encoding  of the maps in the frame.
  /// @param look      at what.
  /// @param rule      that is broken when no answer comes.
  /// @param timeout   for the answer.
  /// @returns the answer; nothing when none came, or one that cannot be decoded.
  std::optional<PartValue> Ask(const TestFrame& frame, DisparityEncoding encoding, Look look,
                               Rule rule, std::chrono::milliseconds timeout);

  /// Sends a message of the frame, spoiled, as a new capture; what answers it is wrong.
  void SendBad(const TestFrame& frame, Part part, const Spoiling& spoiling);

  /// Listens for what should not come any more.
  void Listen(std::chrono::milliseconds time);

  /// Looks whether the program has ended, which breaks `rule`; reports it once.
  /// @param when  said in what is found.
  void NoticeEnd(Rule rule, const std::string& when);

  bool ended() const { return ended_; }

  /// Whether the program has ended, or left so many frames unanswered that it is
  /// useless to go on.
  bool over() const { return ended_ || frames_missed_ >= kMaxMissed; }

  /// Frames that had to be answered and were not.
  int frames_missed() const { return frames_missed_; }

  /// Messages on the stage's channel, good ones and bad ones.
  int answers_heard() const { return answers_heard_; }

  /// What the stage published besides its answers.
  const PartSet& extras_heard() const { return extras_heard_; }

  /// From the last message of a frame sent to its answer, ms, for frames with Look::kAll.
  const std::vector<double>& times_ms() const { return times_ms_; }

 private:
  static constexpr int kMaxMissed = 3;

  struct Sent {
    FrameId id;
    std::string name;
    cv::Size size;  // of the rectified images
    Look look = Look::kIfAnswered;
    bool bad = false;  // no good frame: an answer is wrong
    int answers = 0;
    std::optional<PartValue> answer;
    Clock::time_point answered;
  };

  Sent& Begin(const TestFrame& frame, Look look);
  void SendPart(Part part, std::span<const uint8_t> bytes);
  void Take(const Heard& heard);
  void TakeAnswer(const Heard& heard);
  void TakeExtra(Part part, const Heard& heard);
  void TakeOther(const Heard& heard);
  Sent* Attribute(const Result<FrameId>& id);

  const StageContract& contract_;
  Wire& wire_;
  Process& process_;
  Findings& found_;
  std::map<int64_t, Sent> sent_;  // by seq
  std::map<Part, int64_t> own_;   // messages sent that were not yet heard, by part
  Sent* awaited_ = nullptr;
  Clock::time_point rig_due_{};
  std::string rig_id_;
  int answers_heard_ = 0;
  PartSet extras_heard_;
  int frames_missed_ = 0;
  bool ended_ = false;
  std::vector<double> times_ms_;
};

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_CHECK_CONVERSATION_H_
