// What comes from elsewhere: names of logs, lists, manifests, indexes, results.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/app/process.h"
#include "common/core/digest.h"
#include "services/batch/frame_commands.h"
#include "services/batch/merge.h"
#include "services/batch/names.h"
#include "services/batch/planning.h"
#include "services/batch/result_folder.h"
#include "services/batch/stage_run.h"
#include "services/batch/tables.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/log/graph_log.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Json = nlohmann::json;

template <typename Error>
std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

std::string TextOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteFile(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

const std::string kOddNames[] = {"two words",     " leading",
                                 "-dash",         "x'$(touch PWNED)'",
                                 "`touch PWNED`", "$(touch PWNED)",
                                 "${HOME}",       "\"quoted\"",
                                 "it's",          "'; touch PWNED; '",
                                 "back\\slash\\", "a;touch PWNED",
                                 "a&touch PWNED", "a|touch PWNED",
                                 ">PWNED",        "*",
                                 "[a-z]?",        "~",
                                 "#hash",         "!!",
                                 "{a,b}=%s",      "\u00fcmlaut \u6df1\u5ea6"};

TEST(ResultNames, AreUniqueAfterCharactersAreReplaced) {
  std::set<std::string> taken;
  EXPECT_EQ(ResultNameOf("/x/run_1.lcm", taken), "run_1");
  EXPECT_EQ(ResultNameOf("/x/run,1.lcm", taken), "run_1-2");
  EXPECT_EQ(ResultNameOf("/x/run\"1.lcm", taken), "run_1-3");
  EXPECT_EQ(ResultNameOf("/x/run_1-2.lcm", taken), "run_1-2-2");
  EXPECT_EQ(ResultNameOf("/x/...lcm", taken), "log");  // its stem is ".."
  EXPECT_THAT(ResultNameOf("/x/" + std::string(250, 'x') + ".lcm", taken), SizeIs(180));
}

TEST(ResultNames, AreGoodForOddLogs) {
  std::set<std::string> taken;
  for (const std::string& name : kOddNames) {
    EXPECT_TRUE(IsResultName(ResultNameOf("/x/" + name + ".lcm", taken))) << name;
  }
  EXPECT_THAT(taken, SizeIs(std::size(kOddNames)));
}

// Programs that note what they were called with, one argument a line.
void WriteStubs(const fs::path& folder) {
  for (const char* name : {"sprout-view", "sprout-refine", "sprout-prior", "sprout-grow"}) {
    WriteFile(folder / name,
              "#!/bin/sh\nfor word in \"${0##*/}\" \"$@\"; do printf '%s\\n' \"$word\" >> "
              "\"$CALLS\"; done\n");
    fs::permissions(folder / name, fs::perms::owner_all);
  }
}

// What the stubs note when the commands of a frame are run.
std::string CallsOf(const std::string& name) {
  const std::string log = "/logs/" + name + ".lcm";
  const std::string start =
      "\n--config\n/out/" + name + "/config_a.textproto\n--frames\n7\n--replay\n" + log + "\n";
  const std::string prefix = "--channel-prefix=" + name + "\n";
  return "sprout-view\n--log\n" + log + "\n--frame\n7\n" + prefix + "sprout-refine" + start +
         "--record\nrefine_a.lcm\n" + prefix + "sprout-prior" + start +
         "--replay\nrefine_a.lcm\n--record\nprior_a.lcm\n" + prefix;
}

TEST(FrameCommands, StandForThemselvesInAShellWhateverIsInTheNames) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "bin");
  std::string commands = "cd '" + (folder / "").string() + "' || exit 9\n";
  std::string calls;
  for (const std::string& name : kOddNames) {
    const fs::path bin = (folder / "bin") / name;
    fs::create_directory(bin);
    WriteStubs(bin);
    BatchHead head;
    head.stages = {"refine", "prior"};
    head.prefix = name;
    Variant variant{.name = "a", .config_digest = "", .programs = {}};
    for (const std::string& stage : head.stages) {
      variant.programs[stage] = {(bin / ("sprout-" + stage)).string(), "", ""};
    }
    head.variants = {variant};
    const BatchLog log{.path = "/logs/" + name + ".lcm", .name = "x", .index = "", .summary = {}};
    commands += FrameCommands(BatchFolder("/out/" + name), head, log, 7, bin);
    calls += CallsOf(name);
  }
  WriteFile(folder / "commands", commands);
  for (const char* const shell : {"sh", "bash"}) {
    Process process({"env", "CALLS=" + (folder / "calls").string(), shell, folder / "commands"});
    EXPECT_EQ(process.Wait(std::chrono::seconds(120)), 0) << process.Output();
    EXPECT_EQ(TextOf(folder / "calls"), calls) << shell;
    fs::remove(folder / "calls");
    EXPECT_EQ(folder.CountEntries(), 2);  // nothing but bin and commands: nobody touched PWNED
  }
}

