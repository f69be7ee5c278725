#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/config.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/ros/cdr.h"
#include "common/ros/ros_type.h"

// ROS 2's messages written with eProsima's Fast-CDR, the serializer of ROS 2's own default, field
// by field as rosidl_typesupport_fastrtps does.
namespace sprout::fast_cdr {

using eprosima::fastcdr::Cdr;

// Version 2 renamed these.
#if FASTCDR_VERSION_MAJOR >= 2
constexpr auto kDdsCdr = eprosima::fastcdr::CdrVersion::DDS_CDR;
template <typename T>
void PutArray(Cdr& cdr, const T* values, size_t count) {
  cdr.serialize_array(values, count);
}
inline size_t SizeOf(const Cdr& cdr) { return cdr.get_serialized_data_length(); }
#else
constexpr auto kDdsCdr = Cdr::DDS_CDR;
template <typename T>
void PutArray(Cdr& cdr, const T* values, size_t count) {
  cdr.serializeArray(values, count);
}
inline size_t SizeOf(const Cdr& cdr) { return cdr.getSerializedDataLength(); }
#endif

inline void Put(Cdr& cdr, const char* text) { cdr << std::string(RosText(text)); }

template <typename Sequence>
void PutNumbers(Cdr& cdr, const Sequence& sequence) {
  cdr << sequence._length;
  if (sequence._length > 0) PutArray(cdr, sequence._buffer, sequence._length);
}

inline void Put(Cdr& cdr, const RosHeader& header) {
  cdr << header.stamp.sec << header.stamp.nanosec;
  Put(cdr, header.frame_id);
}

inline void Put(Cdr& cdr, const RosImage& image) {
  Put(cdr, image.header);
  cdr << image.height << image.width;
  Put(cdr, image.encoding);
  cdr << image.is_bigendian << image.step;
  PutNumbers(cdr, image.data);
}

inline void Put(Cdr& cdr, const RosCompressedImage& image) {
  Put(cdr, image.header);
  Put(cdr, image.format);
  PutNumbers(cdr, image.data);
}

inline void Put(Cdr& cdr, const RosRegion& region) {
  cdr << region.x_offset << region.y_offset << region.height << region.width << region.do_rectify;
}

inline void Put(Cdr& cdr, const RosCameraInfo& info) {
  Put(cdr, info.header);
  cdr << info.height << info.width;
  Put(cdr, info.distortion_model);
  PutNumbers(cdr, info.d);
  PutArray(cdr, info.k, 9);
  PutArray(cdr, info.r, 9);
  PutArray(cdr, info.p, 12);
  cdr << info.binning_x << info.binning_y;
  Put(cdr, info.roi);
}

inline void Put(Cdr& cdr, const RosPointCloud& cloud) {
  Put(cdr, cloud.header);
  cdr << cloud.height << cloud.width << cloud.fields._length;
  for (const RosPointField& field : RosSpan(cloud.fields)) {
    Put(cdr, field.name);
    cdr << field.offset << field.datatype << field.count;
  }
  cdr << cloud.is_bigendian << cloud.point_step << cloud.row_step;
  PutNumbers(cdr, cloud.data);
  cdr << cloud.is_dense;
}

inline void Put(Cdr& cdr, const RosDisparity& disparity) {
  Put(cdr, disparity.header);
  Put(cdr, disparity.image);
  cdr << disparity.f << disparity.t;
  Put(cdr, disparity.valid_window);
  cdr << disparity.min_disparity << disparity.max_disparity << disparity.delta_d;
}

inline void Put(Cdr& cdr, const RosTransforms& transforms) {
  cdr << transforms.transforms._length;
  for (const RosTransform& one : RosSpan(transforms.transforms)) {
    Put(cdr, one.header);
    Put(cdr, one.child_frame_id);
    const auto& place = one.transform.translation;
    const auto& turn = one.transform.rotation;
    cdr << place.x << place.y << place.z << turn.x << turn.y << turn.z << turn.w;
  }
}

inline void Put(Cdr& cdr, const RosDiagnostics& diagnostics) {
  Put(cdr, diagnostics.header);
  cdr << diagnostics.status._length;
  for (const RosDiagnostic& status : RosSpan(diagnostics.status)) {
    cdr << status.level;
    Put(cdr, status.name);
    Put(cdr, status.message);
    Put(cdr, status.hardware_id);
    cdr << status.values._length;
    for (const RosKeyValue& one : RosSpan(status.values)) {
      Put(cdr, one.key);
      Put(cdr, one.value);
    }
  }
}

template <typename T>
std::vector<uint8_t> Write(const T& message, Cdr::Endianness order) {
  // Fast-CDR leaves what it skips as it is.
  std::vector<char> memory(1 << 16);
  eprosima::fastcdr::FastBuffer buffer(memory.data(), memory.size());
  Cdr cdr(buffer, order, kDdsCdr);
  cdr.serialize_encapsulation();
  Put(cdr, message);
  const auto* begin = reinterpret_cast<const uint8_t*>(buffer.getBuffer());
  return {begin, begin + SizeOf(cdr)};
}

}  // namespace sprout::fast_cdr
