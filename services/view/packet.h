#ifndef SPROUT_SERVICES_VIEW_PACKET_H_
#define SPROUT_SERVICES_VIEW_PACKET_H_

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace sprout::view {

/// JSON for the page. Texts from the network need not be UTF-8.
inline std::string JsonText(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// A picture, a cloud or seeds, ready for the wire.
struct EncodedPart {
  nlohmann::json head;  ///< name and what is needed to read `body`
  std::string body;     ///< a JPEG stream, or arrays of little-endian numbers

  /// Memory that it takes, with what `head` has; not only the bytes that are in use.
  size_t memory() const { return body.capacity() + kHeadBytes; }

  /// About what a head of 10 to 15 numbers and names takes.
  static constexpr size_t kHeadBytes = 2048;
};
using EncodedPartPtr = std::shared_ptr<const EncodedPart>;

/// One binary message with all that is shown of a frame: length of the head (uint32,
/// little-endian), the head (JSON, filled up with spaces so that what follows begins at a multiple
/// of 8), and the bodies, each filled up with zeros to a multiple of 8. In the head the parts have
/// "offset" and "size", from the beginning of the first body.
std::string MakePacket(nlohmann::json head, const std::vector<EncodedPartPtr>& parts);

/// Appends the memory of numbers.
template <typename T>
void AppendNumbers(std::string& body, const std::vector<T>& numbers) {
  body.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
}

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_PACKET_H_
