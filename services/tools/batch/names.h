#ifndef SPROUT_SERVICES_TOOLS_BATCH_NAMES_H_
#define SPROUT_SERVICES_TOOLS_BATCH_NAMES_H_

#include <filesystem>
#include <set>
#include <string>
#include <string_view>

namespace sprout::batch {

/// Whether a text is allowed in a manifest, in a table and on a page: UTF-8 without control
/// characters. File names may hold any bytes.
bool IsPlainText(std::string_view text);

/// @throws ConfigError that names the flag when `text` is not plain.
void RequirePlainText(const std::string& flag, const std::string& text);

/// Whether a log's results can have this name: plain text that is one part of a path and one cell
/// of a table.
bool IsResultName(std::string_view name);

/// Name of a log's results: its file's name, changed to satisfy IsResultName(), with a number
/// appended if another log has that name.
/// @param log    plain text.
/// @param taken  names of the other logs; the new one is added.
std::string ResultNameOf(const std::filesystem::path& log, std::set<std::string>& taken);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_NAMES_H_
