#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/ros/cdr.h"
#include "common/ros/to_ros.h"
#include "tests/common/messages/examples.h"

// One message of every type, of odd lengths so that every alignment comes up, and its fields as
// JSON.
namespace sprout::examples {

using Json = nlohmann::json;

/// Why a conversion failed, or "none".
std::string ErrorOf(const auto& result) { return result ? "none" : result.error().text; }

template <typename Sequence>
Json Numbers(const Sequence& values) {
  Json all = Json::array();
  for (const auto& value : values) all.push_back(value);
  return all;
}

inline Json Value(const RosHeader& header) {
  return {{"stamp", {{"sec", header.stamp.sec}, {"nanosec", header.stamp.nanosec}}},
          {"frame_id", RosText(header.frame_id)}};
}

inline Json Value(const RosImage& image) {
  return {{"header", Value(image.header)},
          {"height", image.height},
          {"width", image.width},
          {"encoding", RosText(image.encoding)},
          {"is_bigendian", image.is_bigendian},
          {"step", image.step},
          {"data", Numbers(RosSpan(image.data))}};
}

inline Json Value(const RosCompressedImage& image) {
  return {{"header", Value(image.header)},
          {"format", RosText(image.format)},
          {"data", Numbers(RosSpan(image.data))}};
}

inline Json Value(const RosRegion& region) {
  return {{"x_offset", region.x_offset},
          {"y_offset", region.y_offset},
          {"height", region.height},
          {"width", region.width},
          {"do_rectify", region.do_rectify}};
}

inline Json Value(const RosCameraInfo& info) {
  return {{"header", Value(info.header)},  {"height", info.height},
          {"width", info.width},           {"distortion_model", RosText(info.distortion_model)},
          {"d", Numbers(RosSpan(info.d))}, {"k", Numbers(info.k)},
          {"r", Numbers(info.r)},          {"p", Numbers(info.p)},
          {"binning_x", info.binning_x},   {"binning_y", info.binning_y},
          {"roi", Value(info.roi)}};
}

inline Json Value(const RosPointCloud& cloud) {
  Json fields = Json::array();
  for (const RosPointField& field : RosSpan(cloud.fields)) {
    fields.push_back({{"name", RosText(field.name)},
                      {"offset", field.offset},
                      {"datatype", field.datatype},
                      {"count", field.count}});
  }
  return {{"header", Value(cloud.header)},
          {"height", cloud.height},
          {"width", cloud.width},
          {"fields", fields},
          {"is_bigendian", cloud.is_bigendian},
          {"point_step", cloud.point_step},
          {"row_step", cloud.row_step},
          {"data", Numbers(RosSpan(cloud.data))},
          {"is_dense", cloud.is_dense}};
}

inline Json Value(const RosDisparity& disparity) {
  return {{"header", Value(disparity.header)},
          {"image", Value(disparity.image)},
          {"f", disparity.f},
          {"t", disparity.t},
          {"valid_window", Value(disparity.valid_window)},
          {"min_disparity", disparity.min_disparity},
          {"max_disparity", disparity.max_disparity},
          {"delta_d", disparity.delta_d}};
}

inline Json Value(const RosTransforms& transforms) {
  Json all = Json::array();
  for (const RosTransform& one : RosSpan(transforms.transforms)) {
    const auto& place = one.transform.translation;
    const auto& turn = one.transform.rotation;
    all.push_back({{"header", Value(one.header)},
                   {"child_frame_id", RosText(one.child_frame_id)},
                   {"transform",
                    {{"translation", {{"x", place.x}, {"y", place.y}, {"z", place.z}}},
                     {"rotation", {{"x", turn.x}, {"y", turn.y}, {"z", turn.z}, {"w", turn.w}}}}}});
  }
  return {{"transforms", all}};
}

inline Json Value(const RosDiagnostics& diagnostics) {
  Json all = Json::array();
  for (const RosDiagnostic& status : RosSpan(diagnostics.status)) {
    Json values = Json::array();
    for (const RosKeyValue& one : RosSpan(status.values)) {
      values.push_back({{"key", RosText(one.key)}, {"value", RosText(one.value)}});
    }
    all.push_back({{"level", status.level},
                   {"name", RosText(status.name)},
                   {"message", RosText(status.message)},
                   {"hardware_id", RosText(status.hardware_id)},
                   {"values", values}});
  }
  return {{"header", Value(diagnostics.header)}, {"status", all}};
}

inline RosPlace Place() { return {.utime = 1'700'000'000'123'456, .frame = "left"}; }

inline RosMessage<RosCompressedImage> Compressed() {
  RosMessage<RosCompressedImage> message;
  message->header.stamp = RosStamp(Place().utime);
  SetRosText(message->header.frame_id, "camera");
  SetRosText(message->format, "bgr8; jpeg compressed bgr8");
  const std::span data = ResizeRos(message->data, 13);
  for (size_t i = 0; i < data.size(); ++i) data[i] = static_cast<uint8_t>(20 * i);
  return message;
}

inline DisparityImage SmallDisparity() {
  DisparityImage disparity(cv::Size(5, 3));
  for (int u = 0; u < 4; ++u) disparity.counts()(1, u) = static_cast<int16_t>(40 * u + 7);
  return disparity;
}

/// Calls visit(message, JSON of its fields) with one message of every type.
template <typename Visit>
void ForEachRosExample(const Visit& visit) {
  const auto show = [&](auto message) { visit(message, Value(*message)); };
  show(ToRosImage(Place(), GreyImage()));
  show(Compressed());
  show(ToRosRightInfo(Place(), Rig().pair));
  show(ToRosTofInfo({1, "a longer name of a frame"}, Rig().tof));
  show(ToRosCloud(Place(), Cloud()));
  show(ToRosDisparity(Place(), SmallDisparity(), Rig().pair));
  show(ToRosTransforms(Place().utime, Rig(), {}));
  show(ToRosDiagnostics(-1, {{"a", {Status()}}, {"b", {StageStatus{}}}}));
}

}  // namespace sprout::examples
