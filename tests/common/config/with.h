#pragma once

#include <string>

#include "common/config/config.h"

namespace sprout {

/// A part of the configuration as its text says, "scale: 2 every: 3".
/// @param rest  what the text does not say.
/// @throws ConfigError for a text that is none of this part.
template <typename Config>
Config With(const std::string& text, Config rest = {}) {
  Config said;
  ParseText(text, "test", said);
  rest.MergeFrom(said);
  return rest;
}

}  // namespace sprout
