#pragma once

#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>

namespace sprout {

/// What ends a run of random events: something did not survive.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The main function of a run of random events: `NAME NUMBER [SEED]`, with a NUMBER of 1 or more.
/// @tparam Number   what Run() takes.
/// @param usage     "attack SECONDS".
/// @param success   what is printed when all went well.
/// @param make      gives for a seed an object with Run(Number), which throws Failure, and
///                  Print(std::ostream&).
/// @returns exit code.
template <typename Number, typename Make>
int RunSeeded(int argc, char** argv, const std::string& usage, const char* success,
              const Make& make) {
  const long number = argc < 2 ? 0 : std::atol(argv[1]);
  if (number < 1 || argc > 3) {
    const std::string name = usage.substr(0, usage.find(' '));
    std::cerr << "usage: " << usage << " [SEED]; scripts/" << name
              << " gives it a network of its own\n";
    return 2;
  }
  const auto seed = static_cast<uint32_t>(argc > 2 ? std::atol(argv[2]) : 1);
  auto run = make(seed);
  std::string failure;
  try {
    run.Run(Number(number));
  } catch (const Failure& e) {
    failure = e.what();
  }
  run.Print(std::cout);
  if (failure.empty()) {
    std::cout << success << "\n";
    return 0;
  }
  std::cout << "\nFAILED with seed " << seed << ": " << failure << "\n";
  return 1;
}

}  // namespace sprout
