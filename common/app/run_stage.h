#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "common/core/stage_adapter.h"

namespace sprout {

/// Creates the adapter of a stage from the effective configuration.
using MakeAdapter = std::function<std::unique_ptr<StageAdapter>(const SproutConfig&)>;

/// The whole main of a service with one adapter: runs it live until a signal comes, or on logs
/// (--replay).
/// @param program  see Service.
int RunStage(int argc, char** argv, const std::string& stage, const std::string& description,
             const MakeAdapter& make_adapter, const std::string& program = "");

}  // namespace sprout
