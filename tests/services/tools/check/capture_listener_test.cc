#include "services/tools/check/capture_listener.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <sstream>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "tests/common/core/centred.h"

namespace sprout::check {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFrames = 40;
constexpr int64_t kFirstUtime = 1'700'000'000'000'000;
constexpr std::chrono::milliseconds kPeriod{100};
const cv::Size kSize(32, 24);

// A message before it is encoded.
struct Message {
  std::chrono::milliseconds when;
  Part part;
  FrameId id;
  PartValue value;
};

using Messages = std::vector<Message>;

Rig GoodRig() { return {CentredPair(kSize.width, kSize.height, 40), CentredTof(8, 6, 10)}; }

PartValue Picture(uint8_t grey, cv::Size size = kSize) {
  return cv::Mat(size, CV_8UC1, cv::Scalar(grey));
}

PartValue Tof(float depth_m, cv::Size size = {8, 6}) {
  return TofImage{.depth_m = cv::Mat1f(size, depth_m), .amplitude = {}};
}

// A capture process that does everything right: 10 frames a second, RIG once a second.
Messages GoodRun() {
  Messages run;
  for (int i = 0; i < kFrames; ++i) {
    const auto when = kPeriod * i;
    const FrameId id{.utime = kFirstUtime + 100'000 * i, .seq = i, .rig_id = "rig"};
    if (i % 10 == 0) run.push_back({when, Part::kRig, id, GoodRig()});
    run.push_back({when, Part::kLeft, id, Picture(100)});
    run.push_back({when, Part::kRight, id, Picture(110)});
    run.push_back({when, Part::kTof, id, Tof(2)});
  }
  return run;
}

// What is heard of a run; the lines that begin with WRONG, and the figures.
struct Verdict {
  std::vector<std::string> wrong;
  std::string figures;
};

class Ear {
 public:
  void Take(std::string_view channel, std::vector<uint8_t> bytes, std::chrono::milliseconds when) {
    listener_.Take({std::string(channel), std::move(bytes), start_ + when});
  }
  void Take(const Message& message) {
    Take(ChannelOf(message.part), EncodePart(message.id, message.part, message.value),
         message.when);
  }

  Verdict Finish() {
    listener_.Finish(start_ + kPeriod * kFrames);
    std::stringstream lines;
    found_.Print(kCaptureRules, lines);
    Verdict verdict{.wrong = {}, .figures = listener_.Figures()};
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("WRONG")) verdict.wrong.push_back(line);
    }
    return verdict;
  }

 private:
  CaptureListener::Clock::time_point start_ = CaptureListener::Clock::now();
  Findings found_;
  CaptureListener listener_{found_};
};

Verdict Hear(const Messages& run) {
  Ear ear;
  for (const Message& message : run) ear.Take(message);
  return ear.Finish();
}

void Drop(Messages& run, const std::function<bool(const Message&)>& which) {
  std::erase_if(run, which);
}

void Change(Messages& run, const std::function<void(Message&)>& how) {
  std::for_each(run.begin(), run.end(), how);
}

template <typename Value>
void Set(Messages& run, Part part, const Value& value) {
  Change(run, [&](Message& m) {
    if (m.part == part) m.value = value;
  });
}

TEST(CaptureListener, HasNothingAgainstAGoodRun) {
  const Verdict verdict = Hear(GoodRun());
  EXPECT_THAT(verdict.wrong, IsEmpty());
  EXPECT_THAT(verdict.figures,
              HasSubstr("40 frames of 32x24, 10.0 a second; by their utime 10.0 a second"));
  EXPECT_THAT(verdict.figures, HasSubstr("ToF of 8x6, returns in 100 % of the pixels, at 2 m"));
  EXPECT_THAT(verdict.figures, HasSubstr("RIG 4 times; baseline 0.1 m, focal length 40 px"));
}

TEST(CaptureListener, TakesTheMessagesOfAFrameInAnyOrder) {
  Messages run = GoodRun();
  // The ToF camera's come in after the next frame's images.
  for (size_t i = 0; i + 4 < run.size(); ++i) {
    if (run[i].part == Part::kTof && run[i + 1].part == Part::kLeft) std::swap(run[i], run[i + 1]);
  }
  EXPECT_THAT(Hear(run).wrong, IsEmpty());
}

