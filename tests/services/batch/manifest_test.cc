// Manifests that were changed by somebody else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "common/core/digest.h"
#include "services/batch/planning.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/batch/error_of.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

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

}  // namespace
}  // namespace sprout::batch
