#include "common/frames/frame_index.h"

#include <gmock/gmock.h>

#include "tests/common/app/log_files.h"

namespace sprout {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// An index of events that stand at bytes 0, 100, 200, ... of a log.
class Index : public FrameIndex {
 public:
  explicit Index(FrameChoice choice = {}) : FrameIndex(std::move(choice)) {}

  void Put(const TestEvent& event) {
    Add({.number = offset_ / 100,
         .utime = event.utime,
         .offset = offset_,
         .channel = event.channel,
         .data = event.data},
        [this](const LogEvent& at, const std::string& why) {
          refused.push_back(std::to_string(at.offset) + ": " + why);
        });
    offset_ += 100;
  }

  std::vector<int64_t> Seqs() const {
    std::vector<int64_t> seqs;
    for (const IndexedFrame& frame : frames()) seqs.push_back(frame.id.seq);
    return seqs;
  }

  std::vector<std::string> refused;

 private:
  int64_t offset_ = 0;
};

TEST(FrameIndex, PutsTheMessagesOfAFrameTogetherInWhateverOrderTheyCome) {
  Index index;
  for (const TestEvent& event : {LeftEvent(7, 1), LeftEvent(8, 1), RightEvent(8), TofEvent(7)}) {
    index.Put(event);
  }
  EXPECT_THAT(index.Seqs(), ElementsAre(7, 8));
  const IndexedFrame& first = index.frames()[0];
  EXPECT_EQ(first.id, TestId(7));
  EXPECT_EQ(first.offset(Part::kLeft), 0);
  EXPECT_EQ(first.offset(Part::kTof), 300);
  EXPECT_FALSE(first.Has(Part::kRight));
  EXPECT_EQ(index.frames()[1].offset(Part::kRight), 200);
}

TEST(FrameIndex, TakesTheNewestMessageOfAPartThatComesAgain) {
  Index index;
  for (const int grey : {1, 2, 3}) index.Put(LeftEvent(0, grey));
  EXPECT_THAT(index.Seqs(), ElementsAre(0));
  EXPECT_EQ(index.frames()[0].offset(Part::kLeft), 200);
  ASSERT_EQ(index.repeats().size(), 2U);
  EXPECT_EQ(index.repeats()[1].part, Part::kLeft);
  EXPECT_EQ(index.repeats()[1].earlier, 100);
  EXPECT_EQ(index.repeats()[1].later, 200);
}

TEST(FrameIndex, BeginsAnotherFrameWhenANameComesAgainLate) {
  Index index({.look_back = 2});
  index.Put(LeftEvent(0, 1));
  index.Put(LeftEvent(1, 1));
  index.Put(RightEvent(0));  // one other frame has begun
  index.Put(LeftEvent(2, 1));
  index.Put(TofEvent(0));  // two
  index.Put(LeftEvent(0, 1));
  EXPECT_THAT(index.Seqs(), ElementsAre(0, 1, 2, 0));
  EXPECT_EQ(index.frames()[0].offset(Part::kLeft), 0);
  EXPECT_EQ(index.frames()[0].offset(Part::kRight), 200);
  EXPECT_FALSE(index.frames()[0].Has(Part::kTof));
  EXPECT_EQ(index.Find(TestId(0)), &index.frames()[3]);
  EXPECT_EQ(index.frames()[3].offset(Part::kTof), 400);
  EXPECT_EQ(index.frames()[3].offset(Part::kLeft), 500);
  EXPECT_FALSE(index.frames()[3].Has(Part::kRight));
}

TEST(FrameIndex, HasOfACalibrationTheFirstMessageThatCanBeRead) {
  Index index;
  TestEvent torn = RigEvent(0);
  torn.data.pop_back();
  for (const TestEvent& event : {torn, RigEvent(1), RigEvent(2)}) index.Put(event);
  EXPECT_TRUE(index.frames().empty());
  index.Put(LeftEvent(0, 1));
  index.Add(Part::kLeft, {.utime = 1, .seq = 1, .rig_id = "other"}, 7);
  EXPECT_EQ(index.At(0).offset(Part::kRig), 100);
  EXPECT_EQ(index.At(0).offset(Part::kLeft), 300);
  EXPECT_FALSE(index.At(1).Has(Part::kRig));
  EXPECT_THAT(index.refused, ElementsAre(HasSubstr("0: ")));
}

TEST(FrameIndex, RefusesASecondCalibrationOfOneName) {
  Index index;
  Rig other = examples::Rig();
  other.pair.focal_px += 1;
  for (const TestEvent& event : {RigEvent(0), EventOf(1, Part::kRig, other, 0, "SPROUT_RIG"),
                                 RigEvent(2), LeftEvent(0, 1)}) {
    index.Put(event);
  }
  EXPECT_EQ(index.At(0).offset(Part::kRig), 0);
  EXPECT_THAT(index.refused,
              ElementsAre(HasSubstr("100: rig_id '" + TestId(0).rig_id + "' again")));
}

TEST(FrameIndex, RefusesWhatIsNotOfItsChannelsTypeOrNamesNoFrame) {
  Index index;
  TestEvent wrong = LeftEvent(0, 1);
  wrong.channel = "SPROUT_SEEDS";
  TestEvent nameless = LeftEvent(0, 1);
  nameless.data.resize(20);
  for (const TestEvent& event : {wrong, nameless}) index.Put(event);
  EXPECT_TRUE(index.frames().empty());
  EXPECT_THAT(index.refused, ElementsAre(HasSubstr("0: "), HasSubstr("100: ")));
}

TEST(FrameIndex, LooksOnlyAtWhatWasChosen) {
  Index index({.prefix = "A_", .parts = {Part::kLeft}, .frames = {.first = 1, .last = 2}});
  for (const int64_t seq : {0, 1, 2, 3}) {
    index.Put(LeftEvent(seq, 1, "A_"));
    index.Put(RightEvent(seq, "A_"));
    index.Put(LeftEvent(10 + seq, 1));
  }
  EXPECT_THAT(index.Seqs(), ElementsAre(1, 2));
  EXPECT_FALSE(index.frames()[0].Has(Part::kRight));
  EXPECT_TRUE(index.refused.empty());
}

TEST(FrameIndex, SaysWhichChannelsThereAreWhenThePrefixIsAnother) {
  Index index({.prefix = "B_"});
  EXPECT_EQ(index.OtherPrefixText(), "");
  index.Put(LeftEvent(0, 1, "A_"));
  EXPECT_EQ(index.OtherPrefixText(), "there are channels as A_SPROUT_LEFT, see --channel-prefix");
  index.Put(LeftEvent(0, 1, "B_"));
  EXPECT_EQ(index.OtherPrefixText(), "");
}

TEST(FrameIndex, FindsAFrameOfWhateverCalibration) {
  Index index;
  const FrameId id{.utime = 5, .seq = 3, .rig_id = "rig"};
  index.Add(Part::kPrior, id, 40);
  EXPECT_EQ(index.Find({.utime = 5, .seq = 3, .rig_id = ""})->offset(Part::kPrior), 40);
  EXPECT_EQ(index.Find(id)->id, id);
  EXPECT_EQ(index.Find({.utime = 5, .seq = 3, .rig_id = "other"}), nullptr);
  EXPECT_EQ(index.Find({.utime = 5, .seq = 2, .rig_id = ""}), nullptr);
  EXPECT_EQ(index.Find({.utime = 6, .seq = 3, .rig_id = ""}), nullptr);
}

}  // namespace
}  // namespace sprout
