#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sprout::view {

/// JSON for the page, also for texts from the network that are not UTF-8.
inline std::string JsonText(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// A picture, a cloud or seeds, encoded for the page.
struct EncodedPart {
  nlohmann::json head;  ///< name and what is needed to read `body`
  std::string body;     ///< a JPEG stream, or arrays of little-endian numbers

  /// Allocated memory, including that of `head`.
  size_t memory() const { return body.capacity() + kHeadBytes; }

  /// Approximate memory of a head of 10 to 15 numbers and names.
  static constexpr size_t kHeadBytes = 2048;
};
using EncodedPartPtr = std::shared_ptr<const EncodedPart>;

/// One binary message with everything shown of a frame: length of the head (uint32, little-endian),
/// the head (JSON, padded with spaces to a multiple of 8), and the bodies, each padded with zeros
/// to a multiple of 8. The head gives "offset" and "size" of each part, counted from the beginning
/// of the first body.
std::string MakePacket(nlohmann::json head, const std::vector<EncodedPartPtr>& parts);

/// Appends the memory of numbers.
template <typename T>
void AppendNumbers(std::string& body, const std::vector<T>& numbers) {
  body.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
}

}  // namespace sprout::view
