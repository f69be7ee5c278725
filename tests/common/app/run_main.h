#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

namespace sprout {

/// What a program's main function returned and wrote.
struct MainOutcome {
  int exit_code;
  std::string out;
  std::string err;
};

/// Calls what returns an exit code.
template <typename Call>
MainOutcome Captured(const Call& call) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const int exit_code = call();
  return {exit_code, ::testing::internal::GetCapturedStdout(),
          ::testing::internal::GetCapturedStderr()};
}

/// Calls main(argc, argv).
/// @param words  the program's name, and its arguments.
template <typename Main>
MainOutcome RunMain(const std::vector<std::string>& words, const Main& main) {
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  return Captured([&] { return main(static_cast<int>(argv.size()), argv.data()); });
}

/// Expects an exit code, nothing on stdout, and one line of the program on stderr that holds
/// `reason`.
inline void ExpectRefused(const MainOutcome& outcome, int exit_code, const std::string& program,
                          const std::string& reason) {
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, ::testing::StartsWith(program + ": "));
  EXPECT_THAT(outcome.err, ::testing::HasSubstr(reason));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

}  // namespace sprout