TEST(CaptureListener, TakesAnEmptyTofImageAndFramesBegunAtTheEnd) {
  Messages run = GoodRun();
  Set(run, Part::kTof, TofImage());
  run.pop_back();
  const Verdict verdict = Hear(run);
  EXPECT_THAT(verdict.wrong, IsEmpty());
  EXPECT_THAT(verdict.figures, HasSubstr("no ToF image"));
}

TEST(CaptureListener, TakesANewCalibrationUnderANewName) {
  Messages run = GoodRun();
  Change(run, [](Message& m) {
    if (m.id.seq < 20) return;
    m.id.rig_id = "new";
    if (m.part == Part::kRig) std::get<Rig>(m.value).pair.focal_px = 41;
  });
  EXPECT_THAT(Hear(run).wrong, IsEmpty());
}

struct Fault {
  std::string name;
  std::function<void(Messages&)> apply;
  std::string line;  // the only one that begins with WRONG
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class CaptureFaults : public testing::TestWithParam<Fault> {};

TEST_P(CaptureFaults, AreFoundForTheRightReason) {
  Messages run = GoodRun();
  GetParam().apply(run);
  EXPECT_THAT(Hear(run).wrong, ElementsAre(HasSubstr(GetParam().line)));
}

bool IsFourth(const Message& m) { return m.id.seq % 4 == 3; }

INSTANTIATE_TEST_SUITE_P(
    Check, CaptureFaults,
    testing::Values(
        Fault{"a_part_missing",
              [](Messages& run) {
                Drop(run, [](const Message& m) { return m.part == Part::kTof && IsFourth(m); });
              },
              "of every frame, once: frame 3: no SPROUT_TOF before frame 4 was whole (and 8 more)"},
        Fault{"a_part_twice",
              [](Messages& run) {
                const Message left = run[1];
                run.insert(run.begin() + 2, left);
              },
              "of every frame, once: frame 0: SPROUT_LEFT twice"},
        Fault{"a_utime_for_each_camera",
              [](Messages& run) {
                Change(run, [](Message& m) { m.id.utime += m.part == Part::kRight; });
              },
              "one header on all three: frame 0: SPROUT_RIGHT has utime = 1700000000000001; "
              "SPROUT_LEFT has 1700000000000000"},
        Fault{"a_rig_id_of_its_own",
              [](Messages& run) {
                Change(run, [](Message& m) {
                  if (m.part == Part::kTof) m.id.rig_id = "tof";
                });
              },
              "one header on all three: frame 0: SPROUT_TOF has rig_id = tof; SPROUT_LEFT has rig"},
        Fault{"utime_stands",
              [](Messages& run) { Change(run, [](Message& m) { m.id.utime = kFirstUtime; }); },
              "seq by one: frame 1: utime = 1700000000000000 after 1700000000000000"},
        Fault{"utime_in_ms",
              [](Messages& run) { Change(run, [](Message& m) { m.id.utime /= 1000; }); },
              "seq by one: utime rises by 0.0039 s in 3.9 s; it must be in µs"},
        Fault{"utime_in_ns",
              [](Messages& run) { Change(run, [](Message& m) { m.id.utime *= 1000; }); },
              "seq by one: utime rises by 3.9e+03 s in 3.9 s; it must be in µs"},
        Fault{"seq_skips", [](Messages& run) { Change(run, [](Message& m) { m.id.seq *= 2; }); },
              "seq by one: SPROUT_LEFT: seq = 2 after 0; allowed is 1"},
        Fault{"seq_stands", [](Messages& run) { Change(run, [](Message& m) { m.id.seq = 7; }); },
              "seq by one: SPROUT_LEFT: seq = 7 again, with another utime; allowed is 8"},
        Fault{
            "no_rig",
            [](Messages& run) { Drop(run, [](const Message& m) { return m.part == Part::kRig; }); },
            "and again: frame 0: no SPROUT_RIG with its rig_id = 'rig' before it"},
        Fault{"rig_after_the_first_frame",
              [](Messages& run) { std::rotate(run.begin(), run.begin() + 1, run.begin() + 4); },
              "and again: frame 0: no SPROUT_RIG with its rig_id = 'rig' before it"},
        Fault{"rig_once",
              [](Messages& run) {
                Drop(run, [](const Message& m) { return m.part == Part::kRig && m.id.seq > 0; });
              },
              "and again: no SPROUT_RIG for 4.0 s; it is due once a second"},
        Fault{"rig_seldom",
              [](Messages& run) {
                Drop(run, [](const Message& m) {
                  return m.part == Part::kRig && m.id.seq > 0 && m.id.seq < 30;
                });
              },
              "and again: no SPROUT_RIG for 3.0 s"},
        Fault{"rig_changes_under_its_name",
              [](Messages& run) {
                std::get<Rig>(run[31].value).pair.focal_px = 41;  // the second RIG
              },
              "and again: SPROUT_RIG: rig_id = 'rig' again, with other numbers"},
        Fault{"left_of_another_size",
              [](Messages& run) { Set(run, Part::kLeft, Picture(100, kSize / 2)); },
              "encoding: SPROUT_LEFT, frame 0: 16x12; SPROUT_RIG says 32x24 (and 39 more)"},
        Fault{"tof_of_another_size",
              [](Messages& run) {
                Set(run, Part::kTof, Tof(2, {6, 8}));
              },
              "encoding: SPROUT_TOF, frame 0: 6x8; SPROUT_RIG says 8x6"},
        Fault{"one_picture", [](Messages& run) { Set(run, Part::kRight, Picture(100)); },
              "values in range: frame 0: SPROUT_LEFT and SPROUT_RIGHT are the same picture"},
        Fault{"tof_in_millimetres", [](Messages& run) { Set(run, Part::kTof, Tof(2000)); },
              "values in range: SPROUT_TOF, frame 0: the median of depth_m is 2000"},
        Fault{"baseline_in_millimetres",
              [](Messages& run) {
                Rig rig = GoodRig();
                rig.pair.baseline_m = 100;
                Set(run, Part::kRig, rig);
              },
              "values in range: SPROUT_RIG: baseline_m = 100; it must be in metres"},
        Fault{"focal_length_in_millimetres",
              [](Messages& run) {
                Rig rig = GoodRig();
                rig.pair.focal_px = 3;
                Set(run, Part::kRig, rig);
              },
              "values in range: SPROUT_RIG: focal_px = 3 for 32 columns; it must be in pixels"},
        Fault{"a_channel_of_another_stage",
              [](Messages& run) {
                run.push_back({kPeriod * kFrames, Part::kConfidence, run[0].id, Picture(0)});
              },
              "its channels: published on SPROUT_CONFIDENCE; allowed are SPROUT_LEFT"}),
    [](const auto& test) { return test.param.name; });

TEST(CaptureListener, NamesAMessageOfAnotherType) {
  Ear ear;
  Messages run = GoodRun();
  for (const Message& message : run) {
    if (message.part != Part::kTof) {
      ear.Take(message);
    } else {
      ear.Take("SPROUT_TOF", EncodePart(message.id, Part::kLeft, Picture(1)), message.when);
    }
  }
  EXPECT_THAT(ear.Finish().wrong,
              ElementsAre(HasSubstr("size and encoding: SPROUT_TOF, frame 0: fingerprint")));
}

TEST(CaptureListener, CaresForTheChannelsOfTheGraphOnly) {
  Ear ear;
  ear.Take("IMU", {1, 2, 3}, kPeriod);
  EXPECT_THAT(ear.Finish().wrong, IsEmpty());
  ear.Take("SPROUT_TOFF", {1, 2, 3}, kPeriod);
  ear.Take("SPROUT_STATUS", {1, 2, 3}, kPeriod);
  EXPECT_THAT(
      ear.Finish().wrong,
      ElementsAre(HasSubstr("its channels: published on SPROUT_TOFF; allowed are "
                            "SPROUT_LEFT, SPROUT_RIGHT, SPROUT_TOF and SPROUT_RIG (and 1")));
}

}  // namespace
}  // namespace sprout::check
