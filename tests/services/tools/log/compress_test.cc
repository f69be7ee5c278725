#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "common/messages/packed.h"
#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::HasSubstr;

// Frames of 160x120 px with all parts that graphs have, messages of other programs between.
std::vector<Event> PhotographEvents() {
  std::vector<Event> events;
  for (int seq = 0; seq < 4; ++seq) {
    events.push_back(PartEvent(Part::kRig, seq));
    cv::Mat3b left(120, 160);
    cv::RNG random(static_cast<uint64_t>(seq + 1));
    for (int v = 0; v < left.rows; ++v) {
      for (int u = 0; u < left.cols; ++u) {
        const int light = 60 + u / 2 + v / 4 + random.uniform(0, 4);
        left(v, u) = cv::Vec3b(static_cast<uint8_t>(light), static_cast<uint8_t>(light + 9),
                               static_cast<uint8_t>(light + 30));
      }
    }
    cv::Mat right;
    cv::cvtColor(left, right, cv::COLOR_BGR2GRAY);
    events.push_back(PartEvent(Part::kLeft, seq, left));
    events.push_back(PartEvent(Part::kRight, seq, right));
    DisparityImage disparity{cv::Size(160, 120)};
    disparity.counts() = cv::Mat1s(120, 160, static_cast<int16_t>(320 + seq));
    events.push_back(PartEvent(Part::kPrior, seq, EvenPrior(disparity, 1)));
    events.push_back(PartEvent(Part::kDisparity, seq, disparity));
    events.push_back(PartEvent(Part::kDisparity, seq, disparity, DisparityEncoding::kDeltaZstd));
    events.push_back(PartEvent(Part::kConfidence, seq, cv::Mat(cv::Mat1b(120, 160, uint8_t{200}))));
    Event foreign;
    foreign.utime = events.back().utime;
    foreign.channel = "POSE";
    foreign.data = Bytes(5000, static_cast<uint8_t>(seq));
    events.push_back(foreign);
    foreign.channel = "SPROUT_LEFT";  // bytes that are none of ours
    events.push_back(foreign);
  }
  return events;
}

class LogCompress : public testing::Test {
 protected:
  LogCompress() : in_(folder_.Write("in", PhotographEvents())), small_(folder_.File("small")) {}

  LogFolder folder_;
  std::filesystem::path in_;
  std::filesystem::path small_;
};

TEST_F(LogCompress, GivesBackTheVeryLog) {
  EXPECT_THAT(OutOf({"compress", in_, small_}), HasSubstr("20 of 36 events changed"));
  EXPECT_LT(10 * std::filesystem::file_size(small_), 6 * std::filesystem::file_size(in_));
  ASSERT_EQ(RunLog({"expand", small_, folder_.File("back")}).exit_code, 0);
  EXPECT_TRUE(ReadBytes(folder_.File("back")) == ReadBytes(in_));
  // A compressed message is not compressed again, by either method.
  ASSERT_EQ(RunLog({"compress", small_, folder_.File("twice")}).exit_code, 0);
  EXPECT_TRUE(ReadBytes(folder_.File("twice")) == ReadBytes(small_));
  ASSERT_EQ(RunLog({"expand", in_, folder_.File("same")}).exit_code, 0);
  EXPECT_TRUE(ReadBytes(folder_.File("same")) == ReadBytes(in_));
}

TEST_F(LogCompress, KeepsNumbersThatAreNotInOrder) {
  std::vector<Event> events = PhotographEvents();
  Bytes log = MakeLog(events);
  // From the second event on as after a cut: the numbers of their recorder.
  const LogContent content = ReadLog(in_);
  for (size_t i = 1; i < content.events.size(); ++i) {
    log[static_cast<size_t>(content.events[i].offset) + 10] = 7;
  }
  WriteBytes(in_, log);
  ASSERT_EQ(RunLog({"compress", in_, small_}).exit_code, 0);
  ASSERT_EQ(RunLog({"expand", small_, folder_.File("back")}).exit_code, 0);
  EXPECT_TRUE(ReadBytes(folder_.File("back")) == log);
}

