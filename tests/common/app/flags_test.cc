#include "common/app/flags.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <optional>

#include "common/app/help_text.h"
#include "common/config/config_error.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

bool Parse(Flags& flags, std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "probe");
  return flags.Parse(static_cast<int>(arguments.size()), arguments.data());
}

std::string ErrorOf(Flags& flags, const std::vector<const char*>& arguments) {
  return Thrown<ConfigError>([&] { Parse(flags, arguments); });
}

std::string HelpOf(Flags& flags) {
  testing::internal::CaptureStdout();
  EXPECT_FALSE(Parse(flags, {"--help"}));
  return testing::internal::GetCapturedStdout();
}

TEST(Flags, SetWhatIsGivenAndLeaveTheRest) {
  Flags flags("probe", "Probes flags");
  std::string out = "default", file;
  std::optional<double> rate, pause;
  std::vector<std::string> names, logs;
  bool is_loud = false, is_long = false;
  flags.Add("--out DIR", out, "");
  flags.Add("FILE", file, "");
  flags.Add("--rate", rate, "");
  flags.Add("--pause", pause, "");
  flags.Add("--names", names, "").SplitAtCommas();
  flags.Add("--log", logs, "").Repeatable();
  flags.Add("--loud", is_loud, "");
  flags.Add("--long", is_long, "");
  EXPECT_TRUE(Parse(flags, {"a.png", "--rate", "2.5", "--names", "x,y", "--log", "1.lcm", "--log",
                            "2.lcm", "--loud"}));
  EXPECT_EQ(out, "default");
  EXPECT_EQ(file, "a.png");
  EXPECT_EQ(rate, 2.5);
  EXPECT_EQ(pause, std::nullopt);
  EXPECT_THAT(names, ElementsAre("x", "y"));
  EXPECT_THAT(logs, ElementsAre("1.lcm", "2.lcm"));
  EXPECT_TRUE(is_loud);
  EXPECT_FALSE(is_long);
}

TEST(Flags, RefuseAListWithAnEmptyElementOrBlanks) {
  Flags flags("probe", "Probes flags");
  std::vector<std::string> names, more;
  bool is_loud = false;
  flags.Add("--names", names, "").SplitAtCommas();
  flags.Add("--loud", is_loud, "");
  flags.AddCommand("go", "", [] { return 0; }).Add("--more", more, "").SplitAtCommas();
  for (const std::string list : {",", "x,", ",x", "x,,y", "x, y"}) {
    const std::string error =
        "'" + list + "': allowed are names with one comma between them, without blanks";
    EXPECT_EQ(ErrorOf(flags, {"--names", list.c_str(), "--loud"}), "--names " + error);
    EXPECT_EQ(ErrorOf(flags, {("--names=" + list).c_str(), "--loud"}), "--names " + error);
    EXPECT_EQ(ErrorOf(flags, {"go", "--more", list.c_str()}), "--more " + error);
  }
  EXPECT_EQ(ErrorOf(flags, {"--names", "x", "--loud"}), "no error");
}

TEST(Flags, SayWhyAFileThatIsThereCannotBeRead) {
  const TemporaryDirectory folder;
  const std::string loop = folder / "loop";
  std::filesystem::create_symlink(loop, loop);
  Flags flags("probe", "Probes flags");
  std::string log, none;
  flags.Add("LOG", log, "").ExistingPath();
  flags.Add("--file", none, "").ExistingFile();
  const std::string why = loop + ": cannot be read (Too many levels of symbolic links)";
  EXPECT_THAT(ErrorOf(flags, {loop.c_str()}), HasSubstr("LOG: " + why));
  EXPECT_THAT(ErrorOf(flags, {"--file", loop.c_str()}), HasSubstr("--file: " + why));
}

TEST(Flags, RefuseWhatIsNotAllowedAndSayWhatIs) {
  Flags flags("probe", "Probes flags");
  double share = 0;
  int count = 0;
  int64_t any = 0;
  std::vector<uint64_t> seeds;
  std::string way;
  std::filesystem::path out;
  flags.Add("--any", any, "");
  flags.Add("--out", out, "");
  flags.Add("--seeds", seeds, "").Repeatable();
  flags.Add("--share", share, "").Within(0, 1);
  flags.Add("--count", count, "").WithinWhole(1, 9);
  flags.Add("--way", way, "").OneOf({"up", "down"});
  for (const char* share_text : {"1.5", "nan", "x", "0.5x"}) {
    EXPECT_EQ(ErrorOf(flags, {"--share", share_text}),
              "--share: '" + std::string(share_text) +
                  "' is not allowed: a number from 0 to 1 (--help lists the flags)");
  }
  EXPECT_THAT(ErrorOf(flags, {"--count", "10"}), ContainsRegex("10 not in range \\[?1 (to|-) 9"));
  EXPECT_THAT(ErrorOf(flags, {"--way", "left"}), HasSubstr("left not in {up,down}"));
  for (const char* any_text : {"5x", "1.5", "99999999999999999999", "0x10"}) {
    EXPECT_EQ(ErrorOf(flags, {"--any", any_text}),
              "--any: '" + std::string(any_text) +
                  "' is not allowed: a whole number up to 9223372036854775807 (--help lists the "
                  "flags)");
  }
  EXPECT_EQ(ErrorOf(flags, {"--any", "-010"}), "no error");
  EXPECT_EQ(any, -10);
  EXPECT_THAT(ErrorOf(flags, {"--seeds", "7", "--seeds", "-1"}), HasSubstr("'-1' is not allowed"));
  EXPECT_THAT(ErrorOf(flags, {"--out=~/logs"}), HasSubstr("--out '~/logs': shells replace ~ only"));
  EXPECT_EQ(ErrorOf(flags, {"--out", "./~/logs"}), "no error");
  EXPECT_EQ(ErrorOf(flags, {"--way"}), "--way needs a value (--help lists the flags)");
  EXPECT_EQ(ErrorOf(flags, {"--way", "up", "--way", "down"}),
            "--way is given more than once (--help lists the flags)");
  EXPECT_THAT(ErrorOf(flags, {"--bogus"}),
              HasSubstr("--bogus is no flag of probe (--help lists the flags)"));
  EXPECT_EQ(ErrorOf(flags, {"--share", "1", "--count", "9", "--way", "up"}), "no error");
}

