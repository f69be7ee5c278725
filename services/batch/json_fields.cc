#include "services/batch/json_fields.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/config/config.h"
#include "common/messages/shortened.h"
#include "services/batch/names.h"

namespace sprout::batch {
namespace {

using Json = nlohmann::json;

const Json kMissing = nullptr;

const Json& MemberOf(const Json& json, const std::string& field) {
  const auto found = json.find(field);
  return found == json.end() ? kMissing : *found;
}

std::string ValueText(const Json& value) {
  constexpr size_t kShown = 60;
  if (value.is_null()) return "nothing";
  return Shortened(value.dump(-1, ' ', false, Json::error_handler_t::replace), kShown);
}

bool IsInteger(const Json& value) {
  return value.is_number_integer() &&
         (!value.is_number_unsigned() ||
          value.get<uint64_t>() <= uint64_t{std::numeric_limits<int64_t>::max()});
}

const Json& Checked(bool holds, const std::string& field, const Json& value,
                    const std::string& allowed) {
  RequireField(holds, field, ValueText(value), allowed);
  return value;
}

std::string CheckedText(const Json& value, const std::string& field) {
  constexpr char kAllowed[] = "a text, UTF-8 without control characters";
  Checked(value.is_string(), field, value, kAllowed);
  std::string text = value;
  Checked(IsPlainText(text), field, value, kAllowed);
  return text;
}

}  // namespace

void RequireField(bool holds, const std::string& field, const std::string& value,
                  const std::string& allowed) {
  if (!holds) throw ConfigError(fmt::format("{} = {}: allowed is {}", field, value, allowed));
}

int64_t CountIn(const Json& json, const std::string& field) {
  const Json& value = MemberOf(json, field);
  const bool holds =
      IsInteger(value) && value.get<int64_t>() >= 0 && value.get<int64_t>() <= kMostOfAnything;
  return Checked(holds, field, value, "a whole number from 0 to 2^50");
}

int64_t IntegerIn(const Json& json, const std::string& field) {
  const Json& value = MemberOf(json, field);
  return Checked(IsInteger(value), field, value, "a whole number of 64 bits");
}

double DurationIn(const Json& json, const std::string& field) {
  const Json& value = MemberOf(json, field);
  const bool holds =
      value.is_number() && std::isfinite(value.get<double>()) && value.get<double>() >= 0;
  return Checked(holds, field, value, "a finite number, 0 or more");
}

bool FlagIn(const Json& json, const std::string& field) {
  const Json& value = MemberOf(json, field);
  return Checked(value.is_boolean(), field, value, "true or false");
}

std::string TextIn(const Json& json, const std::string& field) {
  return CheckedText(MemberOf(json, field), field);
}

std::vector<std::string> TextsIn(const Json& json, const std::string& field) {
  std::vector<std::string> texts;
  for (const Json& value : ArrayIn(json, field)) texts.push_back(CheckedText(value, field));
  return texts;
}

std::string PathIn(const Json& json, const std::string& field) {
  std::string path = TextIn(json, field);
  Checked(path.starts_with('/'), field, path, "an absolute path");
  return path;
}

std::string DigestIn(const Json& json, const std::string& field) {
  std::string digest = TextIn(json, field);
  const bool holds =
      digest.size() == 16 && digest.find_first_not_of("0123456789abcdef") == std::string::npos;
  Checked(holds, field, digest, "16 hexadecimal digits");
  return digest;
}

const Json& ArrayIn(const Json& json, const std::string& field) {
  const Json& value = MemberOf(json, field);
  return Checked(value.is_array(), field, value, "an array");
}

const Json& ObjectIn(const Json& json, const std::string& field) {
  const Json& value = MemberOf(json, field);
  return Checked(value.is_object(), field, value, "an object");
}

Json ParseObject(const std::string& line) {
  Json json = Json::parse(line, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) throw ConfigError("a line that is no JSON object");
  return json;
}

}  // namespace sprout::batch
