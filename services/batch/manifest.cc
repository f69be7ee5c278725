#include "services/batch/manifest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/core/read_text.h"
#include "common/logfile/log_error.h"
#include "services/batch/json_fields.h"
#include "services/batch/names.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kManifestFormat = 1;

Json ToJson(const BatchHead& head) {
  Json variants = Json::array();
  for (const Variant& variant : head.variants) {
    Json programs = Json::object();
    for (const auto& [stage, program] : variant.programs) {
      programs[stage] = {
          {"path", program.path}, {"digest", program.digest}, {"version", program.version}};
    }
    variants.push_back(
        {{"name", variant.name}, {"config_digest", variant.config_digest}, {"programs", programs}});
  }
  return {{"sprout_batch", kManifestFormat},
          {"stages", head.stages},
          {"keep", head.keep},
          {"channel_prefix", head.prefix},
          {"truth", head.truth},
          {"tables", head.tables},
          {"shard_bytes", head.shard_bytes},
          {"left_out_logs", head.left_out},
          {"measured", head.measured},
          {"variants", variants}};
}

StageNames StagesIn(const Json& json) {
  StageNames stages = TextsIn(json, "stages");
  (void)ParseStages("stages", stages);
  return stages;
}

StageNames KeepIn(const Json& json, const StageNames& stages) {
  const StageNames keep = TextsIn(json, "keep");
  StageNames in_order;
  for (const std::string& stage : stages) {
    if (std::find(keep.begin(), keep.end(), stage) != keep.end()) in_order.push_back(stage);
  }
  const bool holds = !keep.empty() && keep == in_order && keep.back() == stages.back();
  RequireField(holds, "keep", fmt::format("[{}]", fmt::join(keep, ",")),
               "stages of the batch in their order, the last one among them");
  return keep;
}

Variant VariantFrom(const Json& json, const std::string& name, const StageNames& stages) {
  if (!json.is_object()) throw ConfigError("variants: allowed are objects");
  Variant variant{.name = TextIn(json, "name"),
                  .config_digest = DigestIn(json, "config_digest"),
                  .programs = {}};
  RequireField(variant.name == name, "name", variant.name, name + " here");
  const Json& programs = ObjectIn(json, "programs");
  for (const std::string& stage : stages) {
    const Json& program = ObjectIn(programs, stage);
    variant.programs[stage] = {.path = PathIn(program, "path"),
                               .digest = DigestIn(program, "digest"),
                               .version = TextIn(program, "version")};
  }
  return variant;
}

BatchHead HeadFrom(const Json& json) {
  if (json.value("sprout_batch", Json()) != kManifestFormat)
    throw ConfigError("not of this version");
  BatchHead head;
  head.stages = StagesIn(json);
  head.keep = KeepIn(json, head.stages);
  head.prefix = TextIn(json, "channel_prefix");
  RequireField(IsChannelPrefix(head.prefix), "channel_prefix", head.prefix, AllowedChannelPrefix());
  head.shard_bytes = CountIn(json, "shard_bytes");
  RequireField(head.shard_bytes > 0, "shard_bytes", "0", "1 or more");
  head.measured = FlagIn(json, "measured");
  head.truth = TextIn(json, "truth");
  head.tables = DigestIn(json, "tables");
  head.left_out = TextsIn(json, "left_out_logs");
  const Json& variants = ArrayIn(json, "variants");
  RequireField(variants.size() == 1 || variants.size() == 2, "variants",
               std::to_string(variants.size()), "one or two");
  for (size_t i = 0; i < variants.size(); ++i) {
    head.variants.push_back(VariantFrom(variants[i], i == 0 ? "a" : "b", head.stages));
  }
  return head;
}

Json ToJson(const BatchLog& log) {
  Json json = ToJson(log.summary);
  json["log"] = log.path;
  json["name"] = log.name;
  json["index"] = log.index;
  json["incomplete"] = log.incomplete;
  json["left_out"] = log.left_out;
  return json;
}

BatchLog LogFrom(const Json& json) {
  BatchLog log{.path = PathIn(json, "log"),
               .name = TextIn(json, "name"),
               .index = PathIn(json, "index"),
               .summary = IndexSummaryFrom(json),
               .incomplete = CountIn(json, "incomplete"),
               .left_out = CountIn(json, "left_out")};
  RequireField(IsResultName(log.name), "name", log.name,
               "a file name of up to 200 bytes without comma or quote");
  return log;
}

Json ToJson(const Shard& shard, size_t number) {
  return {{"shard", number},
          {"of_log", shard.log},
          {"index_begin", shard.begin},
          {"index_end", shard.end},
          {"carried", shard.carried},
          {"frames", shard.frames},
          {"first_seq", shard.first_seq},
          {"last_seq", shard.last_seq},
          {"bytes", shard.bytes},
          {"input", shard.input}};
}

// @param logs  number of logs of the manifest. @param last_log  of the shard before.
Shard ShardFrom(const Json& json, size_t logs, int64_t last_log) {
  Shard shard{.log = CountIn(json, "of_log"),
              .begin = CountIn(json, "index_begin"),
              .end = CountIn(json, "index_end"),
              .carried = {},
              .frames = CountIn(json, "frames"),
              .first_seq = IntegerIn(json, "first_seq"),
              .last_seq = IntegerIn(json, "last_seq"),
              .bytes = CountIn(json, "bytes"),
              .input = DigestIn(json, "input")};
  RequireField(
      shard.log >= last_log && shard.log < static_cast<int64_t>(logs), "of_log",
      std::to_string(shard.log),
      fmt::format("the number of a log, {} to {}", last_log, static_cast<int64_t>(logs) - 1));
  RequireField(shard.begin < shard.end, "index_end", std::to_string(shard.end),
               fmt::format("more than index_begin, {}", shard.begin));
  for (const Json& line : ArrayIn(json, "carried")) {
    shard.carried.push_back(CountIn({{"carried", line}}, "carried"));
  }
  return shard;
}

