#include "common/core/pair_names.h"

#include <gmock/gmock.h>

namespace sprout {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using Names = std::vector<std::string>;

// "a=b" of each pair.
Names PairsOf(const Names& first, const Names& second) {
  const auto paired = PairNames(first, second);
  if (!paired) return {paired.error().text};
  Names pairs;
  for (const auto& [a, b] : paired->pairs) pairs.push_back(first[a] + '=' + second[b]);
  return pairs;
}

PairedBy RuleOf(const Names& first, const Names& second) { return PairNames(first, second)->by; }

TEST(PairNames, TakesTimesWhereNamesHaveThem) {
  const Names left = {"l/1403636579763555584.png", "l/1403636579813555584.png",
                      "l/1403636579913555584.png"};
  const Names right = {"r/1403636579913555600.png", "r/1403636579763999999.png",
                       "r/1403636579863555584.png"};
  EXPECT_THAT(PairsOf(left, right),
              ElementsAre(left[0] + '=' + right[1], left[2] + '=' + right[0]));
  const auto paired = PairNames(left, right);
  EXPECT_EQ(paired->by, PairedBy::kTime);
  EXPECT_THAT(paired->alone_first, ElementsAre(1));
  EXPECT_THAT(paired->alone_second, ElementsAre(2));
  // 0.05 s is not 0.5 s.
  EXPECT_THAT(PairsOf({"1305031102.05.png", "1305031102.50.png"},
                      {"1305031102.0501.png", "1305031102.5001.png"}),
              ElementsAre("1305031102.05.png=1305031102.0501.png",
                          "1305031102.50.png=1305031102.5001.png"));
}

TEST(PairNames, RefusesTimesThatAreFurtherApartThanAllowed) {
  const Names left = {"1403636579763.png", "1403636579863.png"};
  const Names right = {"1403636579793.png", "1403636579893.png"};
  EXPECT_THAT(PairsOf(left, right), ElementsAre(HasSubstr("differ by 30 ms or more; allowed: 20")));
  EXPECT_EQ(PairNames(left, right, 30)->pairs.size(), 2U);
}

TEST(PairNames, DoesNotJoinNeighboursOfFastCamerasThatEachLostAnImage) {
  const Names left = {"1403636579000.png", "1403636579016.png", "1403636579033.png",
                      "1403636579066.png", "1403636579083.png"};  // without 050
  const Names right = {"1403636579000.png", "1403636579016.png", "1403636579050.png",
                       "1403636579066.png", "1403636579083.png"};  // without 033
  const auto paired = PairNames(left, right);
  EXPECT_EQ(paired->pairs.size(), 4U);
  EXPECT_THAT(paired->alone_first, ElementsAre(2));
  EXPECT_THAT(paired->alone_second, ElementsAre(2));
}

TEST(PairNames, TakesTimesOfOneSecondBehindOtherWords) {
  const Names left = {"l/left_1403636579.100000.png", "l/left_1403636579.150000.png",
                      "l/left_1403636579.250000.png"};
  const Names right = {"r/right_1403636579.150500.png", "r/right_1403636579.200500.png",
                       "r/right_1403636579.250500.png"};
  EXPECT_THAT(PairsOf(left, right),
              ElementsAre(left[1] + '=' + right[0], left[2] + '=' + right[2]));
  EXPECT_EQ(RuleOf(left, right), PairedBy::kTime);
  EXPECT_THAT(PairsOf({"1403636579763_l.png", "1403636579863_l.png"},
                      {"1403636579765_r.png", "1403636579965_r.png"}),
              ElementsAre("1403636579763_l.png=1403636579765_r.png"));
}

TEST(PairNames, TakesNoSerialNumberForATime) {
  EXPECT_THAT(PairsOf({"1234567890123_1.png", "1234567890123_2.png"},
                      {"1234567890456_2.png", "1234567890456_3.png"}),
              ElementsAre("1234567890123_2.png=1234567890456_2.png"));
  EXPECT_THAT(PairsOf({"1234567890_1.1.png", "1234567890_1.2.png"},
                      {"1234567899_1.2.png", "1234567899_1.3.png"}),
              ElementsAre("1234567890_1.2.png=1234567899_1.2.png"));
}

TEST(PairNames, NamesAFrameThatIsThereTwice) {
  EXPECT_THAT(PairsOf({"l/0.png", "l/02.png", "l/1.png", "l/2.png"},
                      {"r/0.png", "r/1.png", "r/2.png", "r/3.png"}),
              ElementsAre("l/02.png and l/2.png have one name or number; allowed: one of them"));
  EXPECT_THAT(PairsOf({"l/1.png", "l/2.png", "l/3.png"}, {"r/0002.jpg", "r/0002.png", "r/4.png"}),
              ElementsAre(HasSubstr("r/0002.jpg and r/0002.png have one name or number")));
  EXPECT_THAT(PairsOf({"l_2.png", "l_02.png", "l_3.png"}, {"r_2.png", "r_3.png", "r_4.png"}),
              ElementsAre(HasSubstr("l_2.png and l_02.png have one name or number")));
  // Numbers with a point.
  EXPECT_THAT(PairsOf({"l/0.05.png", "l/0.5.png"}, {"r/0.05.png", "r/0.5.png"}),
              ElementsAre("l/0.05.png=r/0.05.png", "l/0.5.png=r/0.5.png"));
}

TEST(PairNames, GivesNoImageTwoPartners) {
  const Names left = {"1403636579763.png", "1403636579767.png"};
  EXPECT_THAT(PairsOf(left, {"1403636579765.png", "1403636580000.png"}),
              ElementsAre("1403636579763.png=1403636579765.png"));
}

TEST(PairNames, TakesEqualNamesAndNumbersInTheOrderOfNumbers) {
  EXPECT_THAT(PairsOf({"l/10.png", "l/2.png", "l/0.png"}, {"r/0.png", "r/10.jpg", "r/2.png"}),
              ElementsAre("l/0.png=r/0.png", "l/2.png=r/2.png", "l/10.png=r/10.jpg"));
  EXPECT_THAT(PairsOf({"left_1.png", "left_3.png"}, {"right_003.png", "right_002.png"}),
              ElementsAre("left_3.png=right_003.png"));
  EXPECT_THAT(PairsOf({"x/im0.png", "y/im0.png"}, {"y/im1.png", "z/im1.png"}),
              ElementsAre("y/im0.png=y/im1.png"));
  EXPECT_THAT(PairsOf({"l/art.png", "l/aloe.png"}, {"r/aloe.png", "r/bowling.png"}),
              ElementsAre("l/aloe.png=r/aloe.png"));
  // KITTI's counters have ten digits, and are no times.
  EXPECT_EQ(RuleOf({"0000000001.png", "0000000002.png"}, {"0000000001.png", "0000000002.png"}),
            PairedBy::kName);
}

TEST(PairNames, DoesNotCutNumbersApart) {
  EXPECT_THAT(PairsOf({"l10.png", "l11.png"}, {"r0.png", "r1.png", "r10.png"}),
              ElementsAre("l10.png=r10.png"));
}

TEST(PairNames, TakesTheOrderOnlyOfAsMany) {
  const Names left = {"c.png", "a.png"};
  EXPECT_EQ(RuleOf(left, {"1.png", "2.png"}), PairedBy::kOrder);
  EXPECT_THAT(PairsOf(left, {"10.png", "9.png"}), ElementsAre("a.png=9.png", "c.png=10.png"));
  EXPECT_THAT(PairsOf(left, {"1.png", "2.png", "3.png"}),
              ElementsAre(HasSubstr("which of 2 and 3 files belong together; allowed: equal")));
}

TEST(PairNames, TakesTheNearestNumbersWhereTheyCountAlike) {
  // Nanoseconds since the start; each camera lost another frame, so that there are as many.
  const Names left = {"l/123456789012.png", "l/123506789012.png", "l/123556789012.png",
                      "l/123656789012.png", "l/123706789012.png"};
  const Names right = {"r/123456790012.png", "r/123556790012.png", "r/123606790012.png",
                       "r/123656790012.png", "r/123706790012.png"};
  EXPECT_THAT(PairsOf(left, right),
              ElementsAre(left[0] + '=' + right[0], left[2] + '=' + right[1],
                          left[3] + '=' + right[3], left[4] + '=' + right[4]));
  EXPECT_THAT(PairNames(left, right)->alone_first, ElementsAre(1));
  EXPECT_THAT(PairNames(left, right)->alone_second, ElementsAre(2));
  // Not as many; with a fraction; dates.
  EXPECT_THAT(PairsOf({"0.000.png", "0.033.png", "0.067.png"}, {"0.035.png", "0.068.png"}),
              ElementsAre("0.033.png=0.035.png", "0.067.png=0.068.png"));
  EXPECT_THAT(
      PairsOf({"20240301_120000_100.png", "20240301_120001_200.png", "20240301_120002_300.png"},
              {"20240301_120000_103.png", "20240301_120002_303.png", "20240301_120003_403.png"}),
      ElementsAre("20240301_120000_100.png=20240301_120000_103.png",
                  "20240301_120002_300.png=20240301_120002_303.png"));
}

TEST(PairNames, RefusesAnOrderWhoseNumbersMakeOtherSteps) {
  // Counters of two cameras; one of them lost its third frame.
  EXPECT_EQ(RuleOf({"7.png", "8.png", "9.png"}, {"101.png", "102.png", "103.png"}),
            PairedBy::kOrder);
  EXPECT_THAT(PairsOf({"7.png", "8.png", "9.png"}, {"101.png", "102.png", "104.png"}),
              ElementsAre(HasSubstr("before 9.png or before 104.png a file is missing")));
}

TEST(PairNames, LooksAtTheNamesOfOneFileEach) {
  EXPECT_THAT(PairsOf({"left_1.png"}, {"right_2.png"}), ElementsAre("left_1.png=right_2.png"));
  EXPECT_EQ(RuleOf({"left_1.png"}, {"right_2.png"}), PairedBy::kOrder);
  EXPECT_EQ(RuleOf({"l/1.png"}, {"r/1.png"}), PairedBy::kName);
  // Argoverse: each lost another frame.
  EXPECT_THAT(PairsOf({"315967900949927215.png", "315967901149927217.png"},
                      {"315967901049927216.png", "315967901149927219.png"}),
              ElementsAre("315967901149927217.png=315967901149927219.png"));
  EXPECT_THAT(PairsOf({"1403636579763.png"}, {"1403636579863.png"}),
              ElementsAre(HasSubstr("differ by 100 ms")));
}

TEST(PairNames, TakesSecondsAndNanosecondsWithoutLeadingZeros) {
  // As ROS's stamps are written by hand; each lost another frame.
  for (const std::string point : {".", "_"}) {
    const std::string before = "1403636579" + point, behind = "1403636580" + point;
    const Names left = {before + "950005000.png", behind + "5000.png", behind + "50005000.png"};
    const Names right = {behind + "7000.png", behind + "50007000.png", behind + "500007000.png"};
    EXPECT_THAT(PairsOf(left, right),
                ElementsAre(left[1] + '=' + right[0], left[2] + '=' + right[1]));
  }
}

TEST(StampOf, KnowsSecondsToNanoseconds) {
  constexpr int64_t kSecond = 1'000'000'000;
  EXPECT_EQ(StampOf("1403636579"), 1403636579 * kSecond);
  EXPECT_EQ(StampOf("1403636579763"), 1403636579 * kSecond + 763'000'000);
  EXPECT_EQ(StampOf("1403636579763555584"), 1403636579763555584);
  EXPECT_EQ(StampOf("315967900949927215"), 315967900949927215);
  EXPECT_EQ(StampOf("1305031102.175304"), 1305031102 * kSecond + 175'304'000);
  EXPECT_EQ(StampOf("1305031102_175304123"), 1305031102 * kSecond + 175'304'123);
  for (const char* name :
       {"", "12", "0000000010", "20231126_101530", "frame_0", "14036365797", "1403636579_12",
        "1403636579.", "14036365797635555841", "1403636579 1"}) {
    EXPECT_EQ(StampOf(name), std::nullopt) << name;
  }
}

TEST(PairTimes, JoinsVideosOfDifferentRatesAndSaysWhatIsNearest) {
  constexpr int64_t kMs = 1'000'000;
  const std::vector<int64_t> first = {0, 100 * kMs, 200 * kMs};
  const std::vector<int64_t> second = {0, 33 * kMs, 67 * kMs, 103 * kMs, 133 * kMs, 167 * kMs};
  const PairedNames paired = PairTimes(first, second, 16);
  ASSERT_EQ(paired.pairs.size(), 2U);
  EXPECT_EQ(paired.pairs[1].second, 3U);
  EXPECT_THAT(paired.alone_second, ElementsAre(1, 2, 4, 5));
  EXPECT_EQ(paired.least_spread_ms, 0);
  EXPECT_THAT(PairTimes(first, {}, 16).pairs, testing::IsEmpty());
}

}  // namespace
}  // namespace sprout
