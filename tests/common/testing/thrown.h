#pragma once

#include <functional>
#include <string>

#include "common/core/result.h"

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

/// The error of a result; empty: there is none.
template <typename T>
std::string WhyNot(const Result<T>& result) {
  return result ? "" : result.error().text;
}

}  // namespace sprout
