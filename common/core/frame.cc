#include "common/core/frame.h"

#include <type_traits>
#include <utility>

namespace sprout {

namespace {

size_t Bytes(const cv::Mat& mat) { return mat.total() * mat.elemSize(); }
size_t Bytes(const TofImage& tof) { return Bytes(tof.depth_m) + Bytes(tof.amplitude); }
size_t Bytes(const Rig&) { return 0; }
size_t Bytes(const CameraMotion&) { return 0; }
size_t Bytes(const DepthCounts&) { return 0; }
size_t Bytes(const TofZones& zones) {
  return zones.views.capacity() * sizeof(ZoneView) + zones.targets.capacity() * sizeof(ZoneTarget);
}
size_t Bytes(const SeedSet& set) { return set.seeds.capacity() * sizeof(Seed); }
size_t Bytes(const DisparityImage& map) { return Bytes(map.counts()); }
size_t Bytes(const DepthImage& depth) { return Bytes(depth.counts); }
size_t Bytes(const PointCloud& cloud) { return cloud.points.capacity() * sizeof(CloudPoint); }
size_t Bytes(const PriorMap& prior) { return Bytes(prior.disparity) + Bytes(prior.sigma); }
template <typename Value>
size_t Bytes(const std::optional<Value>& value) {
  return value ? Bytes(*value) : 0;
}

// 0×0 for what is no picture of the left or right camera.
template <typename Value>
cv::Size PictureSize(const Value&) {
  return {};
}
cv::Size PictureSize(const cv::Mat& image) { return image.size(); }
template <typename Map>
requires requires(Map map) {
  map.CountValid();
} || std::is_same_v<Map, PriorMap> cv::Size PictureSize(const std::optional<Map>& map) {
  return map ? map->size() : cv::Size();
}

}  // namespace

std::optional<Part> PartOf(std::string_view channel, std::string_view prefix) {
  if (!channel.starts_with(prefix)) return std::nullopt;
  channel.remove_prefix(prefix.size());
  for (const PartRow& row : kPartTable) {
    if (row.channel == channel) return row.part;
  }
  return std::nullopt;
}

void SetPart(Frame& frame, Part part, PartValue value) {
  std::visit(
      [&](auto member) {
        using Member = std::remove_reference_t<decltype(frame.*member)>;
        if constexpr (std::is_same_v<Member, cv::Mat>) {
          frame.*member = std::get<cv::Mat>(std::move(value));
        } else {
          frame.*member = std::get<typename Member::value_type>(std::move(value));
        }
      },
      RowOf(part).member);
}

PartValue GetPart(const Frame& frame, Part part) {
  return std::visit(
      [&](auto member) -> PartValue {
        using Member = std::remove_cvref_t<decltype(frame.*member)>;
        if constexpr (std::is_same_v<Member, cv::Mat>) {
          return frame.*member;
        } else {
          return (frame.*member).value();
        }
      },
      RowOf(part).member);
}

size_t BytesOf(const Frame& frame) {
  size_t bytes = 0;
  for (const PartRow& row : kPartTable) {
    bytes += std::visit([&](auto member) { return Bytes(frame.*member); }, row.member);
  }
  return bytes;
}

std::optional<cv::Size> ImageSize(const Frame& frame) {
  for (const PartRow& row : kPartTable) {
    const cv::Size size =
        std::visit([&](auto member) { return PictureSize(frame.*member); }, row.member);
    if (!size.empty()) return size;
  }
  return std::nullopt;
}

}  // namespace sprout
