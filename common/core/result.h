#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace sprout {

/// Why a frame or a message was refused: one line that names what, where and what is allowed.
struct Error {
  std::string text;
};

/// A value, or the reason why there is none. For data that arrives at run time; a wrong
/// configuration is an exception (ConfigError), a broken invariant an assertion.
template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> Fail(std::string text) {
  return tl::unexpected<Error>(Error{std::move(text)});
}

}  // namespace sprout
