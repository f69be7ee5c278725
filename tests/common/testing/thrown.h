#pragma once

#include <functional>
#include <string>

namespace sprout {

/// The text of an exception of this type that an action throws; else "no error".
template <typename Error>
std::string Thrown(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace sprout