TEST(FindLogs, NamesAndLeavesOutWhatCannotStandInAManifest) {
  const TemporaryDirectory folder;
  for (const char* name : {"a.lcm", "b\xe4.lcm", "c\nd.lcm", "\u00fc.lcm"}) {
    WriteFile(folder / name, "x");
  }
  const FoundLogs found = FindLogs({folder / ""});
  const std::string path = (folder / "").string();
  EXPECT_THAT(found.logs, ElementsAre(path + "a.lcm", path + "\u00fc.lcm"));
  EXPECT_THAT(found.left_out, ElementsAre(path + "b\\xe4.lcm", path + "c\\x0ad.lcm"));
  EXPECT_THAT(ErrorOf<ConfigError>([&] { FindLogs({folder / "b\xe4.lcm"}); }),
              HasSubstr("b\\xe4.lcm: is not allowed in the manifest; allowed are names in UTF-8"));
}

TEST(FindLogs, RefusesAListThatContainsItself) {
  const TemporaryDirectory folder;
  const std::string list = folder / "list.txt";
  WriteFile(folder / "a.lcm", "x");
  WriteFile(list, (folder / "a.lcm").string() + "\n@" + list + "\n");
  EXPECT_THAT(ErrorOf<ConfigError>([&] { FindLogs({"@" + list}); }),
              HasSubstr("list.txt: the list contains itself"));
  // Also over another list, and over a link. Twice the same beside each other is none.
  const std::string other = folder / "other.txt";
  fs::create_symlink(list, folder / "link.txt");
  WriteFile(list, "@" + other + "\n");
  WriteFile(other, "@" + (folder / "link.txt").string() + "\n");
  EXPECT_THAT(ErrorOf<ConfigError>([&] { FindLogs({"@" + list}); }), HasSubstr("contains itself"));
  WriteFile(other, (folder / "a.lcm").string() + "\n");
  EXPECT_THAT(FindLogs({"@" + list, "@" + list}).logs, SizeIs(1));
  EXPECT_THAT(ErrorOf<ConfigError>([&] { FindLogs({"@/dev/zero"}); }), HasSubstr("no such list"));
}

TEST(LogIndex, IsMadeAgainWhenItIsDamaged) {
  const log::LogFolder folder;
  const std::string log = folder.Write("run.lcm", log::GraphEvents(4));
  const std::string index = log + ".index";
  EXPECT_EQ(LogIndex::Ensure(log, "").replaced(), "");
  const std::string whole = TextOf(index);
  std::string flipped = whole;
  flipped[whole.size() - 5] ^= 1;
  for (const std::string& damaged :
       {whole.substr(0, whole.size() - 7), whole.substr(0, 100), std::string(), flipped,
        whole + "1 2 3 SPROUT_LEFT 4 5 cafe 6\n"}) {
    WriteFile(index, damaged);
    const LogIndex again = LogIndex::Ensure(log, "");
    EXPECT_THAT(again.replaced(), HasSubstr("run.lcm.index: "));
    EXPECT_EQ(TextOf(index), whole);
    EXPECT_EQ(LogIndex::Ensure(log, "").replaced(), "");
  }
}

TEST(LogIndex, KnowsFromItsFirstLineThatItIsCut) {
  const log::LogFolder folder;
  const std::string log = folder.Write("run.lcm", log::GraphEvents(4));
  const std::string index = LogIndex::Ensure(log, "").path();
  EXPECT_TRUE(LogIndex::IsOf(index, StampOf(log)));
  fs::resize_file(index, fs::file_size(index) - 3);
  EXPECT_FALSE(LogIndex::IsOf(index, StampOf(log)));
}

