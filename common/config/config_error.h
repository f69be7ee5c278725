#pragma once

#include <stdexcept>

namespace sprout {

/// A flag, file or configuration value that cannot be used. what() is one line that names key,
/// value and what is allowed. Programs end with exit code 2.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace sprout
