#include "services/batch/manifest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/core/digest.h"
#include "common/logfile/log_error.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kFormat = 1;

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
  return {{"sprout_batch", kFormat},         {"stages", head.stages}, {"keep", head.keep},
          {"channel_prefix", head.prefix},   {"truth", head.truth},   {"tables", head.tables},
          {"shard_bytes", head.shard_bytes}, {"variants", variants}};
}

BatchHead HeadFrom(const Json& json) {
  if (json.value("sprout_batch", 0) != kFormat) throw ConfigError("not of this version");
  BatchHead head{.stages = json.at("stages"),
                 .keep = json.at("keep"),
                 .prefix = json.at("channel_prefix"),
                 .shard_bytes = json.at("shard_bytes"),
                 .truth = json.at("truth"),
                 .tables = json.at("tables"),
                 .variants = {}};
  for (const Json& item : json.at("variants")) {
    Variant variant{
        .name = item.at("name"), .config_digest = item.at("config_digest"), .programs = {}};
    for (const auto& [stage, program] : item.at("programs").items()) {
      variant.programs[stage] = {.path = program.at("path"),
                                 .digest = program.at("digest"),
                                 .version = program.at("version")};
    }
    head.variants.push_back(std::move(variant));
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
  return {.path = json.at("log"),
          .name = json.at("name"),
          .index = json.at("index"),
          .summary = IndexSummaryFrom(json),
          .incomplete = json.at("incomplete"),
          .left_out = json.at("left_out")};
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

Shard ShardFrom(const Json& json) {
  return {.log = json.at("of_log"),
          .begin = json.at("index_begin"),
          .end = json.at("index_end"),
          .carried = json.at("carried"),
          .frames = json.at("frames"),
          .first_seq = json.at("first_seq"),
          .last_seq = json.at("last_seq"),
          .bytes = json.at("bytes"),
          .input = json.at("input")};
}

// Reads a manifest until `wants_shard`, which gets each shard's number and line, says to stop.
Manifest ReadLines(const fs::path& path,
                   const std::function<bool(size_t, const std::string&)>& wants_shard) {
  std::ifstream file(path);
  if (!file) throw ConfigError(path.string() + ": no batch here; sprout-batch run begins one");
  Manifest manifest;
  std::string line;
  size_t shards = 0;
  try {
    std::getline(file, line);
    manifest.head = HeadFrom(Json::parse(line));
    while (std::getline(file, line)) {
      if (line.find("\"log\":") != std::string::npos) {
        manifest.logs.push_back(LogFrom(Json::parse(line)));
      } else if (!wants_shard(shards++, line)) {
        break;
      }
    }
  } catch (const std::exception& e) {
    throw ConfigError(path.string() + ": the manifest cannot be used (" + e.what() +
                      "); remove it, results are kept");
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
  return Sharded(root_ / "comparisons", key) + ".csv";
}

std::string ResultKey(const BatchHead& head, const Variant& variant, const Shard& shard) {
  std::string text =
      fmt::format("result {} {} {} {} {} {}", kFormat, shard.input, variant.config_digest,
                  fmt::join(head.keep, ","), head.prefix, head.tables);
  for (const std::string& stage : head.stages) {
    text += " " + stage + " " + variant.programs.at(stage).digest;
  }
  return Digest(text);
}

std::string ComparisonKey(const BatchHead& head, const BatchLog& log, const Shard& shard) {
  std::string text = fmt::format("comparison {} {}", kFormat, head.truth);
  if (!head.truth.empty()) text += " " + log.name;
  for (const Variant& variant : head.variants) text += " " + ResultKey(head, variant, shard);
  return Digest(text);
}

bool Compares(const BatchHead& head) {
  return head.keep.back() == "grow" && (head.variants.size() > 1 || !head.truth.empty());
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
  Manifest manifest = ReadLines(path, [&](size_t, const std::string& line) {
    shards.push_back(ShardFrom(Json::parse(line)));
    return true;
  });
  manifest.shards = std::move(shards);
  return manifest;
}

ShardOfBatch ReadShard(const fs::path& path, size_t number) {
  std::optional<Shard> shard;
  Manifest manifest = ReadLines(path, [&](size_t at, const std::string& line) {
    if (at == number) shard = ShardFrom(Json::parse(line));
    return at != number;
  });
  if (!shard) throw ConfigError(fmt::format("{}: has no shard {}", path.string(), number));
  return {.head = std::move(manifest.head),
          .log = manifest.logs.at(static_cast<size_t>(shard->log)),
          .shard = std::move(*shard)};
}

}  // namespace sprout::batch