TEST_F(LogCompress, IsReadByTheOtherCommandsAsTheOriginal) {
  ASSERT_EQ(RunLog({"compress", in_, small_}).exit_code, 0);
  EXPECT_EQ(RunLog({"diff", in_, small_}).exit_code, 0);
  const auto info = [](const std::filesystem::path& log) {
    std::string text = RunLog({"info", log}).out;
    const size_t table = text.find("channel");
    return text.substr(table == std::string::npos ? 0 : table);
  };
  EXPECT_THAT(info(small_), testing::AllOf(HasSubstr("sprout.image_t"), HasSubstr("SPROUT_PRIOR")));
  ASSERT_EQ(RunLog({"cut", small_, folder_.File("cut"), "--frames", "1:2"}).exit_code, 0);
  ASSERT_EQ(RunLog({"expand", folder_.File("cut"), folder_.File("cut_back")}).exit_code, 0);
  ASSERT_EQ(RunLog({"cut", in_, folder_.File("cut_in"), "--frames", "1:2"}).exit_code, 0);
  EXPECT_TRUE(ReadBytes(folder_.File("cut_back")) == ReadBytes(folder_.File("cut_in")));
}

TEST_F(LogCompress, MakesJpegOfCameraImagesOnlyWhenAsked) {
  ASSERT_EQ(RunLog({"compress", "--jpeg", "90", in_, small_}).exit_code, 0);
  for (const Event& event : ReadLog(small_).events) {
    if (TypeOf(event.data) != MessageType::kImage) continue;
    const bool is_map = event.channel == "SPROUT_CONFIDENCE";
    EXPECT_EQ(IsPacked(event.data), is_map) << event.channel;
    const Result<DecodedMessage> decoded = DecodeAs(MessageType::kImage, event.data);
    ASSERT_TRUE(decoded);
    const auto& image = std::get<cv::Mat>(std::get<PartValue>(decoded->value));
    EXPECT_EQ(image.size(), cv::Size(160, 120));
    EXPECT_EQ(image.channels(), event.channel == "SPROUT_LEFT" ? 3 : 1);
  }
  // A JPEG is not encoded again with a lower quality: stages have seen it as it is.
  ASSERT_EQ(RunLog({"compress", "--jpeg", "50", small_, folder_.File("twice")}).exit_code, 0);
  EXPECT_TRUE(ReadBytes(folder_.File("twice")) == ReadBytes(small_));
  EXPECT_EQ(RunLog({"compress", "--jpeg", "0", in_, small_, "--force"}).exit_code, 2);
}

TEST_F(LogCompress, RefusesWhatWouldNotComeBack) {
  Bytes damaged = ReadBytes(in_);
  damaged[static_cast<size_t>(ReadLog(in_).events[3].offset) + 1] ^= 1;
  WriteBytes(in_, damaged);
  const MainOutcome outcome = RunLog({"compress", in_, small_});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("allowed is an undamaged log, such as sprout-log repair"));
  EXPECT_FALSE(std::filesystem::exists(small_));
}

TEST_F(LogCompress, NamesAMessageThatCannotBeExpanded) {
  ASSERT_EQ(RunLog({"compress", in_, small_}).exit_code, 0);
  const Event left = ReadLog(small_).events[1];
  ASSERT_TRUE(IsPacked(left.data));
  Bytes log = ReadBytes(small_);
  log[static_cast<size_t>(left.end()) - 20] ^= 0x55;
  log[static_cast<size_t>(left.end()) - 200] ^= 0x55;
  WriteBytes(small_, log);
  const MainOutcome outcome = RunLog({"expand", small_, folder_.File("back")});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("SPROUT_LEFT: data"));
  EXPECT_FALSE(std::filesystem::exists(folder_.File("back")));
}

}  // namespace
}  // namespace sprout::log