// A manifest whose fields are changed one by one.
class ForeignManifest : public testing::Test {
 protected:
  void SetUp() override {
    Manifest manifest;
    BatchHead& head = manifest.head;
    head.stages = {"prior", "grow"};
    head.keep = {"grow"};
    head.shard_bytes = 1000;
    head.tables = Digest("tables");
    for (const char* name : {"a", "b"}) {
      Variant variant{.name = name, .config_digest = Digest(name), .programs = {}};
      for (const std::string& stage : head.stages) {
        variant.programs[stage] = {"/bin/sprout-" + stage, Digest(stage), "1.0"};
      }
      head.variants.push_back(variant);
    }
    for (const char* name : {"x", "y"}) {
      manifest.logs.push_back({.path = std::string("/logs/") + name + ".lcm",
                               .name = name,
                               .index = std::string("/logs/") + name + ".index",
                               .summary = {}});
    }
    for (int64_t log : {0, 1}) {
      Shard shard;
      shard.log = log;
      shard.end = 10;
      shard.carried = {3};
      shard.input = Digest("input");
      manifest.shards.push_back(shard);
    }
    WriteManifest(path_, manifest);
    std::ifstream file(path_);
    for (std::string line; std::getline(file, line);) lines_.push_back(Json::parse(line));
  }

  // @returns why the manifest is refused when a field of a line has this value.
  std::string ErrorWith(size_t line, const std::string& field, const Json& value) const {
    std::vector<Json> lines = lines_;
    lines[line][Json::json_pointer(field)] = value;
    return ErrorOfLines(lines);
  }

  std::string ErrorWithout(size_t line, const std::string& field) const {
    std::vector<Json> lines = lines_;
    lines[line].erase(field);
    return ErrorOfLines(lines);
  }

  std::string ErrorOfLines(const std::vector<Json>& lines) const {
    std::ofstream file(path_);
    for (const Json& line : lines) file << line.dump() << "\n";
    file.close();
    return ErrorOf<ConfigError>([&] { ReadManifest(path_); });
  }

  TemporaryDirectory folder_;
  fs::path path_ = folder_ / "manifest.jsonl";
  std::vector<Json> lines_;
};

TEST_F(ForeignManifest, IsTakenAsItWasWritten) {
  EXPECT_EQ(ErrorOfLines(lines_), "no error");
  const Manifest manifest = ReadManifest(path_);
  EXPECT_THAT(manifest.shards, SizeIs(2));
  EXPECT_EQ(manifest.logs[1].name, "y");
  EXPECT_EQ(manifest.head.variants[1].programs.at("grow").path, "/bin/sprout-grow");
}

