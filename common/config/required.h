#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/result.h"

namespace sprout {

/// The value of a result whose input a user has named.
/// @param what  goes before the reason: "--bits ".
/// @throws ConfigError when there is no value.
template <typename T>
T Required(Result<T> result, const std::string& what = "") {
  if (!result) throw ConfigError(what + result.error().text);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace sprout
