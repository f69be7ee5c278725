#pragma once

#include <google/protobuf/message.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/config/config_error.h"
#include "common/config/sprout.pb.h"

namespace sprout {

/// Folder of the installed presets: share/sprout/presets beside the bin or lib folder of the
/// program (or the shared library), so that an installed tree can be moved.
std::filesystem::path PresetsFolder();

/// Reads configuration files in protobuf text format and merges them, later ones over earlier
/// ones; without files, all defaults.
///
/// @param files  paths, or names of presets (a name without '/' and '.' stands for
///               NAME.textproto in PresetsFolder()), or, with a '{' in them, such text itself:
///               "grow { sub_pixel: false }".
/// @returns the effective configuration: every field is set.
/// @throws ConfigError for a missing file, a syntax error, an unknown key, a value out of range.
SproutConfig LoadConfig(const std::vector<std::string>& files);

/// Reads a file in protobuf text format into `message`.
///
/// @param what     what is read, for error messages: "configuration".
/// @param allowed  what is allowed, for error messages.
/// @throws ConfigError for a file that cannot be read, a syntax error, an unknown key.
void ParseTextFile(const std::filesystem::path& path, const std::string& what,
                   const std::string& allowed, google::protobuf::Message& message);

/// Parses a text as ParseTextFile() does a file's content.
/// @param name  the text's origin, for error messages.
void ParseText(const std::string& text, const std::string& name,
               google::protobuf::Message& message);

/// Checks every number of a configuration (or a part of one) against the range in its .proto.
/// @throws ConfigError naming the first offending key, as "PREFIX.key".
void RequireInRange(const google::protobuf::Message& config, const std::string& prefix);

/// The configuration as text, in the format that LoadConfig reads; every field is printed.
std::string ConfigText(const google::protobuf::Message& config);

}  // namespace sprout
