#include "common/inputs/findings.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "common/core/joined.h"

namespace sprout::inputs {
namespace {

struct QuestionRow {
  std::string_view name;
  std::string_view unit;
};
constexpr std::array<QuestionRow, kQuestionCount> kQuestions = {{{"scene", "%"},
                                                                 {"time", "px"},
                                                                 {"sides", "%"},
                                                                 {"rows", "px"},
                                                                 {"bits", "%"},
                                                                 {"contrast", "1"},
                                                                 {"hits", "%"},
                                                                 {"place", "%"},
                                                                 {"scale", "1"},
                                                                 {"moment", "%"}}};

// The finding whose value is the median among those with the verdict.
// @pre at least one has it.
Finding MedianFinding(const std::vector<Findings>& frames, size_t question, Verdict verdict) {
  std::vector<const Finding*> chosen;
  for (const Findings& frame : frames) {
    if (frame[question].verdict == verdict) chosen.push_back(&frame[question]);
  }
  const auto middle = chosen.begin() + static_cast<std::ptrdiff_t>(chosen.size() / 2);
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const Finding* a, const Finding* b) { return a->value < b->value; });
  return **middle;
}

}  // namespace

std::string_view NameOf(Question question) {
  return kQuestions[static_cast<size_t>(question)].name;
}
std::string_view UnitOf(Question question) {
  return kQuestions[static_cast<size_t>(question)].unit;
}

std::string_view NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "good";
    case Verdict::kBad:
      return "bad";
    case Verdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

bool AnyIsBad(const Findings& findings, std::initializer_list<Question> questions) {
  return std::ranges::any_of(findings, [&](const Finding& finding) {
    return finding.verdict == Verdict::kBad &&
           std::ranges::find(questions, finding.question) != questions.end();
  });
}

std::string BadText(const Findings& findings) {
  std::string text;
  for (const Finding& finding : findings) {
    if (finding.verdict == Verdict::kBad) text = JoinedTexts(text, finding.text);
  }
  return text;
}

Findings Combine(const std::vector<Findings>& frames) {
  Findings combined;
  if (frames.empty()) return combined;
  for (size_t question = 0; question < frames.front().size(); ++question) {
    const auto count = [&](Verdict verdict) {
      return static_cast<size_t>(std::ranges::count_if(
          frames, [&](const Findings& frame) { return frame[question].verdict == verdict; }));
    };
    const size_t bad = count(Verdict::kBad);
    const size_t good = count(Verdict::kGood);
    const bool is_bad = bad > good && (bad > 1 || bad == frames.size());
    const Verdict verdict = is_bad       ? Verdict::kBad
                            : good > bad ? Verdict::kGood
                                         : Verdict::kCannotTell;
    if (count(verdict) == 0) {
      combined.push_back(
          {.question = frames.front()[question].question, .text = "frames contradict each other"});
      continue;
    }
    combined.push_back(MedianFinding(frames, question, verdict));
    if (frames.size() > 1) {
      combined.back().text += fmt::format(" ({} of {} frames)", count(verdict), frames.size());
    }
  }
  return combined;
}

}  // namespace sprout::inputs
