#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// The options of a run.
struct BatchRequest {
  std::vector<std::string> inputs;  ///< logs, folders of logs (*.lcm), @LIST files
  std::string out;
  std::vector<std::string> stages = {"refine", "prior", "grow"};
  std::vector<std::string> config_a;  ///< as --config of the services
  std::vector<std::string> config_b;  ///< empty: that of A, if there is a B
  std::string programs_b;             ///< empty: those of A, if there is a B
  std::string prefix;
};

/// The manifest of a request, written to its folder with the effective configurations. Reads each
/// new or changed log once, for its digest. An equal manifest is kept.
/// @param program  path of sprout-batch; A's stages are beside it.
/// @throws ConfigError, LogError.
Manifest Plan(const BatchRequest& request, const std::string& program);

/// The logs (*.lcm) in a folder and below: absolute paths, sorted. A file with several names (links
/// of either kind) is one log, by the first name that is no symbolic link where there is one.
/// Answers of batches are left out.
/// @throws ConfigError when there is none, or a folder cannot be read.
std::vector<std::string> LogsBelow(const std::filesystem::path& folder);

/// The selected logs: absolute paths, without duplicates, in order.
/// @param inputs  logs, folders of logs, @LIST files with one of these a line.
/// @throws ConfigError for missing inputs, a list that contains itself, and a path that is not
///         allowed in a manifest.
std::vector<std::string> FindLogs(const std::vector<std::string>& inputs);

/// Whether a text is allowed in a manifest, in a table and on a page: UTF-8 without control
/// characters. File names may hold any bytes.
bool IsPlainText(std::string_view text);

/// @throws ConfigError that names what it is, such as a flag, when `text` is not plain.
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
