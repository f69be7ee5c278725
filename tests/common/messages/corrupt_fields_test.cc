#include <gmock/gmock.h>

#include <functional>

#include "common/config/required.h"
#include "tests/common/messages/examples.h"
#include "tests/common/testing/thrown.h"

// Well-formed messages with fields that the border must refuse; the error names the field and what
// is allowed.
namespace sprout {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

template <typename Message>
struct Corruption {
  const char* name;
  std::function<void(Message&)> apply;
  const char* field;    ///< what the error must name ...
  const char* allowed;  ///< ... and say
};

template <typename Message>
void ExpectRefused(const Message& valid, Part part, std::vector<Corruption<Message>> table) {
  ASSERT_TRUE(DecodePart(part, examples::Encode(valid)));
  for (const Corruption<Message>& corruption : table) {
    SCOPED_TRACE(corruption.name);
    Message message = valid;
    corruption.apply(message);
    const std::string error = WhyNot(DecodePart(part, examples::Encode(message)));
    EXPECT_THAT(error, HasSubstr(corruption.field));
    EXPECT_THAT(error, HasSubstr(corruption.allowed));
    EXPECT_THAT(error, ::testing::Not(HasSubstr("\n")));
  }
}

TEST(HeaderBorder, RefusesWhatNamesNoFrame) {
  using M = seeds_t;
  ExpectRefused<M>(
      ToMessage(examples::Id(), examples::Seeds()), Part::kSeeds,
      {{"negative time", [](M& m) { m.header.utime = -1; }, "header.utime = -1", ">= 0"},
       {"no frame", [](M& m) { m.header.seq = -1; }, "header.seq = -1", ">= 0"},
       {"negative number", [](M& m) { m.header.seq = -2; }, "header.seq = -2", ">= 0"},
       {"smallest number", [](M& m) { m.header.seq = INT64_MIN; }, "header.seq", ">= 0"},
       {"long rig_id", [](M& m) { m.header.rig_id.assign(65, 'x'); }, "header.rig_id", "0 to 64"}});
}

TEST(HeaderBorder, AcceptsTheLongestAndTheEmptyRigId) {
  for (const size_t length : {0, 64}) {
    seeds_t message = ToMessage(examples::Id(), examples::Seeds());
    message.header.rig_id.assign(length, 'x');
    EXPECT_TRUE(DecodePart(Part::kSeeds, examples::Encode(message)));
  }
}

TEST(ImageBorder, RefusesSizesAndFormatsThatDoNotFit) {
  using M = image_t;
  ExpectRefused<M>(
      ToMessage(examples::Id(), examples::GreyImage()), Part::kLeft,
      {{"no column", [](M& m) { m.width = 0; }, "width = 0", "1 to 16384"},
       {"negative width", [](M& m) { m.width = -7; }, "width = -7", "1 to 16384"},
       {"too wide", [](M& m) { m.width = 16385; }, "width = 16385", "1 to 16384"},
       {"no row", [](M& m) { m.height = 0; }, "height = 0", "1 to 16384"},
       {"too high", [](M& m) { m.height = 16385; }, "height = 16385", "1 to 16384"},
       {"largest height", [](M& m) { m.height = INT32_MAX; }, "height", "1 to 16384"},
       {"too many pixels",
        [](M& m) {
          m.width = 10001;
          m.height = 10000;
        },
        "width × height = 100010000", "up to 100000000 pixels"},
       {"row cut short", [](M& m) { m.row_stride = 6; }, "row_stride = 6", "at least width"},
       {"no stride", [](M& m) { m.row_stride = 0; }, "row_stride = 0", "at least width"},
       {"negative stride", [](M& m) { m.row_stride = -7; }, "row_stride = -7", "at least width"},
       {"long rows", [](M& m) { m.row_stride = 8; }, "size = 35", "row_stride × height = 40"},
       {"longest rows", [](M& m) { m.row_stride = INT32_MAX; }, "size = 35", "row_stride × height"},
       {"too few bytes",
        [](M& m) {
          m.data.pop_back();
          m.size = 34;
        },
        "size = 34", "row_stride × height = 35"},
       {"too many bytes",
        [](M& m) {
          m.data.push_back(0);
          m.size = 36;
        },
        "size = 36", "row_stride × height = 35"},
       {"three bytes a pixel", [](M& m) { m.pixel_format = m.PIXEL_FORMAT_BGR3; }, "row_stride = 7",
        "at least width"},
       {"no format", [](M& m) { m.pixel_format = 0; }, "pixel_format = 0", "GREY, RGB3, BGR3"},
       {"unknown format", [](M& m) { m.pixel_format = 0x56595559; }, "pixel_format", "or MJPG"}});
}

TEST(TofBorder, RefusesSizesThatDoNotFit) {
  using M = tof_image_t;
  ExpectRefused<M>(ToMessage(examples::Id(), examples::Tof(true)), Part::kTof,
                   {{"no column", [](M& m) { m.width = 0; }, "width = 0", "1 to 16384"},
                    {"too wide", [](M& m) { m.width = 16385; }, "width = 16385", "1 to 16384"},
                    {"negative sides whose product fits",
                     [](M& m) {
                       m.width = -3;
                       m.height = -2;
                     },
                     "width = -3", "1 to 16384"},
                    {"no row", [](M& m) { m.height = 0; }, "height = 0", "1 to 16384"},
                    {"too high", [](M& m) { m.height = 16385; }, "height = 16385", "1 to 16384"},
                    {"depths of no image", [](M& m) { m.width = m.height = 0; }, "count = 6",
                     "width × height = 0"},
                    {"other size", [](M& m) { m.height = 3; }, "count = 6", "width × height = 9"},
                    {"one value missing",
                     [](M& m) {
                       m.depth_m.pop_back();
                       m.count = 5;
                     },
                     "count = 5", "width × height = 6"},
                    {"one amplitude missing",
                     [](M& m) {
                       m.amplitude.pop_back();
                       m.amplitude_count = 5;
                     },
                     "amplitude_count = 5", "0 or width × height = 6"}});
}

TEST(RigBorder, RefusesWhatNoProjectionCanWorkWith) {
  using M = rig_t;
  std::vector<Corruption<M>> table = {
      {"no column", [](M& m) { m.width = 0; }, "width = 0", "1 to 16384"},
      {"too wide", [](M& m) { m.width = 16385; }, "width = 16385", "1 to 16384"},
      {"no row", [](M& m) { m.height = 0; }, "height = 0", "1 to 16384"},
      {"too high", [](M& m) { m.height = 16385; }, "height = 16385", "1 to 16384"},
      {"ToF no column", [](M& m) { m.tof_width = 0; }, "tof_width = 0", "1 to 16384"},
      {"ToF too wide", [](M& m) { m.tof_width = 16385; }, "tof_width = 16385", "1 to 16384"},
      {"ToF no row", [](M& m) { m.tof_height = -1; }, "tof_height = -1", "1 to 16384"},
      {"ToF too high", [](M& m) { m.tof_height = 16385; }, "tof_height = 16385", "1 to 16384"},
      {"no ToF camera, but a lens that is no number",
       [](M& m) {
         m.tof_width = m.tof_height = 0;
         m.tof_fy = kNan;
       },
       "tof_fy = nan", "a finite number"},
      {"too many pixels",
       [](M& m) {
         m.width = 10001;
         m.height = 10000;
       },
       "width × height = 100010000", "up to 100000000 pixels"},
      {"too many ToF pixels",
       [](M& m) {
         m.tof_width = 16384;
         m.tof_height = 16384;
       },
       "tof_width × tof_height = 268435456", "up to 100000000 pixels"},
      {"no rotation", [](M& m) { std::fill_n(m.left_from_tof_rotation, 4, 0.0); },
       "left_from_tof_rotation norm = 0", "unit quaternion"},
      {"long rotation", [](M& m) { m.left_from_tof_rotation[0] = 0.6; }, "left_from_tof_rotation",
       "unit quaternion"},
      {"almost a rotation", [](M& m) { m.left_from_tof_rotation[2] += 1e-5; },
       "left_from_tof_rotation", "unit quaternion"}};
  const std::pair<const char*, double M::*> positive[] = {{"focal_px", &M::focal_px},
                                                          {"baseline_m", &M::baseline_m},
                                                          {"tof_fx", &M::tof_fx},
                                                          {"tof_fy", &M::tof_fy}};
  for (const auto& [name, field] : positive) {
    for (const double value : {0.0, -1.0, kNan, kInf, -kInf}) {
      table.push_back({name, [=](M& m) { m.*field = value; }, name, "a finite number > 0"});
    }
  }
  const std::pair<const char*, double M::*> finite[] = {{"cx", &M::cx},
                                                        {"cy", &M::cy},
                                                        {"cx_right", &M::cx_right},
                                                        {"tof_cx", &M::tof_cx},
                                                        {"tof_cy", &M::tof_cy}};
  for (const double value : {kNan, kInf, -kInf}) {
    for (const auto& [name, field] : finite) {
      table.push_back({name, [=](M& m) { m.*field = value; }, name, "a finite number"});
    }
    for (size_t i = 0; i < 5; ++i) {
      table.push_back({"distortion", [=](M& m) { m.tof_distortion[i] = value; }, "tof_distortion",
                       "a finite number"});
    }
    for (size_t i = 0; i < 4; ++i) {
      table.push_back({"rotation", [=](M& m) { m.left_from_tof_rotation[i] = value; },
                       "left_from_tof_rotation", "unit quaternion"});
    }
    for (size_t i = 0; i < 3; ++i) {
      table.push_back({"translation", [=](M& m) { m.left_from_tof_translation_m[i] = value; },
                       "left_from_tof_translation_m", "a finite number"});
    }
  }
  ExpectRefused<M>(ToMessage(examples::Id(), examples::Rig()), Part::kRig, table);
}

TEST(RigBorder, RefusesNumbersThatNoCameraHas) {
  using M = rig_t;
  std::vector<Corruption<M>> table = {
      {"hardly any focal length", [](M& m) { m.focal_px = 0.049 * std::max(m.width, m.height); },
       "focal_px", "0.05 to 50 times"},
      {"a telescope", [](M& m) { m.focal_px = 51 * std::max(m.width, m.height); }, "focal_px",
       "0.05 to 50 times"},
      {"principal point far off", [](M& m) { m.cx = 1e9; }, "cx = 1e+09", "10 times the image's"},
      {"row far off", [](M& m) { m.cy = -1e9; }, "cy = -1e+09", "10 times the image's"},
      {"right one far off", [](M& m) { m.cx_right = 1e9; }, "cx_right", "10 times the image's"},
      {"no distance", [](M& m) { m.baseline_m = 1e-5; }, "baseline_m = 1e-05", "0.0001 to 1000 m"},
      {"another town", [](M& m) { m.baseline_m = 1001; }, "baseline_m = 1001", "0.0001 to 1000 m"},
      {"ToF telescope", [](M& m) { m.tof_fx = 1e9; }, "tof_fx = 1e+09", "0.05 to 50 times"},
      {"ToF off", [](M& m) { m.tof_cy = 1e9; }, "tof_cy = 1e+09", "10 times the image's"},
      {"ToF in another town", [](M& m) { m.left_from_tof_translation_m[2] = -1001; },
       "left_from_tof_translation_m = -1001", "-1000 to 1000 m"}};
  for (size_t i = 0; i < 5; ++i) {
    table.push_back({"distortion", [=](M& m) { m.tof_distortion[i] = 1e9; }, "tof_distortion",
                     "0 to 10 times its distance from the principal point"});
  }
  ExpectRefused<M>(ToMessage(examples::Id(), examples::Rig()), Part::kRig, table);
}

TEST(SeedsBorder, RefusesPositionsAndCountsThatAreNone) {
  using M = seeds_t;
  const auto nan = static_cast<float>(kNan);
  const auto inf = static_cast<float>(kInf);
  ExpectRefused<M>(
      ToMessage(examples::Id(), examples::Seeds()), Part::kSeeds,
      {{"u not a number", [=](M& m) { m.u[1] = nan; }, "seed 1", "not finite or beyond ±16384"},
       {"v infinite", [=](M& m) { m.v[2] = inf; }, "seed 2", "not finite or beyond ±16384"},
       {"u_right infinite", [=](M& m) { m.u_right[0] = -inf; }, "seed 0", "beyond ±16384"},
       {"u beyond any image", [](M& m) { m.u[0] = 16385; }, "seed 0", "beyond ±16384"},
       {"v beyond any image", [](M& m) { m.v[0] = -16385; }, "seed 0", "beyond ±16384"},
       {"raw", [](M& m) { m.raw_count = -1; }, "raw_count = -1", ">= 0"},
       {"outside", [](M& m) { m.outside_count = -1; }, "outside_count = -1", ">= 0"},
       {"dark", [](M& m) { m.dark_count = -1; }, "dark_count = -1", ">= 0"},
       {"loose", [](M& m) { m.loose_count = -1; }, "loose_count = -1", ">= 0"},
       {"hidden", [](M& m) { m.hidden_count = -1; }, "hidden_count = -1", ">= 0"},
       {"contradicted", [](M& m) { m.contradicted_count = -1; }, "contradicted_count = -1", ">= 0"},
       {"background", [](M& m) { m.background_count = INT32_MIN; }, "background_count", ">= 0"}});
}

TEST(SeedsBorder, RefusesSeedsThatSayNotHowSureOrWhereFrom) {
  using M = seeds_t;
  const auto nan = static_cast<float>(kNan);
  const auto inf = static_cast<float>(kInf);
  constexpr const char* kSigma = "allowed is above 0, up to 1023";
  constexpr const char* kPixel = "allowed is -1 to 16383";
  // Of the examples the second is a stereo seed.
  ExpectRefused<M>(
      ToMessage(examples::Id(), examples::Seeds()), Part::kSeeds,
      {{"sigma not a number", [=](M& m) { m.sigma_px[1] = nan; }, "seed 1: sigma_px = nan", kSigma},
       {"sigma infinite", [=](M& m) { m.sigma_px[2] = inf; }, "seed 2: sigma_px = inf", kSigma},
       {"sigma 0", [](M& m) { m.sigma_px[0] = 0; }, "seed 0: sigma_px = 0", kSigma},
       {"sigma negative", [](M& m) { m.sigma_px[0] = -1; }, "seed 0: sigma_px = -1", kSigma},
       {"sigma too large", [](M& m) { m.sigma_px[0] = 1024; }, "seed 0: sigma_px = 1024", kSigma},
       {"origin 2", [](M& m) { m.origin[0] = 2; }, "seed 0: origin = 2", "TOF (0) or STEREO (1)"},
       {"origin -1", [](M& m) { m.origin[0] = -1; }, "seed 0: origin = -1", "TOF (0) or STEREO"},
       {"tof_u -2", [](M& m) { m.tof_u[0] = -2; }, "seed 0: tof_u = -2", kPixel},
       {"tof_v -2", [](M& m) { m.tof_v[0] = -2; }, "seed 0: tof_v = -2", kPixel},
       {"tof_u large", [](M& m) { m.tof_u[0] = 16384; }, "seed 0: tof_u = 16384", kPixel},
       {"tof_v large", [](M& m) { m.tof_v[0] = 32767; }, "seed 0: tof_v = 32767", kPixel},
       {"column alone", [](M& m) { m.tof_v[0] = -1; }, "seed 0: tof_v = -1", "where tof_u is"},
       {"row alone", [](M& m) { m.tof_u[2] = -1; }, "seed 2: tof_v = 16383", "where tof_u is"},
       {"pixel of a stereo seed", [](M& m) { m.tof_u[1] = m.tof_v[1] = 3; }, "seed 1: tof_u = 3",
        "-1 for a stereo seed"},
       {"ToF seed made stereo", [](M& m) { m.origin[2] = 1; }, "seed 2: tof_u = 0",
        "-1 for a stereo seed"}});
}

TEST(SeedsBorder, AcceptsTofSeedsThatDoNotNameTheirPixel) {
  seeds_t message = ToMessage(examples::Id(), examples::Seeds());
  message.tof_u[0] = message.tof_v[0] = -1;
  EXPECT_TRUE(DecodePart(Part::kSeeds, examples::Encode(message)));
}

// That a text as long as allowed is read, and one of a byte more is refused.
void ExpectLongest(size_t longest, auto message, const std::string& name, auto field,
                   const auto& decode) {
  (message.*field).assign(longest, 'x');
  EXPECT_TRUE(decode(examples::Encode(message))) << name;
  (message.*field).push_back('x');
  EXPECT_EQ(decode(examples::Encode(message)).error().text,
            name + " length = " + std::to_string(longest + 1) + ": allowed is 0 to " +
                std::to_string(longest));
}

TEST(StatusBorder, RefusesStringsLongerThanAnyOfOurs) {
  using M = stage_status_t;
  const M message = ToMessage(examples::Status());
  ExpectLongest(64, message, "stage", &M::stage, DecodeStatus);
  ExpectLongest(1024, message, "host", &M::host, DecodeStatus);
  ExpectLongest(1024, message, "version", &M::version, DecodeStatus);
  ExpectLongest(1024, message, "config_digest", &M::config_digest, DecodeStatus);
  ExpectLongest(1024, message, "last_error", &M::last_error, DecodeStatus);
}

TEST(StatusBorder, CutsWhatIsTooLongToBeSentBetweenTwoCharacters) {
  StageStatus status = examples::Status();
  for (int i = 0; i < 1000; ++i) status.last_error += "×";  // two bytes
  status.last_error.insert(0, "x");
  status.stage.assign(100, 's');
  const auto decoded = Required(DecodeStatus(EncodeStatus(status)));
  EXPECT_EQ(decoded.last_error.size(), 1023U);
  EXPECT_TRUE(decoded.last_error.ends_with("×"));
  EXPECT_EQ(decoded.stage.size(), 64U);
}

TEST(StatusBorder, RefusesACoverageThatIsNoShare) {
  stage_status_t message = ToMessage(examples::Status());
  for (const float share : {-1.F, 0.F, 1.F}) {
    message.tof_coverage = share;
    EXPECT_TRUE(DecodeStatus(examples::Encode(message))) << share;
  }
  const std::pair<float, const char*> table[] = {
      {-0.5F, "-0.5"}, {1.5F, "1.5"}, {static_cast<float>(kNan), "nan"}, {-2, "-2"}};
  for (const auto& [share, text] : table) {
    message.tof_coverage = share;
    EXPECT_EQ(DecodeStatus(examples::Encode(message)).error().text,
              std::string("tof_coverage = ") + text + ": allowed is 0 to 1, or -1 for not known");
  }
}

TEST(StatusBorder, RefusesCountsWhoseSumWouldOverflow) {
  stage_status_t message = ToMessage(examples::Status());
  message.sequence_gaps = int64_t{1} << 53;
  EXPECT_TRUE(DecodeStatus(examples::Encode(message)));
  for (const int64_t count : {(int64_t{1} << 53) + 1, int64_t{-1}}) {
    message.sequence_gaps = count;
    EXPECT_EQ(DecodeStatus(examples::Encode(message)).error().text,
              "sequence_gaps = " + std::to_string(count) + ": allowed is 0 to 2^53");
  }
}

TEST(StatusBorder, RefusesRatesAndTimesThatAreNoNumbers) {
  const std::pair<const char*, double stage_status_t::*> table[] = {
      {"rate_hz", &stage_status_t::rate_hz},
      {"latency_p50_ms", &stage_status_t::latency_p50_ms},
      {"latency_p95_ms", &stage_status_t::latency_p95_ms},
      {"latency_p99_ms", &stage_status_t::latency_p99_ms},
      {"latency_max_ms", &stage_status_t::latency_max_ms},
      {"age_p50_ms", &stage_status_t::age_p50_ms},
      {"age_p95_ms", &stage_status_t::age_p95_ms},
      {"age_p99_ms", &stage_status_t::age_p99_ms},
      {"age_max_ms", &stage_status_t::age_max_ms}};
  for (const auto& [name, field] : table) {
    stage_status_t message = ToMessage(examples::Status());
    message.*field = -1;  // an age is negative when the clocks of two hosts differ
    EXPECT_TRUE(DecodeStatus(examples::Encode(message))) << name;
    for (const double value : {kNan, kInf, -kInf}) {
      message.*field = value;
      EXPECT_THAT(WhyNot(DecodeStatus(examples::Encode(message))),
                  HasSubstr(std::string(name) + " = "));
    }
  }
}

TEST(StatusBorder, RefusesAnUnknownStateAndABadHeader) {
  stage_status_t message = ToMessage(examples::Status());
  message.state = 3;
  EXPECT_THAT(DecodeStatus(examples::Encode(message)).error().text,
              HasSubstr("state = 3: allowed is READY, RUNNING or STOPPED"));
  message.state = -1;
  EXPECT_THAT(DecodeStatus(examples::Encode(message)).error().text, HasSubstr("state = -1"));
  message.state = 1;
  message.header.seq = -2;
  EXPECT_THAT(DecodeStatus(examples::Encode(message)).error().text, HasSubstr("header.seq = -2"));
}

TEST(ProcessBorder, RefusesStringsLongerThanAnyOfOurs) {
  using M = process_info_t;
  const M message = ToMessage(examples::Process());
  ExpectLongest(64, message, "stage", &M::stage, DecodeProcessInfo);
  ExpectLongest(1024, message, "host", &M::host, DecodeProcessInfo);
  ExpectLongest(1024, message, "version", &M::version, DecodeProcessInfo);
  ExpectLongest(1024, message, "config_digest", &M::config_digest, DecodeProcessInfo);
  ExpectLongest(65536, message, "config_text", &M::config_text, DecodeProcessInfo);
}

TEST(ProcessBorder, SendsWhatIsTooLongCut) {
  ProcessInfo info = examples::Process();
  info.config_text.assign(100'000, 'x');
  const auto decoded = Required(DecodeProcessInfo(EncodeProcessInfo(info)));
  EXPECT_EQ(decoded.config_text.size(), 65536U);
}

}  // namespace
}  // namespace sprout
