#include "services/view/status_history.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace sprout::view {
namespace {

using ::testing::ElementsAre;

class StatusHistoryTest : public ::testing::Test {
 protected:
  static StageStatus Status() {
    StageStatus status;
    status.stage = "grow";
    status.pid = 7;
    return status;
  }

  static std::vector<double> Column(const StatusHistory& history, const char* name) {
    return nlohmann::json::parse(history.HistoryText())["grow"][name];
  }
};

TEST_F(StatusHistoryTest, CountsFramesThatWereLostInAnyWay) {
  StageStatus status = Status();
  status.frames_skipped = 1;
  status.frames_incomplete = 20;
  status.frames_failed = 300;
  status.frames_degenerate = 4000;
  status.sequence_gaps = 50'000;
  StatusHistory history({}, /*keep_all=*/false);
  history.Add(status, 1'000'000, {});
  EXPECT_THAT(Column(history, "lost"), ElementsAre(54'321));
}

TEST_F(StatusHistoryTest, ForgetsWhatIsLaterWhenTheClockIsSetBack) {
  StatusHistory history({}, /*keep_all=*/false);
  for (const int64_t second : {10, 11, 12, 3, 4}) history.Add(Status(), second * 1'000'000, {});
  EXPECT_THAT(Column(history, "t"), ElementsAre(3, 4));
  for (const int64_t second : {5, 4}) history.Add(Status(), second * 1'000'000, {});
  EXPECT_THAT(Column(history, "t"), ElementsAre(3, 4, 4)) << "by a second";
}

TEST_F(StatusHistoryTest, KeepsAllOfALogWhateverItsClockDid) {
  StatusHistory history({}, /*keep_all=*/true);
  for (const int64_t second : {10, 11, 3}) history.Add(Status(), second * 1'000'000, {});
  EXPECT_THAT(Column(history, "t"), ElementsAre(10, 11, 3));
}

}  // namespace
}  // namespace sprout::view
