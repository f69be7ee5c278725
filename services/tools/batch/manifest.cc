#include "services/tools/batch/manifest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/core/output_file.h"
#include "common/core/printable.h"
#include "common/core/read_text.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/planning.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

const std::vector<std::string> kGraph = {"refine", "prior", "grow", "temporal"};

constexpr size_t kShownLetters = 60;  // of a value that is refused

void Require(bool holds, const std::string& field, const std::string& value,
             const std::string& allowed) {
  if (holds) return;
  throw ConfigError(fmt::format("{} = '{}': allowed is {}", field,
                                Printable(Shortened(value, kShownLetters)), allowed));
}

// Requires that all texts of a message and of those in it are plain.
void RequirePlainTexts(const Message& message) {
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        RequirePlainTexts(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                               : reflection.GetMessage(message, field));
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
        const std::string text = field->is_repeated()
                                     ? reflection.GetRepeatedString(message, field, i)
                                     : reflection.GetString(message, field);
        Require(IsPlainText(text), field->name(), text, "UTF-8 without control characters");
      }
    }
  }
}

void RequireDigest(const std::string& field, const std::string& digest) {
  const bool holds =
      digest.size() == 16 && digest.find_first_not_of("0123456789abcdef") == std::string::npos;
  Require(holds, field, digest, "16 hexadecimal digits");
}

void RequireAbsolute(const std::string& field, const std::string& path) {
  Require(path.starts_with('/'), field, path, "an absolute path");
}

void RequireValid(const Variant& variant, int stages) {
  RequireDigest("config_digest", variant.config_digest());
  Require(variant.program_size() == stages, "program", std::to_string(variant.program_size()),
          "one for each stage");
  for (const StageProgram& program : variant.program()) {
    RequireAbsolute("path", program.path());
    RequireDigest("digest", program.digest());
  }
}

void RequireValid(const Manifest& manifest) {
  Require(manifest.format() == kManifestFormat, "format", std::to_string(manifest.format()),
          std::to_string(kManifestFormat) + ", that of this version");
  RequirePlainTexts(manifest);
  RequireStages("stage", {manifest.stage().begin(), manifest.stage().end()});
  Require(IsChannelPrefix(manifest.channel_prefix()), "channel_prefix", manifest.channel_prefix(),
          AllowedChannelPrefix());
  RequireDigest("tables", manifest.tables());
  Require(manifest.variant_size() == 1 || manifest.variant_size() == 2, "variant",
          std::to_string(manifest.variant_size()), "one or two");
  for (const Variant& variant : manifest.variant()) RequireValid(variant, manifest.stage_size());
  std::set<std::string> names;
  for (const BatchLog& log : manifest.log()) {
    RequireAbsolute("path", log.path());
    RequireDigest("digest", log.digest());
    Require(IsResultName(log.name()), "name", log.name(),
            "a file name of up to 200 bytes without comma or quote");
    Require(names.insert(log.name()).second, "name", log.name(), "one that no other log has");
  }
}

std::string ResultKey(const Manifest& manifest, int log, int variant) {
  std::string text = fmt::format(
      "result {} {} {} {} {}", kManifestFormat, manifest.log(log).digest(),
      manifest.variant(variant).config_digest(), manifest.channel_prefix(), manifest.tables());
  for (int i = 0; i < manifest.stage_size(); ++i) {
    text += fmt::format(" {} {}", manifest.stage(i), manifest.variant(variant).program(i).digest());
  }
  return Digest(text);
}

// A folder for each two first digits, since some file systems are slow with thousands of entries.
fs::path Grouped(const fs::path& folder, const std::string& key) {
  return folder / key.substr(0, 2) / key;
}

}  // namespace

void RequireStages(const std::string& flag, const std::vector<std::string>& stages) {
  if (!stages.empty() && !std::ranges::search(kGraph, stages).empty()) return;
  throw ConfigError(fmt::format(
      "{} {}: allowed are refine, prior, grow and temporal, one or several that follow each other",
      flag, Printable(fmt::format("{}", fmt::join(stages, ",")))));
}

Part AnswerOf(const std::string& stage) {
  if (stage == "refine") return Part::kSeeds;
  if (stage == "prior") return Part::kPrior;
  return stage == "grow" ? Part::kDisparity : Part::kFused;
}

fs::path BatchFolder::config(int variant) const {
  return root_ / ("config_" + VariantName(variant) + ".textproto");
}

fs::path BatchFolder::answers(const BatchLog& log, int variant) const {
  return root_ / "logs" / (log.name() + "_" + VariantName(variant) + ".lcm");
}

fs::path BatchFolder::result(const Manifest& manifest, int log, int variant) const {
  return Grouped(root_ / "results", ResultKey(manifest, log, variant));
}

fs::path BatchFolder::comparison(const Manifest& manifest, int log) const {
  std::string text = fmt::format("comparison {}", kManifestFormat);
  for (int i = 0; i < manifest.variant_size(); ++i) text += " " + ResultKey(manifest, log, i);
  return Grouped(root_ / "comparisons", Digest(text));
}

bool Compares(const Manifest& manifest) {
  const Part answer = AnswerOf(*manifest.stage().rbegin());
  const bool is_map = answer == Part::kDisparity || answer == Part::kFused;
  return is_map && manifest.variant_size() > 1;
}

Manifest ReadManifest(const fs::path& path) {
  const Result<std::string> text = ReadText(path, kMaxListBytes);
  if (!text) {
    throw ConfigError(path.string() + ": " + text.error().text +
                      ": no batch here; sprout-batch run begins one");
  }
  Manifest manifest;
  try {
    ParseText(*text, "manifest", manifest);
    RequireValid(manifest);
  } catch (const ConfigError& e) {
    throw ConfigError(
        fmt::format("{}: the manifest cannot be used ({}); remove it, results are kept",
                    path.string(), e.what()));
  }
  return manifest;
}

void WriteText(const fs::path& path, const std::string& text) {
  OutputFile file(path);
  file.Write(text);
  if (!file.Commit()) throw LogError(path, "cannot be written (" + file.failure() + ")");
}

std::string FirstLineOf(const fs::path& path) {
  const std::string text = ReadText(path, kMaxListBytes).value_or("");
  return text.substr(0, text.find('\n'));
}

}  // namespace sprout::batch
