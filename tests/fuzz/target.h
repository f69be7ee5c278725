#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sprout::fuzz {

using Bytes = std::vector<uint8_t>;

/// One reader of untrusted bytes.
struct Target {
  std::string_view name;

  /// Feeds it any bytes. Returns when it has answered as it promises, with a value or with the
  /// error of its interface; whatever else happens ends the process (Check(), an exception, a
  /// sanitizer).
  void (*run)(std::span<const uint8_t> bytes);

  /// Good inputs of it, to begin with.
  std::vector<Bytes> (*seeds)();

  size_t longest = 4096;  ///< bytes of an input that are worth trying
};

/// All of them; a README row and a line in targets.cc each.
std::span<const Target> Targets();

/// The target of this name. @throws std::invalid_argument that lists them.
const Target& TargetNamed(std::string_view name);

/// Ends the process when something that must hold does not.
void Check(bool holds, const std::string& what);

inline Bytes BytesOf(std::string_view text) { return {text.begin(), text.end()}; }

/// A file in memory with these bytes, for readers that take a path.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const uint8_t> bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const std::string& path() const { return path_; }

 private:
  int descriptor_;
  std::string path_;
};

/// Takes numbers from the front of an input; 0 when it is used up.
class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  uint8_t Byte();
  uint16_t Short();  ///< little endian

  /// The next `count` bytes, or as many as there are.
  std::span<const uint8_t> Take(size_t count);
  std::span<const uint8_t> rest() const { return bytes_; }

 private:
  std::span<const uint8_t> bytes_;
};

}  // namespace sprout::fuzz