TEST_F(ForeignManifest, IsRefusedWithTheFieldItsValueAndWhatIsAllowed) {
  const struct {
    size_t line;
    const char* field;
    Json value;
    const char* error;
  } kCases[] = {
      {0, "/stages", Json::array(),
       "line 1: stages : allowed are refine, prior, grow and temporal"},
      {0,
       "/stages",
       {"grow", "prior"},
       "stages grow,prior: allowed are refine, prior, grow and temporal"},
      {0, "/stages", "grow", "stages = \"grow\": allowed is an array"},
      {0, "/keep", Json::array(), "keep = []: allowed is stages of the batch in their order"},
      {0, "/keep", {"refine", "grow"}, "keep = [refine,grow]: allowed is stages of the batch"},
      {0, "/keep", {"prior"}, "keep = [prior]: allowed is stages of the batch"},
      {0, "/keep", {"grow", "prior"}, "keep = [grow,prior]: allowed is stages of the batch"},
      {0, "/keep", {"prior", "../x", "grow"}, "keep = [prior,../x,grow]: allowed is stages"},
      {0, "/keep", {1}, "keep = 1: allowed is a text"},
      {0, "/channel_prefix", "'; x", "channel_prefix = '; x: allowed is up to "},
      {0, "/shard_bytes", 0, "shard_bytes = 0: allowed is 1 or more"},
      {0, "/tables", "../x", "tables = \"../x\": allowed is 16 hexadecimal digits"},
      {0, "/truth", 7, "truth = 7: allowed is a text"},
      {0, "/variants", Json::array(), "variants = 0: allowed is one or two"},
      {0, "/variants/1/name", "../b", "name = ../b: allowed is b here"},
      {0, "/variants/0/config_digest", "<b>", "config_digest = \"<b>\": allowed is 16 hexa"},
      {0, "/variants/0/programs/grow", 1, "grow = 1: allowed is an object"},
      {0, "/variants/0/programs/grow/path", "grow", "path = \"grow\": allowed is an absolute path"},
      {0, "/left_out_logs", {"a\nb"}, "left_out_logs = \"a\\nb\": allowed is a text, UTF-8"},
      {1, "/name", "../../victim", "line 2: name = ../../victim: allowed is a file name"},
      {1, "/name", "", "name = : allowed is a file name"},
      {1, "/name", "..", "name = ..: allowed is a file name"},
      {1, "/name", "a,b", "name = a,b: allowed is a file name"},
      {2, "/name", "x", "line 3: name = x: allowed is one that no other log has"},
      {1, "/log", "x.lcm", "log = \"x.lcm\": allowed is an absolute path"},
      {1, "/bytes", 1e300, "bytes = 1e+300: allowed is a whole number"},
      {1, "/events", -1, "events = -1: allowed is a whole number from 0"},
      {1, "/cuttable", 1, "cuttable = 1: allowed is true or false"},
      {3, "/of_log", 7, "line 4: of_log = 7: allowed is the number of a log, 0 to 1"},
      {3, "/of_log", -1, "of_log = -1: allowed is a whole number from 0 to 2^50"},
      {3, "/of_log", uint64_t{1} << 63, "of_log = 9223372036854775808: allowed is a whole"},
      {4, "/of_log", "0", "of_log = \"0\": allowed is a whole number"},
      {3, "/index_end", 0, "index_end = 0: allowed is more than index_begin, 0"},
      {3, "/carried", {-1}, "carried = -1: allowed is a whole number"},
      {3, "/frames", 1e18, "frames = 1e+18: allowed is a whole number"},
      {3, "/input", "x", "input = \"x\": allowed is 16 hexadecimal digits"},
  };
  for (const auto& [line, field, value, error] : kCases) {
    EXPECT_THAT(ErrorWith(line, field, value), HasSubstr(error)) << field;
  }
  for (size_t line = 0; line < 4; ++line) {
    for (const auto& [field, value] : lines_[line].items()) {
      if (field == "sprout_batch" || field == "log" || field == "shard") continue;
      EXPECT_THAT(ErrorWithout(line, field), HasSubstr(field + " = nothing: allowed is ")) << line;
    }
  }
}

TEST(Manifest, IsARegularFile) {
  const TemporaryDirectory folder;
  for (const fs::path& path : {folder / "", fs::path("/dev/zero")}) {
    EXPECT_THAT(ErrorOf<ConfigError>([&] { ReadManifest(path); }),
                HasSubstr(path.string() + ": cannot be read (no regular file): no batch here"));
  }
}

TEST_F(ForeignManifest, SaysWhichShardItLacks) {
  EXPECT_EQ(ReadShard(path_, 1).log.name, "y");
  EXPECT_THAT(ErrorOf<ConfigError>([&] { ReadShard(path_, 2); }), HasSubstr("has no shard 2"));
  std::vector<Json> lines = lines_;
  lines[4]["of_log"] = 2;
  ErrorOfLines(lines);
  EXPECT_THAT(ErrorOf<ConfigError>([&] { ReadShard(path_, 1); }), HasSubstr("of_log = 2"));
}

// A result as a shard leaves it.
class AResult : public testing::Test {
 protected:
  void SetUp() override {
    ResultFolder result(path_);
    WriteTable(result / "measures.csv", {.columns = {"seq", "utime"}, .rows = {{1, 2}}});
    WriteFile(result / "grow.lcm", std::string(1000, 'x'));
    result.Commit();
  }

  void Flip(const char* name) const {
    std::string bytes = TextOf(path_ / name);
    bytes[bytes.size() / 2] ^= 1;
    WriteFile(path_ / name, bytes);
  }

