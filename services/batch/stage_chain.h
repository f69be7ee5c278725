#ifndef SPROUT_SERVICES_BATCH_STAGE_CHAIN_H_
#define SPROUT_SERVICES_BATCH_STAGE_CHAIN_H_

#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/frame.h"

namespace sprout::batch {

/// The stages of a batch, in the order of the graph: "refine", "prior", "grow", "temporal", without
/// a gap.
using StageNames = std::vector<std::string>;

/// Reads "refine,prior,grow", "grow", ...
/// @throws ConfigError for other names, a gap or another order.
StageNames ParseStages(const std::string& flag, const std::vector<std::string>& names);

/// What a stage always answers.
Part AnswerOf(const std::string& stage);

/// What a chain of stages takes from a log.
struct ChainInputs {
  PartSet first;  ///< inputs of the first stage: a frame is answered when these have come
  PartSet all;    ///< what any of them takes from the log
  /// Whether the first stage waits for everything that later ones take from the log. Only then no
  /// message of a frame is pending once the first stage has answered it.
  bool first_has_all = false;
  bool has_memory = false;  ///< a frame's answer depends on all frames before it

  bool operator==(const ChainInputs&) const = default;
};
ChainInputs InputsOf(const StageNames& stages, const SproutConfig& config);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_STAGE_CHAIN_H_
