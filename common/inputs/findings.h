#pragma once

#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace sprout::inputs {

/// What is asked of every frame.
enum class Question {
  kScene,     ///< do both images show one scene?
  kTime,      ///< at one time?
  kSides,     ///< is the left image the left one, and do disparities begin at infinity?
  kRows,      ///< do equal rows show equal things?
  kBits,      ///< do the images use the bits of their format?
  kContrast,  ///< do both images show things with one contrast?
  kHits,      ///< are there range points, and do they fall into the picture?
  kPlace,     ///< is the range image the right way up, and not mirrored?
  kScale,     ///< do ranges and stereo agree in scale?
  kMoment,    ///< do the ranges show what the images show?
};
inline constexpr int kQuestionCount = static_cast<int>(Question::kMoment) + 1;

enum class Verdict {
  kCannotTell,  ///< too little evidence, or what it depends on is bad
  kGood,
  kBad,
};

/// The answer to one question.
struct Finding {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  Question question = Question::kScene;
  Verdict verdict = Verdict::kCannotTell;
  /// The figure that decided, in the question's unit (UnitOf()), and its standard deviation; NaN =
  /// not known.
  double value = kUnknown;
  double sigma = kUnknown;
  /// One line without an end: what was found, and where it is bad, the cure; why one cannot tell.
  std::string text = {};
  /// The flag of `sprout-pipeline files` that puts it right, as "--tof-unit cm"; empty: none does.
  std::string flag = {};
  /// For kHits, if the only fault is that ranges of exactly this, m, mean no return; else 0.
  float no_return_m = 0;
  /// For kPlace: how far from their place range points lie, px of the left image; infinite: turned.
  double moved_px = std::numeric_limits<double>::infinity();
  /// For kSides: a tenth of the matches has a larger disparity, px of the images; 0: not known.
  double near_px = 0;
};

/// "scene", "time", "sides", "rows", "bits", "contrast", "hits", "place", "scale", "moment".
std::string_view NameOf(Question question);
/// "good", "bad", "cannot tell".
std::string_view NameOf(Verdict verdict);
/// The unit of a finding's value: "%", "px" or "1" (a factor).
std::string_view UnitOf(Question question);

/// One finding a question, in the order of the questions.
using Findings = std::vector<Finding>;

/// Whether the finding of one of these questions is bad.
bool AnyIsBad(const Findings& findings, std::initializer_list<Question> questions);

/// The lines of the bad findings, joined by "; "; empty when there is none.
std::string BadText(const Findings& findings);

/// What several frames of one rig and one recording say together: bad where more frames say bad
/// than good, and at least two do or all of them; good where more say good. Value: the median over
/// the frames of that verdict, sigma: of a frame. Text: of the frame whose value that is, with the
/// number of frames.
/// @param frames  of CheckInputs().
Findings Combine(const std::vector<Findings>& frames);

}  // namespace sprout::inputs
