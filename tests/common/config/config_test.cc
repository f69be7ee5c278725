#include "common/config/config.h"

#include <gmock/gmock.h>

#include <fstream>

#include "common/config/config_difference.h"
#include "common/config/frame_range.h"
#include "common/config/left_out.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ConfigFiles : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    const std::string path = folder_ / name;
    std::ofstream(path) << text;
    return path;
  }

  static std::string ErrorOf(const std::vector<std::string>& files) {
    try {
      LoadConfig(files);
    } catch (const ConfigError& e) {
      EXPECT_THAT(e.what(), ::testing::Not(HasSubstr("\n"))) << "one line";
      return e.what();
    }
    return "";
  }

  const TemporaryDirectory folder_;
};

std::vector<std::string> ShippedPresets() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(PresetsFolder())) {
    names.push_back(entry.path().stem().string());
  }
  return names;
}

TEST_F(ConfigFiles, LoadsEveryPresetThatShipsByNameAndByPath) {
  const std::vector<std::string> names = ShippedPresets();
  ASSERT_FALSE(names.empty());
  for (const std::string& name : names) {
    const std::string path = (PresetsFolder() / (name + ".textproto")).string();
    EXPECT_EQ(ConfigText(LoadConfig({name})), ConfigText(LoadConfig({path}))) << name;
  }
}

TEST_F(ConfigFiles, PresetPaperHasThePapersParameters) {
  const SproutConfig config = LoadConfig({"paper"});
  EXPECT_EQ(config.capture().tof_grid_px(), 10);
  EXPECT_EQ(config.grow().similarity(), GrowConfig::EPC);
  EXPECT_EQ(config.grow().threshold(), 0.5);
  EXPECT_EQ(config.grow().sigma_s_squared(), 0.1);
  EXPECT_EQ(config.grow().fill(), GrowConfig::ONE_PASS);
}

TEST_F(ConfigFiles, PresetFastIsThePapersChain) {
  const SproutConfig config = LoadConfig({"fast"});
  EXPECT_EQ(config.prior().method(), PriorConfig::DELAUNAY);
  EXPECT_EQ(config.grow().similarity(), GrowConfig::EPC);
  EXPECT_FALSE(config.grow().sub_pixel());
}

TEST_F(ConfigFiles, HasDefaultsWithoutAFileAndForAnEmptyOne) {
  const SproutConfig defaults = LoadConfig({});
  EXPECT_EQ(defaults.capture().tof_grid_px(), 10);
  EXPECT_EQ(defaults.grow().threshold(), 0.5);
  EXPECT_EQ(ConfigText(LoadConfig({"default"})), ConfigText(defaults));
  EXPECT_EQ(ConfigText(LoadConfig({Write("empty.textproto", "")})), ConfigText(defaults));
  EXPECT_EQ(ConfigText(LoadConfig({Write("comment.textproto", "# nothing\n")})),
            ConfigText(defaults));
}

TEST_F(ConfigFiles, LetsLaterFilesOverrideEarlierOnesKeyByKey) {
  const std::string a = Write("a.textproto", "grow { threshold: 0.6 sigma_p_px: 2 }");
  const std::string b = Write("b.textproto", "grow { threshold: 0.7 } refine { min_amplitude: 3 }");
  const SproutConfig ab = LoadConfig({a, b});
  EXPECT_EQ(ab.grow().threshold(), 0.7);
  EXPECT_EQ(ab.grow().sigma_p_px(), 2);
  EXPECT_EQ(ab.refine().min_amplitude(), 3);
  EXPECT_EQ(LoadConfig({b, a}).grow().threshold(), 0.6);
  EXPECT_EQ(LoadConfig({"paper", a}).grow().sigma_p_px(), 2) << "over a preset";
}

