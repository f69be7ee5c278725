#include "services/view/log_file.h"

#include <gmock/gmock.h>

#include <condition_variable>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/logfile/log_writer.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/view/view_frames.h"

namespace sprout::view {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ViewLogTest : public ::testing::Test {
 protected:
  // A log of three frames; the calibration stands behind the first's left image.
  void Write(const std::string& prefix, int64_t first = 0) {
    LogWriter writer(path_);
    const auto write = [&](int64_t seq, Part part, const PartValue& value) {
      writer.Write(ViewId(seq).utime, prefix + std::string(ChannelOf(part)),
                   Encoded(seq, part, value));
    };
    for (int64_t seq = first; seq < first + 3; ++seq) {
      write(seq, Part::kLeft, ViewImage(static_cast<int>(seq)));
      if (seq == first) write(seq, Part::kRig, ViewRig());
      write(seq, Part::kDisparity, ViewMap());
    }
    StageStatus status;
    status.stage = "grow";
    status.pid = 7;
    status.frames_out = 3;
    writer.Write(2'000'000, prefix + std::string(kStatusChannel), EncodeStatus(status));
    writer.Close();
  }

  // Opens the log and waits until it is read.
  std::unique_ptr<LogFile> Open(const std::string& prefix = "") {
    auto log = std::make_unique<LogFile>(path_, prefix, history_, [this] {
      const std::lock_guard lock(mutex_);
      changed_.notify_all();
    });
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(
        changed_.wait_for(lock, std::chrono::seconds(30), [&] { return log->progress() >= 1; }));
    return log;
  }

  TemporaryDirectory folder_;
  std::filesystem::path path_ = folder_ / "run.lcm";
  StatusHistory history_{{}, /*keep_all=*/true};
  std::mutex mutex_;
  std::condition_variable changed_;
};

TEST_F(ViewLogTest, HasEveryFrameWithItsCalibration) {
  Write("A_");
  const auto log = Open("A_");
  EXPECT_EQ(log->complaint(), "");
  EXPECT_EQ(log->keys(), (KeyRange{0, 2}));
  for (int64_t key = 0; key < 3; ++key) {
    const StoredFramePtr frame = log->Get(key);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->id, ViewId(key));
    EXPECT_TRUE(frame->Has(Part::kLeft) && frame->Has(Part::kDisparity) && frame->Has(Part::kRig));
    EXPECT_FALSE(frame->Has(Part::kSeeds));
  }
  EXPECT_EQ(log->Get(3), nullptr);
  EXPECT_EQ(log->Get(-1), nullptr);
  const auto board = nlohmann::json::parse(history_.BoardText(history_.newest()));
  EXPECT_EQ(board["stages"][0]["frames_out"], 3);
}

TEST_F(ViewLogTest, FindsAFrameByItsNumber) {
  Write("", 40);
  const auto log = Open();
  EXPECT_EQ(log->KeyOf(40), 0);
  EXPECT_EQ(log->KeyOf(42), 2);
  EXPECT_EQ(log->KeyOf(0), std::nullopt);
}

TEST_F(ViewLogTest, ShowsOfEachStretchTheWorstFrame) {
  Write("");
  const auto log = Open();
  log->SetQuality(0, {.value = 0.9, .why = ""});
  log->SetQuality(2, {.value = 0.2, .why = "few seeds"});
  const auto line = nlohmann::json::parse(log->TimeLineText(1));
  ASSERT_EQ(line["buckets"].size(), 1U);
  EXPECT_EQ(line["buckets"][0]["key"], 2);
  EXPECT_DOUBLE_EQ(line["buckets"][0]["quality"], 0.2);
  EXPECT_EQ(line["buckets"][0]["why"], "few seeds");
  EXPECT_EQ(nlohmann::json::parse(log->TimeLineText(100))["buckets"].size(), 3U);
}

TEST_F(ViewLogTest, SaysThatALogIsEmpty) {
  std::ofstream(path_).close();
  const auto log = Open();
  EXPECT_THAT(log->complaint(), HasSubstr("no frames"));
  EXPECT_EQ(log->Newest(), nullptr);
  EXPECT_TRUE(nlohmann::json::parse(log->TimeLineText(10))["buckets"].empty());
}

TEST_F(ViewLogTest, SaysThatMessagesAreNotUsed) {
  Rig other = ViewRig();
  other.pair.focal_px += 1;
  LogWriter writer(path_);
  writer.Write(1, "SPROUT_LEFT", Encoded(0, Part::kLeft, ViewImage(0)));
  writer.Write(2, "SPROUT_RIG", Encoded(0, Part::kRig, ViewRig()));
  writer.Write(3, "SPROUT_RIG", Encoded(1, Part::kRig, other));
  writer.Close();
  EXPECT_THAT(Open()->complaint(), HasSubstr("not used: 1, the first SPROUT_RIG at byte "));
}

TEST_F(ViewLogTest, SaysThatThePrefixIsAnother) {
  Write("B_");
  EXPECT_THAT(Open("A_")->complaint(), HasSubstr("channels as B_SPROUT_"));
}

TEST_F(ViewLogTest, ReadsWhatIsLeftOfADamagedLog) {
  Write("");
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path_));
  std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(size / 2);
  file << std::string(200, '\xff');
  file.seekp(20);  // the length of the first channel
  file << std::string(4, '\xff');
  file.close();
  const auto log = Open();
  EXPECT_THAT(log->complaint(), HasSubstr("damaged in"));
  EXPECT_GE(log->keys().last, 1);
}

TEST_F(ViewLogTest, RefusesWhatIsNoLog) {
  std::ofstream(path_) << "no log";
  EXPECT_THROW(LogFile(path_, "", history_, [] {}), LogError);
  EXPECT_THROW(LogFile(folder_ / "none", "", history_, [] {}), LogError);
}

TEST(SpreadOrder, GoesOverAllOfALogAtOnce) {
  EXPECT_THAT(SpreadOrder(8, 100), ElementsAre(0, 4, 2, 6, 1, 5, 3, 7));
  EXPECT_THAT(SpreadOrder(3, 100), ElementsAre(0, 2, 1));
  EXPECT_THAT(SpreadOrder(1000, 4), ElementsAre(0, 500, 250, 750));
  EXPECT_THAT(SpreadOrder(0, 4), ::testing::IsEmpty());
}

}  // namespace
}  // namespace sprout::view
