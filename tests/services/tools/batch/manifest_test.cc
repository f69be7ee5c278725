// Manifests that were changed by somebody else.
#include "services/tools/batch/manifest.h"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/tools/batch/example_manifest.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A manifest that is changed here and there.
class ForeignManifest : public testing::Test {
 protected:
  // @returns why the manifest is refused when this text is another; `from` must be in it.
  std::string ErrorWith(const std::string& from, const std::string& to) const {
    std::string text = ConfigText(ExampleManifest());
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return ErrorOfText(text);
  }

  std::string ErrorOfText(const std::string& text) const {
    std::ofstream(path_) << text;
    return Thrown<ConfigError>([&] { ReadManifest(path_); });
  }

  TemporaryDirectory folder_;
  fs::path path_ = folder_ / "manifest.textproto";
};

TEST_F(ForeignManifest, IsTakenAsItWasWritten) {
  EXPECT_EQ(ErrorOfText(ConfigText(ExampleManifest())), "no error");
  EXPECT_EQ(ConfigText(ReadManifest(path_)), ConfigText(ExampleManifest()));
}

TEST_F(ForeignManifest, IsRefusedWithTheFieldItsValueAndWhatIsAllowed) {
  const struct {
    const char* from;
    const char* to;
    const char* error;
  } kCases[] = {
      {"format: 2", "format: 1", "format = '1': allowed is 2, that of this version"},
      {"stage: \"prior\"\n", "", "program = '2': allowed is one for each stage"},
      {"stage: \"prior\"\nstage: \"grow\"", "stage: \"grow\"\nstage: \"prior\"",
       "stage grow,prior: allowed are refine, prior, grow and temporal"},
      {"stage: \"prior\"\nstage: \"grow\"", "", "stage : allowed are refine, prior"},
      {"channel_prefix: \"\"", "channel_prefix: \"'; x\"",
       "channel_prefix = ''; x': allowed is up to "},
      {"tables: \"", "tables: \"../", "tables = '../"},
      {"format: ", "format: x", "manifest:"},
      {"config_digest: \"", "config_digest: \"<b>", "allowed is 16 hexadecimal digits"},
      {"path: \"/bin/sprout-prior\"", "path: \"sprout-prior\"",
       "path = 'sprout-prior': allowed is an absolute path"},
      {"program {", "program { } program {", "program = '3': allowed is one for each stage"},
      {"version: \"", "version: \"a\\nb", "version = 'a\\x0ab"},
      {"name: \"x\"", "name: \"../../victim\"",
       "name = '../../victim': allowed is a file name of up to"},
      {"name: \"x\"", "name: \"\"", "name = '': allowed is a file name"},
      {"name: \"x\"", "name: \"..\"", "name = '..': allowed is a file name"},
      {"name: \"x\"", "name: \"a,b\"", "name = 'a,b': allowed is a file name"},
      {"name: \"x\"", "name: \"y\"", "name = 'y': allowed is one that no other log has"},
      {"path: \"/logs/x.lcm\"", "path: \"x.lcm\"", "path = 'x.lcm': allowed is an absolute path"},
      {"path: \"/logs/x.lcm\"", "path: \"/x\\377.lcm\"", "path = '/x\\xff.lcm': allowed is UTF-8"},
      {"log {", "shard {", "no field named \"shard\""},
  };
  for (const auto& [from, to, error] : kCases) {
    EXPECT_THAT(ErrorWith(from, to), HasSubstr(error)) << from << " -> " << to;
  }
  EXPECT_THAT(ErrorOfText("format: 2"), HasSubstr("stage : allowed are refine"));
}

TEST_F(ForeignManifest, HasOneOrTwoVariants) {
  Manifest manifest = ExampleManifest();
  *manifest.add_variant() = manifest.variant(0);
  EXPECT_THAT(ErrorOfText(ConfigText(manifest)), HasSubstr("variant = '3': allowed is one or two"));
  manifest.clear_variant();
  EXPECT_THAT(ErrorOfText(ConfigText(manifest)), HasSubstr("variant = '0': allowed is one or two"));
}

TEST(Manifest, IsARegularFile) {
  const TemporaryDirectory folder;
  for (const fs::path& path : {folder / "", fs::path("/dev/zero")}) {
    EXPECT_THAT(Thrown<ConfigError>([&] { ReadManifest(path); }),
                HasSubstr(path.string() + ": cannot be read (no regular file): no batch here"));
  }
}

TEST(Stages, AreRefusedWithGapsAndWhenUnknown) {
  EXPECT_THROW(RequireStages("--stages", {"refine", "grow"}), ConfigError);
  EXPECT_THROW(RequireStages("--stages", {"depth"}), ConfigError);
  EXPECT_NO_THROW(RequireStages("--stages", {"prior", "grow"}));
}

// The name of a result depends on all that may change it, and on nothing else.
TEST(Results, AreNamedByAllThatDecidesThem) {
  const BatchFolder folder("/out");
  const Manifest before = ExampleManifest();
  const auto name_of = [&](const Manifest& manifest) { return folder.result(manifest, 0, 0); };
  const auto with = [&](auto change) {
    Manifest manifest = before;
    change(manifest);
    return name_of(manifest);
  };
  EXPECT_NE(folder.result(before, 1, 0), name_of(before));
  EXPECT_NE(folder.result(before, 0, 1), name_of(before));
  EXPECT_NE(with([](Manifest& m) { m.mutable_log(0)->set_digest(Digest("other")); }),
            name_of(before));
  EXPECT_NE(with([](Manifest& m) {
              m.mutable_variant(0)->mutable_program(1)->set_digest(Digest("other"));
            }),
            name_of(before));
  EXPECT_NE(with([](Manifest& m) { m.mutable_variant(0)->set_config_digest(Digest("other")); }),
            name_of(before));
  EXPECT_NE(with([](Manifest& m) { m.set_channel_prefix("A_"); }), name_of(before));
  EXPECT_NE(with([](Manifest& m) { m.set_tables(Digest("other")); }), name_of(before));
  EXPECT_EQ(with([](Manifest& m) {
              m.mutable_log(0)->set_path("/moved.lcm");
              m.mutable_variant(0)->mutable_program(0)->set_path("/moved/sprout-prior");
              m.mutable_variant()->RemoveLast();
            }),
            name_of(before));
}

}  // namespace
}  // namespace sprout::batch
