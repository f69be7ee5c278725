#ifndef SPROUT_SERVICES_BATCH_JSON_FIELDS_H_
#define SPROUT_SERVICES_BATCH_JSON_FIELDS_H_

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace sprout::batch {

// Members of a JSON object from an untrusted file. All throw ConfigError that names field, value
// and what is allowed.

/// Largest count, size or position.
inline constexpr int64_t kMostOfAnything = int64_t{1} << 50;

/// @throws ConfigError that names a field when `holds` is false.
void RequireField(bool holds, const std::string& field, const std::string& value,
                  const std::string& allowed);

/// A whole number, 0 to kMostOfAnything.
int64_t CountIn(const nlohmann::json& json, const std::string& field);

/// Any whole number.
int64_t IntegerIn(const nlohmann::json& json, const std::string& field);

/// A finite number, 0 or more.
double DurationIn(const nlohmann::json& json, const std::string& field);

bool FlagIn(const nlohmann::json& json, const std::string& field);

/// UTF-8 without control characters.
std::string TextIn(const nlohmann::json& json, const std::string& field);
std::vector<std::string> TextsIn(const nlohmann::json& json, const std::string& field);

/// Absolute path.
std::string PathIn(const nlohmann::json& json, const std::string& field);

/// A digest as returned by Digest().
std::string DigestIn(const nlohmann::json& json, const std::string& field);

/// An array or an object.
const nlohmann::json& ArrayIn(const nlohmann::json& json, const std::string& field);
const nlohmann::json& ObjectIn(const nlohmann::json& json, const std::string& field);

/// A line of JSON that is an object. @throws ConfigError.
nlohmann::json ParseObject(const std::string& line);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_JSON_FIELDS_H_
