#include "common/inputs/findings.h"

#include <gmock/gmock.h>

namespace sprout::inputs {
namespace {

Findings FrameThatSays(Verdict verdict, double value) {
  return {{.question = Question::kRows,
           .verdict = verdict,
           .value = value,
           .sigma = 0.1,
           .text = "rows"}};
}

TEST(Findings, OfSeveralFramesAreBadWhenMostSaySo) {
  const Findings bad = Combine({FrameThatSays(Verdict::kBad, 3), FrameThatSays(Verdict::kBad, 4),
                                FrameThatSays(Verdict::kBad, 9), FrameThatSays(Verdict::kGood, 0),
                                FrameThatSays(Verdict::kCannotTell, 0)});
  ASSERT_EQ(bad.size(), 1U);
  EXPECT_EQ(bad[0].verdict, Verdict::kBad);
  EXPECT_EQ(bad[0].value, 4);
  EXPECT_THAT(bad[0].text, testing::HasSubstr("3 of 5 frames"));
}

TEST(Findings, OfOneFrameAmongManyAreNotEnough) {
  EXPECT_EQ(
      Combine({FrameThatSays(Verdict::kBad, 3), FrameThatSays(Verdict::kCannotTell, 0)})[0].verdict,
      Verdict::kCannotTell);
  EXPECT_EQ(Combine({FrameThatSays(Verdict::kBad, 3)})[0].verdict, Verdict::kBad);
  EXPECT_EQ(Combine({FrameThatSays(Verdict::kBad, 3), FrameThatSays(Verdict::kGood, 0)})[0].verdict,
            Verdict::kCannotTell);
  EXPECT_TRUE(Combine({}).empty());
}

TEST(Findings, ThatAreBadAreJoinedInOneLine) {
  Findings findings = FrameThatSays(Verdict::kBad, 3);
  findings.push_back({.question = Question::kScale, .verdict = Verdict::kGood, .text = "scale"});
  findings.push_back({.question = Question::kBits, .verdict = Verdict::kBad, .text = "bits"});
  EXPECT_EQ(BadText(findings), "rows; bits");
}

}  // namespace
}  // namespace sprout::inputs
