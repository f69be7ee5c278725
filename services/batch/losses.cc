#include "services/batch/losses.h"

#include <algorithm>
#include <map>

#include "services/batch/shard_run.h"
#include "services/batch/shard_try.h"
#include "services/batch/stage_run.h"

namespace sprout::batch {
namespace {

Losses::OfVariant LossesOf(const StageRuns& runs, const StageNames& stages, const Shard& shard) {
  Losses::OfVariant losses;
  const StageRun& last = runs.at(stages.back());
  losses.unanswered = std::max<int64_t>(0, shard.frames - last.frames_out);
  losses.empty = last.degenerate;
  // An image goes to every stage, and each refuses it.
  for (const auto& [stage, run] : runs) losses.refused = std::max(losses.refused, run.bad_messages);
  return losses;
}

void Add(Losses::OfVariant& sum, const Losses::OfVariant& other) {
  sum.unanswered += other.unanswered;
  sum.empty += other.empty;
  sum.refused += other.refused;
}

Losses OfInput(const BatchLog& log, size_t variants) {
  Losses losses;
  losses.incomplete = log.incomplete;
  losses.left_out = log.left_out;
  losses.undecodable = log.summary.undecodable;
  losses.damaged_bytes = log.summary.damaged_bytes;
  losses.variants.resize(variants);
  return losses;
}

}  // namespace

void Losses::Add(const Losses& other) {
  for (const auto member :
       {&Losses::shards, &Losses::retried, &Losses::failed, &Losses::untried, &Losses::frames,
        &Losses::incomplete, &Losses::left_out, &Losses::undecodable, &Losses::damaged_bytes}) {
    this->*member += other.*member;
  }
  variants.resize(std::max(variants.size(), other.variants.size()));
  for (size_t i = 0; i < other.variants.size(); ++i) batch::Add(variants[i], other.variants[i]);
}

bool Losses::Any() const {
  const bool in_variants = std::any_of(variants.begin(), variants.end(), [](const OfVariant& v) {
    return v.unanswered + v.empty + v.refused > 0;
  });
  return in_variants || frames == 0 ||
         retried + failed + untried + incomplete + left_out + undecodable + damaged_bytes > 0;
}

std::vector<Losses> LossesOf(const BatchFolder& folder, const Manifest& manifest,
                             const BatchState& state) {
  const BatchHead& head = manifest.head;
  std::vector<Losses> losses;
  for (const BatchLog& log : manifest.logs) losses.push_back(OfInput(log, head.variants.size()));
  const std::map<size_t, int64_t> tries = FailedTries(folder);
  for (size_t i = 0; i < manifest.shards.size(); ++i) {
    const Shard& shard = manifest.shards[i];
    Losses& of_log = losses[static_cast<size_t>(shard.log)];
    ++of_log.shards;
    of_log.frames += shard.frames;
    if (!state.done[i]) {
      ++(tries.contains(i) ? of_log.failed : of_log.untried);
      continue;
    }
    if (tries.contains(i)) ++of_log.retried;
    for (size_t v = 0; v < head.variants.size(); ++v) {
      const auto run = folder.result(ResultKey(head, head.variants[v], shard)) / kRuns;
      Add(of_log.variants[v], LossesOf(ReadStageRuns(run, head.stages), head.stages, shard));
    }
  }
  return losses;
}

}  // namespace sprout::batch
