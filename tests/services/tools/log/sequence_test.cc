#include "services/tools/log/sequence.h"

#include <gtest/gtest.h>

namespace sprout::log {
namespace {

FrameId Id(int64_t seq, int64_t start = 0) {
  return {.utime = start + 100 * seq, .seq = seq, .rig_id = ""};
}

TEST(Sequence, CountsWhatIsLeftOut) {
  Sequence sequence;
  for (const int seq : {3, 4, 6, 10, 11}) sequence.Add(Id(seq));
  EXPECT_EQ(sequence.first(), 3);
  EXPECT_EQ(sequence.last(), 11);
  EXPECT_EQ(sequence.missing(), 4);
  EXPECT_EQ(sequence.GapText(), "5, 7-9");
  EXPECT_EQ(sequence.repeated(), 0);
}

TEST(Sequence, KnowsFramesThatComeAgain) {
  Sequence sequence;
  for (const int seq : {0, 1, 0, 1, 1, 2}) sequence.Add(Id(seq));
  EXPECT_EQ(sequence.repeated(), 3);
  EXPECT_EQ(sequence.missing(), 0);
  EXPECT_EQ(sequence.restarts(), 0);
}

TEST(Sequence, KnowsACaptureThatBeganAnew) {
  Sequence sequence;
  for (const int seq : {7, 8}) sequence.Add(Id(seq));
  for (const int seq : {0, 1, 3}) sequence.Add(Id(seq, 1'000'000));
  EXPECT_EQ(sequence.restarts(), 1);
  EXPECT_EQ(sequence.missing(), 1);
  EXPECT_EQ(sequence.last(), 3);
}

TEST(Sequence, ShowsTheFirstGapsOnly) {
  Sequence sequence;
  for (int seq = 0; seq < 100; seq += 2) sequence.Add(Id(seq));
  EXPECT_EQ(sequence.missing(), 49);
  EXPECT_EQ(sequence.GapText(), "1, 3, 5, 7, 9, 11, 13, 15, 17, 19, ...");
}

TEST(Sequence, SurvivesNumbersThatAreDamaged) {
  Sequence sequence;
  for (int i = 0; i < 3; ++i) {
    sequence.Add(Id(0, 1000 * i));
    sequence.Add({.utime = 1000 * i + 500, .seq = INT64_MAX, .rig_id = ""});
  }
  EXPECT_EQ(sequence.missing(), INT64_MAX);
}

}  // namespace
}  // namespace sprout::log