TEST_F(ConfigFiles, TakesTextInPlaceOfAFile) {
  const SproutConfig config =
      LoadConfig({"fast", "grow { sigma_p_px: 2.5 } prior { left_seeds: true }"});
  EXPECT_DOUBLE_EQ(config.grow().sigma_p_px(), 2.5);
  EXPECT_TRUE(config.prior().left_seeds());
  EXPECT_EQ(config.prior().method(), PriorConfig::DELAUNAY);
  EXPECT_THAT(Thrown<ConfigError>([&] { LoadConfig({"grow {\n no_such: 1 }"}); }),
              AllOf(HasSubstr("configuration text:2:"), HasSubstr("no_such")));
}

TEST_F(ConfigFiles, NamesFileLineAndKeyOfAnUnknownKey) {
  const std::string file = Write("typo.textproto", "# first line\ngrow {\n  treshold: 0.5\n}\n");
  EXPECT_THAT(ErrorOf({file}), AllOf(HasSubstr(file + ":3:"), HasSubstr("treshold")));
  const std::string section = Write("section.textproto", "growth {}\n");
  EXPECT_THAT(ErrorOf({section}), AllOf(HasSubstr(section + ":1:"), HasSubstr("growth")));
}

TEST_F(ConfigFiles, NamesFileAndLineOfASyntaxError) {
  const std::string open = Write("open.textproto", "grow {\n  threshold: 0.5\n");
  EXPECT_THAT(ErrorOf({open}), HasSubstr(open + ":3:"));
  const std::string word = Write("word.textproto", "grow {\n  threshold: high\n}\n");
  EXPECT_THAT(ErrorOf({word}), HasSubstr(word + ":2:"));
  const std::string choice = Write("enum.textproto", "grow { similarity: SSD }\n");
  EXPECT_THAT(ErrorOf({choice}), AllOf(HasSubstr(choice + ":1:"), HasSubstr("SSD")));
  const std::string bytes = Write("bytes.textproto", std::string("\0\x01\xff\xfe", 4));
  EXPECT_THAT(ErrorOf({bytes}), HasSubstr(bytes + ":1:"));
}

TEST_F(ConfigFiles, RefusesAKeyThatStandsTwiceInOneFile) {
  const std::string file =
      Write("twice.textproto", "grow {\n  threshold: 0.5\n  threshold: 0.6\n}\n");
  EXPECT_THAT(ErrorOf({file}), AllOf(HasSubstr(file + ":3:"), HasSubstr("threshold")));
}

TEST_F(ConfigFiles, NamesTheOffendingFileOfSeveral) {
  const std::string good = Write("good.textproto", "");
  const std::string bad = Write("bad.textproto", "nonsense: 1");
  EXPECT_THAT(ErrorOf({good, bad}), HasSubstr(bad));
}

TEST_F(ConfigFiles, ListsThePresetsWhenAFileCannotBeRead) {
  const std::string missing = folder_ / "missing.textproto";
  for (const std::string& file :
       {missing, folder_.path().string(), std::string("no_such_preset")}) {
    const std::string error = ErrorOf({file});
    EXPECT_THAT(error, HasSubstr(file));
    EXPECT_THAT(error, HasSubstr("cannot be read"));
    for (const std::string& preset : ShippedPresets()) EXPECT_THAT(error, HasSubstr(preset));
  }
}

TEST_F(ConfigFiles, ReadsNothingButRegularFilesOfAMegabyte) {
  EXPECT_THAT(ErrorOf({"/proc/self/mem"}),
              HasSubstr("configuration /proc/self/mem: cannot be read (Input/output error); "));
  EXPECT_THAT(ErrorOf({"/dev/zero"}),
              HasSubstr("configuration /dev/zero: cannot be read (no regular file); allowed: "));
  const std::string comment = "#" + std::string((1 << 20) - 1, 'x');
  EXPECT_EQ(ErrorOf({Write("most.textproto", comment)}), "");
  EXPECT_THAT(ErrorOf({Write("more.textproto", comment + "x")}),
              HasSubstr("more.textproto: cannot be read (larger than 1 MiB); allowed: "));
}