TEST(Flags, ListInTheirHelpWhatTheyTakeTheirDefaultsAndEachOtherByName) {
  Flags flags("probe", "Probes flags");
  std::string out, rig = "r";
  int count = 7;
  flags.Add("--out DIR", out, "Where to").Required();
  const Flag rig_flag = flags.Add("--rig", rig, "Calibration").ShowDefault("none");
  flags.Add("--zero", count, "").Excludes(rig_flag);
  flags.Add("--count", count, "How many")
      .ShowDefault()
      .Excludes(rig_flag)
      .Needs(flags.Get("--out"));
  flags.Add("--all", count, "").Excludes(rig_flag);
  const std::string help = HelpOf(flags);
  EXPECT_THAT(help, HasSubstr("--out DIR REQUIRED          Where to\n"));
  // CLI11 2.4 has "[none] " in the place of "=none".
  EXPECT_THAT(help, ContainsRegex("--rig TEXT(=none| \\[none\\] ) Excludes: --all --count --zero"));
  EXPECT_THAT(help, ContainsRegex("--count INT(=7| \\[7\\] ) Needs: --out Excludes: --rig"));
}

TEST(Flags, RunTheCommandThatIsGiven) {
  Flags flags("probe", "Probes flags");
  std::string text;
  flags.RequireCommand();
  flags.AddCommand("one", "", [&] { return text == "x" ? 3 : 4; }).Add("TEXT", text, "");
  const Flags& other = flags.AddCommand("other", "", [] { return 5; });
  EXPECT_THAT(ErrorOf(flags, {}), HasSubstr("which command? one, other"));
  EXPECT_TRUE(Parse(flags, {"one", "x"}));
  EXPECT_FALSE(other.IsGiven());
  EXPECT_EQ(flags.RunCommand(), 3);
  EXPECT_TRUE(Parse(flags, {"other"}));
  EXPECT_TRUE(other.IsGiven());
  EXPECT_EQ(flags.RunCommand(), 5);
}

TEST(Flags, SayWhatWasMeantByACommandOrFlagThatIsNone) {
  Flags flags("probe", "Probes flags");
  std::string left, right, out, config;
  flags.Add("--config FILE", config, "");
  Flags& files = flags.AddCommand("files", "", [] { return 0; });
  files.InheritExcept({});
  files.Add("LEFT", left, "").Required();
  files.Add("RIGHT", right, "").Required();
  files.Add("--out DIR", out, "").Required();
  flags.AddCommand("info", "", [] { return 0; });
  EXPECT_EQ(ErrorOf(flags, {"file", "l.png", "r.png", "--out", "o", "--config", "c"}),
            "'file' is no command of probe: did you mean files? (--help lists the commands)");
  EXPECT_EQ(ErrorOf(flags, {"inf"}),
            "'inf' is no command of probe: did you mean info? (--help lists the commands)");
  EXPECT_EQ(ErrorOf(flags, {"play"}), "'play' is no command of probe (--help lists the commands)");
  EXPECT_EQ(ErrorOf(flags, {"files", "l.png", "r.png", "--cofnig", "c", "--out", "o"}),
            "--cofnig is no flag of probe: did you mean --config? (--help lists the flags)");
  EXPECT_EQ(ErrorOf(flags, {"files", "l.png", "r.png", "--uot=o"}),
            "--uot is no flag of probe: did you mean --out? (--help lists the flags)");
  EXPECT_EQ(ErrorOf(flags, {"files", "l.png", "r.png", "tof.png", "--out", "o"}),
            "'tof.png' is one argument too many (--help lists what is taken)");
  EXPECT_EQ(ErrorOf(flags, {"files", "l.png", "r.png", "--out", "o"}), "no error");
}

TEST(NearestName, IsFoundDespiteAFewWrongLettersButNotInAnything) {
  const std::vector<std::string> names = {"info", "images", "export", "channels", "channel"};
  EXPECT_EQ(NearestName("inof", names), "info");
  EXPECT_EQ(NearestName("imagse", names), "images");
  EXPECT_EQ(NearestName("exp", names), "export");
  EXPECT_EQ(NearestName("chanel", names), "channel");
  EXPECT_EQ(NearestName("play", names), "");
  EXPECT_EQ(NearestName("x", names), "");
  EXPECT_EQ(NearestName("", names), "");
}

TEST(Flags, DoAnActionInPlaceOfTheProgramsWork) {
  Flags flags("probe", "Probes flags");
  int acts = 0;
  flags.AddAction(
      "--list", [&] { ++acts; }, "");
  EXPECT_TRUE(Parse(flags, {}));
  EXPECT_FALSE(Parse(flags, {"--list"}));
  EXPECT_EQ(acts, 1);
}

}  // namespace
}  // namespace sprout
