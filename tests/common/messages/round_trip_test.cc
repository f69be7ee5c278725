#include "tests/common/messages/round_trip.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "common/config/required.h"
#include "common/messages/message_type.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

TEST(ImageMessage, CarriesGreyAndBgr) {
  ExpectSamePixels(RoundTrip(Part::kLeft, examples::GreyImage()), examples::GreyImage());
  ExpectSamePixels(RoundTrip(Part::kRight, examples::BgrImage()), examples::BgrImage());
}

TEST(ImageMessage, CarriesAViewIntoALargerImage) {
  const cv::Mat view = examples::BgrImage()(cv::Rect(1, 1, 3, 2));
  ASSERT_FALSE(view.isContinuous());
  ExpectSamePixels(RoundTrip(Part::kLeft, view), view);
}

TEST(ImageMessage, ReordersRgbToBgr) {
  image_t message = ToMessage(examples::Id(), cv::Mat(1, 2, CV_8UC3, cv::Scalar(10, 20, 30)));
  message.pixel_format = image_t::PIXEL_FORMAT_RGB3;
  const cv::Mat image = Required(FromMessage(message, message.data));
  EXPECT_EQ(image.at<cv::Vec3b>(0, 1), cv::Vec3b(30, 20, 10));
}

TEST(ImageMessage, SkipsThePaddingBehindEachRow) {
  image_t message = ToMessage(examples::Id(), cv::Mat(2, 3, CV_8UC1, cv::Scalar(0)));
  message.row_stride = 5;
  message.data = {1, 2, 3, 99, 99, 4, 5, 6, 99, 99};
  message.size = 10;
  const cv::Mat image = Required(FromMessage(message, message.data));
  ExpectSamePixels(image, (cv::Mat1b(2, 3) << 1, 2, 3, 4, 5, 6));
}

TEST(ImageMessage, DoesNotShareMemoryWithTheMessage) {
  image_t message = ToMessage(examples::Id(), examples::GreyImage());
  const Result<cv::Mat> image = FromMessage(message, message.data);
  std::fill(message.data.begin(), message.data.end(), uint8_t{0});
  ExpectSamePixels(*image, examples::GreyImage());
}

TEST(ImageMessage, SharesTheMemoryOfTheMessageThatItIsGiven) {
  for (const cv::Mat& sent : {examples::GreyImage(), examples::BgrImage()}) {
    cv::Mat received;
    {
      const cv::Mat1b memory(EncodePart(examples::Id(), Part::kLeft, sent), true);
      const cv::Mat1b row = memory.reshape(1, 1);
      const std::span<const uint8_t> bytes(row.data, row.total());
      received =
          std::get<cv::Mat>(Required(DecodePart(Part::kLeft, bytes, std::nullopt, row)).value);
      EXPECT_EQ(received.data + received.total() * received.elemSize(), row.data + row.total());
    }
    ExpectSamePixels(received, sent);  // also when the message is gone
    // Filters look beyond the borders of a part of an image, but this one is whole.
    cv::Mat blurred, expected;
    cv::blur(received, blurred, {3, 3});
    cv::blur(sent, expected, {3, 3});
    ExpectSamePixels(blurred, expected);
  }
}

TEST(ZonesMessage, CarriesAll) {
  EXPECT_EQ(RoundTrip(Part::kTofZones, examples::Zones()), examples::Zones());
  EXPECT_EQ(RoundTrip(Part::kTofZones, TofZones()), TofZones()) << "the sensor gave nothing";
}

TEST(ZonesMessage, TakesNoNumbersFromATargetThatIsNone) {
  tof_zones_t message = ToMessage(examples::Id(), examples::Zones());
  message.depth_m[3] = NAN;
  message.sigma_m[3] = -1;
  const TofZones zones = Required(FromMessage(message));
  EXPECT_EQ(zones, examples::Zones());
}

