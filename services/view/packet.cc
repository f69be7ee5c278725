#include "services/view/packet.h"

#include <bit>

namespace sprout::view {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are sent as they lie in memory");

constexpr size_t kAlignment = 8;

size_t Aligned(size_t size) { return (size + kAlignment - 1) / kAlignment * kAlignment; }

}  // namespace

std::string MakePacket(nlohmann::json head, const std::vector<EncodedPartPtr>& parts) {
  nlohmann::json heads = nlohmann::json::array();
  size_t offset = 0;
  for (const EncodedPartPtr& part : parts) {
    nlohmann::json part_head = part->head;
    part_head["offset"] = offset;
    part_head["size"] = part->body.size();
    heads.push_back(std::move(part_head));
    offset += Aligned(part->body.size());
  }
  head["parts"] = std::move(heads);
  std::string text = JsonText(head);
  text.resize(Aligned(text.size() + sizeof(uint32_t)) - sizeof(uint32_t), ' ');
  const auto length = static_cast<uint32_t>(text.size());
  std::string packet;
  packet.reserve(sizeof length + text.size() + offset);
  packet.append(reinterpret_cast<const char*>(&length), sizeof length);
  packet += text;
  for (const EncodedPartPtr& part : parts) {
    packet += part->body;
    packet.resize(Aligned(packet.size()), '\0');
  }
  return packet;
}

}  // namespace sprout::view