// Gets each shard's line, and its number. @returns whether to go on.
using TakeShard = std::function<bool(const Manifest&, size_t, const std::string&)>;

void AddLog(const std::string& line, Manifest& manifest, std::set<std::string>& names) {
  BatchLog log = LogFrom(ParseObject(line));
  RequireField(names.insert(log.name).second, "name", log.name, "one that no other log has");
  manifest.logs.push_back(std::move(log));
}

// Reads a manifest, which may come from anywhere, until `take` says to stop.
Manifest ReadLines(const fs::path& path, const TakeShard& take) {
  const Result<std::string> text = ReadText(path, kMaxListBytes);
  if (!text) {
    throw ConfigError(path.string() + ": " + text.error().text +
                      ": no batch here; sprout-batch run begins one");
  }
  std::istringstream file(*text);
  Manifest manifest;
  std::set<std::string> names;
  std::string line;
  size_t number = 0;  // of the line
  try {
    std::getline(file, line);
    manifest.head = HeadFrom(ParseObject(line));
    for (size_t shards = 0; ++number, std::getline(file, line);) {
      if (line.find("\"log\":") != std::string::npos) {
        AddLog(line, manifest, names);
      } else if (!take(manifest, shards++, line)) {
        break;
      }
    }
  } catch (const std::exception& e) {
    throw ConfigError(
        fmt::format("{}: the manifest cannot be used (line {}: {}); remove it, results are kept",
                    path.string(), number + 1, e.what()));
  }
  return manifest;
}

std::string Sharded(const fs::path& folder, const std::string& key) {
  return (folder / key.substr(0, 2) / key).string();
}

}  // namespace

std::vector<size_t> Manifest::ShardsOf(size_t log) const {
  const auto before = [](const Shard& shard, size_t number) {
    return static_cast<size_t>(shard.log) < number;
  };
  const auto first = std::lower_bound(shards.begin(), shards.end(), log, before);
  const auto last = std::lower_bound(first, shards.end(), log + 1, before);
  std::vector<size_t> numbers;
  for (auto shard = first; shard != last; ++shard) {
    numbers.push_back(static_cast<size_t>(shard - shards.begin()));
  }
  return numbers;
}

fs::path BatchFolder::result(const std::string& key) const {
  return Sharded(root_ / "results", key);
}

fs::path BatchFolder::comparison(const std::string& key) const {
  return Sharded(root_ / "comparisons", key);
}

std::string ResultKey(const BatchHead& head, const Variant& variant, const Shard& shard) {
  std::string text = fmt::format("result {} {} {} {} {} {} {}", kManifestFormat, shard.input,
                                 variant.config_digest, fmt::join(head.keep, ","), head.prefix,
                                 head.tables, head.measured);
  for (const std::string& stage : head.stages) {
    text += " " + stage + " " + variant.programs.at(stage).digest;
  }
  return Digest(text);
}

std::string ComparisonKey(const BatchHead& head, const BatchLog& log, const Shard& shard) {
  std::string text = fmt::format("comparison {} {}", kManifestFormat, head.truth);
  if (!head.truth.empty()) text += " " + log.name;
  for (const Variant& variant : head.variants) text += " " + ResultKey(head, variant, shard);
  return Digest(text);
}

bool Compares(const BatchHead& head) {
  const Part answer = AnswerOf(head.keep.back());
  const bool is_map = answer == Part::kDisparity || answer == Part::kFused;
  return is_map && (head.variants.size() > 1 || !head.truth.empty());
}

void WriteManifest(const fs::path& path, const Manifest& manifest) {
  OutputFile file(path);
  file.Write(ToJson(manifest.head).dump() + "\n");
  for (const BatchLog& log : manifest.logs) file.Write(ToJson(log).dump() + "\n");
  for (size_t i = 0; i < manifest.shards.size(); ++i) {
    file.Write(ToJson(manifest.shards[i], i).dump() + "\n");
  }
  CommitFile(path, file);
}

Manifest ReadManifest(const fs::path& path) {
  std::vector<Shard> shards;
  Manifest manifest = ReadLines(path, [&](const Manifest& head, size_t, const std::string& line) {
    const int64_t last_log = shards.empty() ? 0 : shards.back().log;
    shards.push_back(ShardFrom(ParseObject(line), head.logs.size(), last_log));
    return true;
  });
  manifest.shards = std::move(shards);
  return manifest;
}

ShardOfBatch ReadShard(const fs::path& path, size_t number) {
  std::optional<Shard> shard;
  Manifest manifest =
      ReadLines(path, [&](const Manifest& head, size_t at, const std::string& line) {
        if (at == number) shard = ShardFrom(ParseObject(line), head.logs.size(), 0);
        return at != number;
      });
  if (!shard) throw ConfigError(fmt::format("{}: has no shard {}", path.string(), number));
  return {.head = std::move(manifest.head),
          .log = manifest.logs.at(static_cast<size_t>(shard->log)),
          .shard = std::move(*shard)};
}

}  // namespace sprout::batch
