#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "common/core/frame.h"
#include "common/measure/frame_quality.h"
#include "common/measure/score.h"
#include "common/scenes/dataset.h"

namespace sprout::evaluate {

/// Which frames of a log.
struct LogChoice {
  std::string file;
  std::string frames;  ///< A:B; empty: all
  std::string prefix;  ///< of every channel
};

/// Reads a log and gives its frames, each with the parts that the log has. Programs pass this
/// function, since this library knows no messages.
using ReadLog = std::function<void(const LogChoice&, const std::function<void(const Frame&)>&)>;

/// Evaluates recorded answers: against ground truth if a source has it, and always by FrameQuality.
class LogEvaluation {
 public:
  /// @param truth  frame `seq` of the log is its frame `seq`, modulo its length; null: no ground
  ///               truth.
  explicit LogEvaluation(std::unique_ptr<scenes::Dataset> truth) : truth_(std::move(truth)) {}

  /// Takes a frame; one without a disparity map is counted as unanswered. A repeated frame replaces
  /// the earlier one if it has at least as many parts.
  /// @throws ConfigError when ground truth and map differ in size, or the left images are not one
  ///         picture.
  void Add(const Frame& frame);

  /// For people: of each recorded map the accuracy over all frames, then the figures of
  /// QualityColumns(), mean and worst frame.
  std::string Table() const;

  /// A row a frame, in order of time: seq, utime, the figures of QualityColumns(), and with ground
  /// truth scored, correct_le1, bad2, density, mean_abs_px of the disparity map (nonocc).
  std::string Csv() const;
  std::string Json() const;

  int64_t answered() const;

  /// WrongTruthText() of the first frame.
  const std::string& wrong_truth() const { return wrong_truth_; }

 private:
  struct Row {
    FrameQuality quality;
    std::map<std::string, Accuracy> maps;  // prior, grown, filled; with ground truth only
  };

  Row Evaluate(const Frame& frame);

  std::unique_ptr<scenes::Dataset> truth_;
  std::map<std::pair<int64_t, int64_t>, Row> rows_;  // by utime and seq
  std::string wrong_truth_;
};

}  // namespace sprout::evaluate