TEST(FrameRange, IsReadWithBothEndsIncluded) {
  EXPECT_EQ(ParseFrameRange("--frames", "3:7"), (FrameRange{3, 7}));
  EXPECT_EQ(ParseFrameRange("--frames", "5"), (FrameRange{5, 5}));
  EXPECT_EQ(ParseFrameRange("--frames", "5:"), (FrameRange{5, FrameRange().last}));
  EXPECT_EQ(ParseFrameRange("--frames", ":5"), (FrameRange{0, 5}));
  EXPECT_EQ(ParseFrameRange("--frames", ":"), FrameRange());
  EXPECT_TRUE((FrameRange{3, 7}).Has(3));
  EXPECT_TRUE((FrameRange{3, 7}).Has(7));
  EXPECT_FALSE((FrameRange{3, 7}).Has(2));
  EXPECT_FALSE((FrameRange{3, 7}).Has(8));
}

TEST(FrameRange, RefusesOtherTexts) {
  for (const char* text :
       {"", "a", "3:b", "7:3", "-1", "-1:2", "1:2:3", "1-2", " 1", "99999999999999999999"}) {
    EXPECT_THROW(ParseFrameRange("--frames", text), ConfigError) << text;
  }
}

TEST(LeftOut, SaysWhatIsMissingAndHowToGetIt) {
  EXPECT_STREQ(LeftOut("--mcap", "ROS2").what(),
               "--mcap: built without ROS 2 and MCAP; -DSPROUT_ROS2=ON needs cyclonedds-dev "
               "cyclonedds-tools liblz4-dev libyaml-cpp-dev");
  EXPECT_THAT(LeftOut("sprout: view", "VIEW").what(),
              testing::StartsWith("sprout: view: built without the page in a browser; "));
}

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ConfigDifferences, AreNoneBetweenEqualConfigurations) {
  const std::string text = ConfigText(LoadConfig({"default"}));
  EXPECT_THAT(ConfigDifferences(text, text), IsEmpty());
}

TEST(ConfigDifferences, NameKeysAndValues) {
  SproutConfig config = LoadConfig({"default"});
  const std::string before = ConfigText(config);
  config.mutable_grow()->set_sigma_p_px(2);
  config.mutable_capture()->set_source("log:run: 7 {.lcm");
  const auto differences = ConfigDifferences(before, ConfigText(config));
  ASSERT_EQ(differences.size(), 2U);
  EXPECT_EQ(differences[0].key, "capture.source");
  EXPECT_EQ(differences[0].b, "\"log:run: 7 {.lcm\"");
  EXPECT_EQ(differences[1], (ConfigDifference{"grow.sigma_p_px", "0.8", "2"}));
}

TEST(ConfigDifferences, CompareAllElementsOfAList) {
  SproutConfig config;
  const std::string before = ConfigText(config);
  for (const int corner : {100, 0, 1500, 900}) config.mutable_depth()->add_region(corner);
  const std::string wide = ConfigText(config);
  config.mutable_depth()->set_region(0, 0);
  EXPECT_THAT(ConfigDifferences(before, wide),
              ElementsAre(ConfigDifference{"depth.region", "none", "100 0 1500 900"}));
  EXPECT_THAT(ConfigDifferences(wide, ConfigText(config)),
              ElementsAre(ConfigDifference{"depth.region", "100 0 1500 900", "0 0 1500 900"}));
}

TEST(ConfigDifferences, CompareWhatOtherVersionsPrinted) {
  EXPECT_THAT(ConfigDifferences("grow {\n  old: 1\n  mode: GONE\n}\n",
                                "grow {\n  mode: NEW\n  part {\n    new: 2\n  }\n}\ntop: 3\n"),
              ElementsAre(ConfigDifference{"grow.mode", "GONE", "NEW"},
                          ConfigDifference{"grow.old", "1", "none"},
                          ConfigDifference{"grow.part.new", "none", "2"},
                          ConfigDifference{"top", "none", "3"}));
}

TEST(ConfigDifferences, SurviveAnyText) {
  EXPECT_THAT(ConfigDifferences("}\n}\n{ {\n: \n  \n", ""), ElementsAre());
  EXPECT_THAT(ConfigDifferences("a: 1", "a: 1\n"), IsEmpty());
}

}  // namespace

}  // namespace sprout