TEST(ZonesMessage, IsRefusedWithWhatCannotBe) {
  const auto error_of = [](const auto& change) {
    tof_zones_t message = ToMessage(examples::Id(), examples::Zones());
    change(message);
    return WhyNot(FromMessage(message));
  };
  using M = tof_zones_t;
  EXPECT_EQ(error_of([](M&) {}), "");
  EXPECT_THAT(error_of([](M& m) { m.columns = 65; }),
              HasSubstr("columns = 65: allowed is 1 to 64"));
  EXPECT_THAT(error_of([](M& m) { m.columns = -1; }), HasSubstr("columns = -1"));
  EXPECT_THAT(error_of([](M& m) { m.rows = 0; }), HasSubstr("rows = 0"));
  EXPECT_THAT(error_of([](M& m) { m.columns = 0; }), HasSubstr("columns = 0"));
  EXPECT_THAT(error_of([](M& m) { m.targets_per_zone = 5; }), HasSubstr("targets_per_zone = 5"));
  EXPECT_THAT(error_of([](M& m) { m.targets_per_zone = 0; }), HasSubstr("targets_per_zone = 0"));
  EXPECT_THAT(error_of([](M& m) { m.mode = 2; }), HasSubstr("mode = 2"));
  EXPECT_THAT(error_of([](M& m) { m.rows = 2; }), HasSubstr("zone_count = 2"));
  EXPECT_THAT(error_of([](M& m) { m.top.pop_back(); }), HasSubstr("zone_count = 2"));
  EXPECT_THAT(error_of([](M& m) { m.targets_per_zone = 1; }), HasSubstr("target_count = 4"));
  EXPECT_THAT(error_of([](M& m) { m.status.push_back(0); }), HasSubstr("target_count = 4"));
  EXPECT_THAT(error_of([](M& m) { m.left_from_sensor_rotation[0] = 2; }),
              HasSubstr("left_from_sensor_rotation norm"));
  EXPECT_THAT(error_of([](M& m) { m.left_from_sensor_translation_m[2] = INFINITY; }),
              HasSubstr("left_from_sensor_translation_m = inf"));
  EXPECT_THAT(error_of([](M& m) { m.left[1] = NAN; }), HasSubstr("zone 1: left = nan"));
  EXPECT_THAT(error_of([](M& m) { m.right[0] = -0.5F; }), HasSubstr("zone 0: right = -0.5"));
  EXPECT_THAT(error_of([](M& m) { m.bottom[0] = 101; }), HasSubstr("zone 0: bottom = 101"));
  EXPECT_THAT(error_of([](M& m) { m.status[2] = 3; }), HasSubstr("target 2: status = 3"));
  EXPECT_THAT(error_of([](M& m) { m.status[2] = -1; }), HasSubstr("target 2: status = -1"));
  EXPECT_THAT(error_of([](M& m) { m.depth_m[0] = 0; }), HasSubstr("target 0: depth_m = 0"));
  EXPECT_THAT(error_of([](M& m) { m.depth_m[1] = 10'001; }), HasSubstr("target 1: depth_m"));
  EXPECT_THAT(error_of([](M& m) { m.sigma_m[0] = 0; }), HasSubstr("target 0: sigma_m = 0"));
  EXPECT_THAT(error_of([](M& m) { m.sigma_m[1] = NAN; }), HasSubstr("target 1: sigma_m = nan"));
}

TEST(MotionMessage, CarriesAll) {
  EXPECT_EQ(RoundTrip(Part::kMotion, examples::Motion()), examples::Motion());
}

TEST(MotionMessage, IsRefusedWithoutARotationOrWithNumbersThatCannotBe) {
  const auto error_of = [](auto change) {
    motion_t message = ToMessage(examples::Id(), examples::Motion());
    change(message);
    return WhyNot(FromMessage(message));
  };
  EXPECT_EQ(error_of([](motion_t&) {}), "");
  EXPECT_THAT(error_of([](motion_t& m) { m.last_from_left_rotation[0] = 2; }),
              HasSubstr("last_from_left_rotation norm"));
  EXPECT_THAT(error_of([](motion_t& m) { m.start_from_left_translation_m[1] = NAN; }),
              HasSubstr("start_from_left_translation_m"));
  EXPECT_THAT(error_of([](motion_t& m) { m.covariance[35] = INFINITY; }), HasSubstr("covariance"));
  EXPECT_THAT(error_of([](motion_t& m) { m.inliers = 501; }), HasSubstr("inliers"));
  EXPECT_THAT(error_of([](motion_t& m) { m.reset = 7; }), HasSubstr("reset"));
  EXPECT_THAT(error_of([](motion_t& m) { m.resets = -1; }), HasSubstr("resets"));
}

TEST(TofMessage, CarriesDepthWithNanAndNoAmplitude) {
  const TofImage tof = RoundTrip(Part::kTof, examples::Tof(false));
  ExpectSamePixels(tof.depth_m, examples::Tof(false).depth_m);
  EXPECT_TRUE(tof.amplitude.empty());
  EXPECT_TRUE(std::isnan(tof.depth_m(0, 2)));
}

TEST(TofMessage, HasNanWhereverThereIsNoReturn) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const TofImage sent{.depth_m = (cv::Mat1f(2, 5) << 1.5F, 0.F, -1.F, kInfinity, -kInfinity,  //
                                  10'000.F, 10'001.F, 65535.F, 1e20F, 3.4e38F),
                      .amplitude = {}};
  const TofImage tof = RoundTrip(Part::kTof, sent);
  EXPECT_EQ(tof.depth_m(0, 0), 1.5F);
  EXPECT_EQ(tof.depth_m(1, 0), kMaxTofDepthM);
  for (const cv::Point no_return :
       std::vector<cv::Point>{{1, 0}, {2, 0}, {3, 0}, {4, 0}, {1, 1}, {2, 1}, {3, 1}, {4, 1}}) {
    EXPECT_TRUE(std::isnan(tof.depth_m(no_return))) << no_return;
  }
}

TEST(TofMessage, CarriesAmplitude) {
  const TofImage tof = RoundTrip(Part::kTof, examples::Tof(true));
  ExpectSamePixels(tof.depth_m, examples::Tof(true).depth_m);
  ExpectSamePixels(tof.amplitude, examples::Tof(true).amplitude);
}

TEST(TofMessage, CarriesThatThereIsNoImage) {
  const TofImage tof = RoundTrip(Part::kTof, TofImage());
  EXPECT_TRUE(tof.depth_m.empty());
  EXPECT_TRUE(tof.amplitude.empty());
}

TEST(TofMessage, CarriesAViewIntoALargerImage) {
  cv::Mat1f whole(4, 5, 3.0F);
  whole(2, 2) = 1.0F;
  const TofImage view{.depth_m = whole(cv::Rect(1, 1, 3, 2)), .amplitude = {}};
  ExpectSamePixels(RoundTrip(Part::kTof, view).depth_m, view.depth_m);
}

TEST(RigMessage, CarriesEveryNumber) {
  // RigId() covers every number (see its own test).
  EXPECT_EQ(RigId(RoundTrip(Part::kRig, examples::Rig())), RigId(examples::Rig()));
}

TEST(RigMessage, CarriesThatThereIsNoTofCamera) {
  const Rig rig{.pair = examples::Rig().pair, .tof = {}};
  EXPECT_EQ(RigId(RoundTrip(Part::kRig, rig)), RigId(rig));
}

TEST(RigMessage, HasTheRotationInTheOrderItsTypeSays) {
  const rig_t message = ToMessage(examples::Id(), examples::Rig());
  EXPECT_EQ(std::vector<double>(message.left_from_tof_rotation, message.left_from_tof_rotation + 4),
            (std::vector<double>{0.5, -0.5, 0.5, 0.5}));  // w first
}

TEST(SeedsMessage, CarriesSeedsAndCounts) {
  EXPECT_EQ(RoundTrip(Part::kSeeds, examples::Seeds()), examples::Seeds());
}

TEST(SeedsMessage, CarriesNoSeedAtAll) { EXPECT_EQ(RoundTrip(Part::kSeeds, SeedSet{}), SeedSet{}); }

TEST(StatusMessage, CarriesEveryField) {
  const StageStatus sent = examples::Status();
  const StageStatus status = Required(DecodeStatus(EncodeStatus(sent)));
  EXPECT_EQ(status.newest_frame, sent.newest_frame);
  EXPECT_EQ(status.stage, "refine");
  EXPECT_EQ(status.host, "robot");
  EXPECT_EQ(status.version, "0.1.0 (test)");
  EXPECT_EQ(status.config_digest, "fedcba9876543210");
  EXPECT_EQ(status.last_error, "frame 41: no seeds");
  EXPECT_EQ(status.pid, 77);
  EXPECT_EQ(status.state, StageStatus::State::kRunning);
  EXPECT_EQ((std::vector<int64_t>{status.frames_in, status.frames_out, status.frames_skipped,
                                  status.frames_incomplete, status.frames_degenerate,
                                  status.frames_failed, status.frames_resent, status.bad_messages,
                                  status.sequence_gaps}),
            (std::vector<int64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ((std::vector<double>{status.rate_hz, status.latency.p50_ms, status.latency.p95_ms,
                                 status.latency.p99_ms, status.latency.max_ms, status.age.p50_ms,
                                 status.age.p95_ms, status.age.p99_ms, status.age.max_ms}),
            (std::vector<double>{10.5, 11, 12, 13, 14, 15, 16, 17, 18}));
  EXPECT_EQ(status.rss_bytes, int64_t{19} << 32);
  EXPECT_EQ(status.tof_coverage, 0.25F);
  EXPECT_EQ(status.spread_ms, 1.5F);
  EXPECT_EQ(status.tof_offset.u_px, 2.25F);
  EXPECT_EQ(status.tof_offset.v_px, -0.5F);
  EXPECT_EQ(status.tof_offset.sigma_px, 0.125F);
}

TEST(StatusMessage, MayNameNoFrameYet) {
  const StageStatus status = Required(DecodeStatus(EncodeStatus(StageStatus{})));
  EXPECT_EQ(status.newest_frame, FrameId{});
  EXPECT_EQ(status.tof_coverage, kUnknownCoverage);
}

TEST(ProcessMessage, CarriesEveryField) {
  const ProcessInfo info = Required(DecodeProcessInfo(EncodeProcessInfo(examples::Process())));
  EXPECT_EQ(info, examples::Process());
}

// What IsShort() says of their channels.
TEST(ShortMessages, FitOneDatagramWhateverTheirTexts) {
  constexpr size_t kLongestChannel = 63, kMaxInOneDatagram = 65'498;
  const std::string text(100'000, 'x');
  StageStatus status = examples::Status();
  status.stage = status.host = status.version = status.config_digest = status.last_error = text;
  RigChange change = examples::Change();
  change.reason = text;
  EXPECT_LT(EncodeStatus(status).size() + kLongestChannel, kMaxInOneDatagram);
  EXPECT_LT(EncodeRigChange(change).size() + kLongestChannel, kMaxInOneDatagram);
}

TEST(RigChangeMessage, CarriesEveryField) {
  const RigChange change = Required(DecodeRigChange(EncodeRigChange(examples::Change())));
  EXPECT_EQ(change, examples::Change());
}

TEST(RigChangeMessage, RefusesWhatTheTypeDoesNotAllow) {
  const auto error = [](const auto& spoil) {
    RigChange change = examples::Change();
    spoil(change);
    return WhyNot(DecodeRigChange(EncodeRigChange(change)));
  };
  EXPECT_EQ(error([](RigChange& c) { c.verdict = static_cast<RigChange::Verdict>(3); }),
            "verdict = 3: allowed is UNSEEN, RIGHT or WRONG");
  EXPECT_EQ(error([](RigChange& c) { c.frames = 0; }), "frames = 0: allowed is 1 to 1000");
  EXPECT_EQ(error([](RigChange& c) { c.tof_matches = 1501; }),
            "tof_matches = 1501: allowed is 0 to matches");
  EXPECT_EQ(error([](RigChange& c) { c.right.turn[1] = INFINITY; }),
            "right_turn = inf: allowed is a finite number");
  EXPECT_EQ(error([](RigChange& c) { c.tof.sigma[2] = -0.5; }),
            "tof_sigma = -0.5: allowed is 0 or more, or -1 for not shown");
  EXPECT_EQ(error([](RigChange& c) { c.range_sigma_m = NAN; }),
            "range_sigma_m = nan: allowed is a finite number");
}

TEST(RigChangeMessage, RefusesAChangeThatWasNotSeen) {
  const auto error = [](const auto& spoil) {
    RigChange change = examples::Change();
    change.verdict = RigChange::Verdict::kWrong;
    spoil(change);
    return WhyNot(DecodeRigChange(EncodeRigChange(change)));
  };
  EXPECT_EQ(error([](RigChange&) {}), "");
  const auto turned = [](RigChange& c, double turn, double sigma) {
    c.right.turn[0] = turn;
    c.right.sigma[0] = sigma;
  };
  EXPECT_EQ(error([&](RigChange& c) { turned(c, 0.01, -1); }),
            "right_turn = 0.01: allowed is 0, as its sigma is -1 (not shown)");
  EXPECT_EQ(error([&](RigChange& c) { turned(c, 0.01, 1e9); }),
            "right_turn = 0.01: allowed is 0, or 3 times its sigma (1e+09) or more");
  EXPECT_EQ(error([&](RigChange& c) { turned(c, 0.03, 0.01); }), "");
  EXPECT_EQ(error([&](RigChange& c) { turned(c, -0.0299, 0.01); }),
            "right_turn = -0.0299: allowed is 0, or 3 times its sigma (0.01) or more");
  EXPECT_EQ(error([](RigChange& c) { c.tof.turn[1] = 1, c.tof.sigma[1] = -1; }),
            "tof_turn = 1: allowed is 0, as its sigma is -1 (not shown)");
  EXPECT_EQ(error([](RigChange& c) { c.range_offset_m = 1, c.range_sigma_m = 2; }),
            "range_offset_m = 1: allowed is 0, or 3 times its sigma (2) or more");
  EXPECT_EQ(error([](RigChange& c) { c.matches = c.tof_matches = 0; }),
            "matches = 0: allowed is 1 or more");
  EXPECT_EQ(error([](RigChange& c) { c.tof_matches = 0; }),
            "tof_matches = 0: allowed is 1 or more for a change of the ToF camera");
  const auto nothing = [](RigChange& c) {
    c.right.turn = c.tof.turn = Eigen::Vector3d::Zero();
    c.range_offset_m = 0;
  };
  EXPECT_EQ(error(nothing), "verdict = 2: allowed is WRONG only with a change");
  // Numbers that say nothing may be any.
  EXPECT_EQ(error([&](RigChange& c) {
              turned(c, 0.01, -1);
              c.verdict = RigChange::Verdict::kUnseen;
            }),
            "");
}

TEST(ProcessMessage, MayBeEmpty) {
  const ProcessInfo info = Required(DecodeProcessInfo(EncodeProcessInfo(ProcessInfo{})));
  EXPECT_EQ(info, ProcessInfo{});
}

TEST(MessageType, IsToldByTheFingerprint) {
  for (const examples::Wire& wire : examples::AllWires()) {
    const std::optional<MessageType> type = TypeOf(wire.bytes);
    ASSERT_TRUE(type.has_value()) << wire.name;
    EXPECT_EQ(*type, wire.part ? TypeOf(*wire.part) : wire.other) << wire.name;
    EXPECT_TRUE(DecodeAs(*type, wire.bytes).has_value()) << wire.name;
  }
  EXPECT_EQ(TypeOf(std::vector<uint8_t>(100)), std::nullopt);
  EXPECT_EQ(TypeOf(std::vector<uint8_t>(7)), std::nullopt);
  EXPECT_EQ(NameOf(MessageType::kStatus), "sprout.stage_status_t");
  EXPECT_EQ(NameOf(MessageType::kImage), "sprout.image_t");
}

TEST(MessageType, HeaderIsReadAlone) {
  for (const examples::Wire& wire : examples::AllWires()) {
    // Nothing behind the header is looked at.
    const std::span<const uint8_t> head =
        std::span(wire.bytes).first(28 + examples::Id().rig_id.size() + 1);
    const Result<FrameId> id = DecodeFrameId(head);
    ASSERT_TRUE(id.has_value()) << wire.name << ": " << id.error().text;
    EXPECT_EQ(*id, examples::Id()) << wire.name;
    EXPECT_FALSE(DecodeFrameId(head.first(head.size() - 1)).has_value()) << wire.name;
  }
  EXPECT_FALSE(DecodeFrameId({}).has_value());
}

TEST(MessageType, HeaderWithABadRigIdIsRefused) {
  const std::vector<uint8_t> good = examples::AllWires().front().bytes;
  for (const int length : {-1, 0, 16, 18, 1 << 30}) {
    EXPECT_FALSE(
        DecodeFrameId(examples::Patched(good, examples::kRigIdLengthOffset, length)).has_value())
        << length;
  }
}

}  // namespace

}  // namespace sprout
