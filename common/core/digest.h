#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace sprout {

/// XXH3 (64 bits) of the bytes; the same on every machine.
uint64_t Hash(std::string_view bytes);

/// Hash() as 16 hexadecimal digits. To distinguish configurations and calibrations; not secure
/// against forgery.
std::string Digest(std::string_view bytes);

/// Digest() of bytes that come in pieces.
class DigestStream {
 public:
  DigestStream();
  ~DigestStream();
  DigestStream(const DigestStream&) = delete;
  DigestStream& operator=(const DigestStream&) = delete;

  void Add(std::string_view bytes);

  /// Digest of all bytes so far.
  std::string Text() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sprout
