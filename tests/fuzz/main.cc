// The program of libFuzzer: tries one target, the one that FUZZ_TARGET names. scripts/fuzz runs it.
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

#include "tests/fuzz/target.h"

namespace {

const sprout::fuzz::Target* target = nullptr;

void WriteSeeds(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const sprout::fuzz::Bytes& seed : target->seeds()) {
    std::ofstream file(folder / ("seed" + std::to_string(number++)), std::ios::binary);
    file.write(reinterpret_cast<const char*>(seed.data()),
               static_cast<std::streamsize>(seed.size()));
  }
}

}  // namespace

// FUZZ_SEEDS, a folder: writes good inputs there and ends.
// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's names
extern "C" int LLVMFuzzerInitialize(int*, char***) try {
  const char* name = std::getenv("FUZZ_TARGET");
  target = &sprout::fuzz::TargetNamed(name == nullptr ? "" : name);
  if (const char* folder = std::getenv("FUZZ_SEEDS")) {
    WriteSeeds(folder);
    std::cout << target->longest << std::endl;
    std::_Exit(0);
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << "fuzz: " << e.what() << "\n";
  std::_Exit(2);
}

// NOLINTNEXTLINE(readability-identifier-naming)
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  target->run({data, size});
  return 0;
}
