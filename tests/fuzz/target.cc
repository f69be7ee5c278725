#include "tests/fuzz/target.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

namespace sprout::fuzz {

void Check(bool holds, const std::string& what) {
  if (holds) return;
  std::cerr << "fuzz: " << what << std::endl;
  std::abort();
}

MemoryFile::MemoryFile(std::span<const uint8_t> bytes)
    : descriptor_(memfd_create("fuzz", 0)), path_("/proc/self/fd/" + std::to_string(descriptor_)) {
  Check(descriptor_ >= 0, "no file in memory");
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    Check(written > 0, "a file in memory cannot be written");
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
}

MemoryFile::~MemoryFile() { close(descriptor_); }

uint8_t Reader::Byte() {
  const std::span<const uint8_t> byte = Take(1);
  return byte.empty() ? uint8_t{0} : byte[0];
}

uint16_t Reader::Short() {
  const int low = Byte();
  return static_cast<uint16_t>(low | Byte() << 8);
}

std::span<const uint8_t> Reader::Take(size_t count) {
  const std::span<const uint8_t> taken = bytes_.first(std::min(count, bytes_.size()));
  bytes_ = bytes_.subspan(taken.size());
  return taken;
}

}  // namespace sprout::fuzz
