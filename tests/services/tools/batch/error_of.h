#ifndef SPROUT_TESTS_SERVICES_TOOLS_BATCH_ERROR_OF_H_
#define SPROUT_TESTS_SERVICES_TOOLS_BATCH_ERROR_OF_H_

#include <functional>
#include <string>

namespace sprout::batch {

/// The text of an exception of this type that an action throws.
template <typename Error>
std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace sprout::batch

#endif  // SPROUT_TESTS_SERVICES_TOOLS_BATCH_ERROR_OF_H_
