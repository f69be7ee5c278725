#ifndef SPROUT_SERVICES_TOOLS_LOG_DAMAGE_TEXT_H_
#define SPROUT_SERVICES_TOOLS_LOG_DAMAGE_TEXT_H_

#include <filesystem>
#include <string>
#include <vector>

#include "common/logfile/log_reader.h"

namespace sprout::log {

/// One line for a stretch of damage: "bytes 100-163 (64): 1 event lost".
std::string DamageText(const LogDamage& damage);

/// Warns on stderr, in one line, when a log was damaged: for subcommands that continue.
void WarnOfDamage(const std::filesystem::path& path, const std::vector<LogDamage>& damage);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_DAMAGE_TEXT_H_
