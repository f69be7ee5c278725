#include "services/grow/confidence/confidence_model.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/common/testing/thrown.h"

namespace sprout::grow {
namespace {

using testing::HasSubstr;

std::string CurveText(const std::string& feature, const std::string& values) {
  return "curve { feature: " + feature + " doubt: [" + values + "] spread: [" + values + "] }\n";
}

const std::string kRising = "0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16";
const std::string kFalling = "16,15,14,13,12,11,10,9,8,7,6,5,4,3,2,1,0";

std::string ModelText(const std::string& step = CurveText("STEP", kRising)) {
  std::string text = "doubt: -1024\nspread: 256\n" + step + CurveText("EDGE", kFalling);
  for (const char* feature :
       {"BEND", "MARGIN", "GAPS", "BLANK", "TOF_SEED", "SEED", "PRIOR", "ROUGH"}) {
    text += CurveText(feature, kRising);
  }
  return text;
}

std::string ComplaintAbout(const std::string& text) {
  return Thrown<ConfigError>([&] { ParseConfidenceModel(text, "model"); });
}

TEST(LevelOf, IsSixteenTimesTheLogarithmRoundedDown) {
  EXPECT_EQ(LevelOf(1), 0);
  EXPECT_EQ(LevelOf(2), 16);
  EXPECT_EQ(LevelOf(3), 24);
  EXPECT_EQ(LevelOf(97), 104);
  EXPECT_EQ(LevelOf(32 + 1), kEdgeLevel - 1);  // a range of 1 px
  EXPECT_EQ(LevelOf(33 + 1), kEdgeLevel);
  EXPECT_EQ(LevelOf(1 << 24), 24 * 16);
  for (int x = 1; x < 100000; ++x) {
    ASSERT_LE(LevelOf(x), LevelOf(x + 1)) << x;
    ASSERT_NEAR(LevelOf(x), 16 * std::log2(x), 2.5) << x;
  }
}

TEST(ConfidenceModel, TheOneThatShipsLoadsAndNoCurveHasTheWrongSign) {
  const ConfidenceTables tables =
      ParseConfidenceModel(kConfidenceModelText, "confidence_model.textproto");
  for (const auto* table : {&tables.step, &tables.bend, &tables.margin, &tables.gaps, &tables.blank,
                            &tables.prior, &tables.rough}) {
    for (size_t i = 1; i < table->size(); ++i) {
      ASSERT_LE((*table)[i - 1] >> 16, (*table)[i] >> 16);
      ASSERT_LE((*table)[i - 1] & 0xffff, (*table)[i] & 0xffff);
    }
  }
  for (size_t i = 1; i < 256; ++i) {
    ASSERT_LE(tables.edge[i - 1] >> 16, tables.edge[i] >> 16);  // nearer
    ASSERT_GE(tables.tof_seed[i - 1] >> 16, tables.tof_seed[i] >> 16);
    ASSERT_GE(tables.seed[i - 1] & 0xffff, tables.seed[i] & 0xffff);
  }
  EXPECT_GT(tables.prior[255] & 0xffff, tables.prior[4] & 0xffff);  // σ follows the prior's
}

TEST(ConfidenceTables, AreProbabilityAndStandardDeviation) {
  const ConfidenceTables tables = ParseConfidenceModel(ModelText(), "model");
  const auto odds = [](int whole) { return static_cast<uint32_t>(whole + 16) << 24; };
  EXPECT_EQ(tables.ConfidenceOf(odds(0)), 128);  // 127.5
  EXPECT_EQ(tables.ConfidenceOf(odds(-16)), 255);
  EXPECT_EQ(tables.ConfidenceOf(odds(2)), std::lround(255 / (1 + std::exp(2))));
  EXPECT_EQ(tables.ConfidenceOf(odds(16)), 0);
  EXPECT_EQ(tables.ConfidenceOf(~uint32_t{0}), 0);
  EXPECT_EQ(tables.SigmaOf(0), 1);
  EXPECT_EQ(tables.SigmaOf(4 * 256), 16);
  EXPECT_EQ(tables.SigmaOf(0xffff), 255);
  EXPECT_EQ(tables.start, uint32_t{12 * 256} << 16 | 256);
  EXPECT_EQ(tables.step[24] >> 16, 2);  // between 1 and 2, rounded
  EXPECT_EQ(tables.prior[16], uint32_t{4} << 16 | 4);
}

TEST(ConfidenceModel, IsRefusedWithOneLineThatNamesWhatIsWrong) {
  EXPECT_EQ(ComplaintAbout(ModelText()), "no error");
  EXPECT_THAT(ComplaintAbout(ModelText("")), HasSubstr("model: curves of 9 features; allowed"));
  EXPECT_THAT(ComplaintAbout(ModelText() + CurveText("STEP", kRising)),
              HasSubstr("model: STEP: twice; allowed: once"));
  EXPECT_THAT(ComplaintAbout(ModelText(CurveText("STEP", "0, 1"))),
              HasSubstr("model: STEP.doubt: 2 values; allowed: 17"));
  EXPECT_THAT(ComplaintAbout(ModelText(CurveText("STEP", kFalling))),
              HasSubstr("model: STEP.doubt: 15 after 16; allowed: values that never fall"));
  EXPECT_THAT(ComplaintAbout(ModelText(CurveText("STEP", kRising.substr(0, 37) + ",4701"))),
              HasSubstr("model: STEP.doubt: 4701; allowed: 0 to 4700"));
  EXPECT_THAT(ComplaintAbout("doubt: 5000"), HasSubstr("model.doubt = 5000: out of range"));
  EXPECT_THAT(ComplaintAbout("nonsense"), HasSubstr("model:1:"));
  for (const std::string& bad : {ModelText(""), std::string("doubt: 5000"), std::string("{")}) {
    EXPECT_EQ(ComplaintAbout(bad).find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace sprout::grow
