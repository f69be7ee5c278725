#include "common/app/answer.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/common/app/captured_log.h"

namespace sprout {
namespace {

// Says what it is told to.
class FixedAdapter : public StageAdapter {
 public:
  explicit FixedAdapter(std::vector<PartOutput> outputs) : outputs_(std::move(outputs)) {}
  PartSet Inputs() const override { return {}; }
  StageResult Process(const Frame&) override { return {.outputs = outputs_, .degenerate = ""}; }

 private:
  std::vector<PartOutput> outputs_;
};

float CoverageOf(const Frame& frame, std::vector<PartOutput> outputs) {
  CapturedLog log;
  StageMonitor monitor("stage", "");
  FixedAdapter adapter(std::move(outputs));
  return MakeAnswer(frame, adapter, DisparityEncoding::kRawInt16, monitor).value().tof_coverage;
}

Frame FrameOf(cv::Size size) {
  Frame frame;
  frame.left = cv::Mat(size, CV_8UC1, cv::Scalar(0));
  return frame;
}

SeedSet OneSeed() { return {.seeds = {{3, 3, 1}}, .raw = 1}; }

TEST(Answer, SaysHowMuchTheSeedsThatWereMadeCover) {
  EXPECT_EQ(CoverageOf(FrameOf({16, 16}), {{Part::kSeeds, OneSeed()}}), 0.25F);
  EXPECT_EQ(CoverageOf(FrameOf({16, 16}), {{Part::kSeeds, SeedSet()}}), 0);
}

TEST(Answer, SaysHowMuchTheSeedsThatCameInCover) {
  Frame frame = FrameOf({16, 16});
  frame.seeds = OneSeed();
  EXPECT_EQ(CoverageOf(frame, {}), 0.25F);
  EXPECT_EQ(CoverageOf(frame, {{Part::kPrior, PriorMap(cv::Size(16, 16))}}), 0.25F);
}

TEST(Answer, DoesNotKnowTheCoverageWithoutSeedsOrWithoutAnImage) {
  EXPECT_EQ(CoverageOf(FrameOf({16, 16}), {}), kUnknownCoverage);
  Frame frame;
  frame.seeds = OneSeed();
  EXPECT_EQ(CoverageOf(frame, {}), kUnknownCoverage);
  EXPECT_EQ(CoverageOf(FrameOf({16, 16}), {{Part::kLeftSeeds, OneSeed()}}), kUnknownCoverage)
      << "what only the left camera sees is not counted by all stages";
}

TEST(Answer, HasTheRangeErrorOfTheStage) {
  class OffAdapter : public StageAdapter {
   public:
    PartSet Inputs() const override { return {}; }
    StageResult Process(const Frame&) override {
      return {.outputs = {}, .degenerate = "", .finding = "off by +10 mm"};
    }
  };
  StageMonitor monitor("stage", "");
  OffAdapter adapter;
  EXPECT_EQ(MakeAnswer({}, adapter, DisparityEncoding::kRawInt16, monitor).value().finding,
            "off by +10 mm");
}

}  // namespace
}  // namespace sprout