  TemporaryDirectory folder_;
  fs::path path_ = folder_ / "result";
};

TEST_F(AResult, IsWholeAsItWasWritten) {
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kQuick));
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kAll));
  EXPECT_FALSE(IsWhole(folder_ / "none", ResultCheck::kQuick));
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(AResult, IsNotWholeWhenAFileIsCutOrGone) {
  fs::resize_file(path_ / "grow.lcm", 500);
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
  fs::remove(path_ / "grow.lcm");
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
}

TEST_F(AResult, IsNotWholeWhenABitIsFlipped) {
  Flip("grow.lcm");
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kQuick));  // the bytes of logs are not read
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kAll));
  MarkDamaged(path_);
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
}

TEST_F(AResult, IsNotWholeWhenABitOfATableOrOfTheListIsFlipped) {
  Flip("measures.csv");
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
  Flip("measures.csv");
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kQuick));
  Flip("files.txt");
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
}

TEST_F(AResult, IsReplacedWhenItIsDamagedAndKeptWhenNot) {
  const auto write_again = [&] {
    ResultFolder again(path_);
    WriteFile(again / "grow.lcm", "new");
    again.Commit();
  };
  write_again();
  EXPECT_THAT(TextOf(path_ / "grow.lcm"), SizeIs(1000));
  Flip("grow.lcm");
  write_again();
  EXPECT_EQ(TextOf(path_ / "grow.lcm"), "new");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST(MadeFrom, TellsAFileThatWasCut) {
  const TemporaryDirectory folder;
  WriteFile(folder / "merged.lcm", "12345");
  EXPECT_FALSE(IsMadeFrom(folder / "merged.lcm", "source"));
  MarkMadeFrom(folder / "merged.lcm", "source");
  EXPECT_TRUE(IsMadeFrom(folder / "merged.lcm", "source"));
  EXPECT_FALSE(IsMadeFrom(folder / "merged.lcm", "other"));
  fs::resize_file(folder / "merged.lcm", 4);
  EXPECT_FALSE(IsMadeFrom(folder / "merged.lcm", "source"));
  fs::remove(folder / "merged.lcm");
  EXPECT_FALSE(IsMadeFrom(folder / "merged.lcm", "source"));
}

TEST(Tables, AreRefusedWhenTheyAreNotOfFrames) {
  const TemporaryDirectory folder;
  const fs::path path = folder / "t.csv";
  const auto error_of = [&](const std::string& text) {
    WriteFile(path, text);
    return ErrorOf<LogError>([&] { ReadTable(path, {"x"}); });
  };
  EXPECT_EQ(error_of("seq,utime,x\n1,2,3\n"), "no error");
  EXPECT_THAT(error_of(""), HasSubstr("t.csv: cannot be read"));
  EXPECT_THAT(error_of("seq\n1\n"), HasSubstr("has other columns"));
  EXPECT_THAT(error_of("seq,utime,x\n1,2\n"), HasSubstr("a row has missing cells"));
  EXPECT_THAT(error_of("seq,utime,x\n1,,3\n"), HasSubstr("a row has no seq or utime"));
  EXPECT_THAT(error_of("seq,utime,x\n1,2,inf\n"), HasSubstr("'inf' is no finite number"));
}

TEST(StageRuns, AreRefusedWhenAStageIsMissingOrACountCannotBe) {
  const TemporaryDirectory folder;
  WriteStageRuns(folder / "run.json", {{"prior", {.frames_in = 3, .seconds = 0.5}}});
  EXPECT_EQ(ReadStageRuns(folder / "run.json", {"prior"}).at("prior").frames_in, 3);
  EXPECT_THAT(ErrorOf<LogError>([&] {
                ReadStageRuns(folder / "run.json", {"prior", "grow"});
              }),
              HasSubstr("run.json: grow = nothing: allowed is an object"));
  WriteStageRuns(folder / "run.json", {{"prior", {.frames_in = -3}}});
  EXPECT_THAT(ErrorOf<LogError>([&] { ReadStageRuns(folder / "run.json", {"prior"}); }),
              HasSubstr("in = -3: allowed is a whole number"));
}

}  // namespace
}  // namespace sprout::batch
