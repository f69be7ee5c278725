#include "common/ros/ros_type.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

namespace sprout {
namespace {

constexpr RosType kTime{"builtin_interfaces/msg/Time", &builtin_interfaces_msg_dds__Time__desc,
                        "int32 sec\n"
                        "uint32 nanosec\n"};

constexpr std::array kUsesTime = {&kTime};
constexpr RosType kHeader{"std_msgs/msg/Header", &std_msgs_msg_dds__Header__desc,
                          "builtin_interfaces/Time stamp\n"
                          "string frame_id\n",
                          kUsesTime};

constexpr std::array kUsesHeader = {&kHeader};
constexpr RosType kImage{"sensor_msgs/msg/Image", &sensor_msgs_msg_dds__Image__desc,
                         "std_msgs/Header header\n"
                         "uint32 height\n"
                         "uint32 width\n"
                         "string encoding\n"
                         "uint8 is_bigendian\n"
                         "uint32 step\n"
                         "uint8[] data\n",
                         kUsesHeader,
                         "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"};

constexpr RosType kCompressedImage{
    "sensor_msgs/msg/CompressedImage", &sensor_msgs_msg_dds__CompressedImage__desc,
    "std_msgs/Header header\n"
    "string format\n"
    "uint8[] data\n",
    kUsesHeader, "RIHS01_15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a"};

constexpr RosType kRegion{"sensor_msgs/msg/RegionOfInterest",
                          &sensor_msgs_msg_dds__RegionOfInterest__desc,
                          "uint32 x_offset\n"
                          "uint32 y_offset\n"
                          "uint32 height\n"
                          "uint32 width\n"
                          "bool do_rectify\n"};

constexpr std::array kUsesHeaderAndRegion = {&kHeader, &kRegion};
constexpr RosType kCameraInfo{
    "sensor_msgs/msg/CameraInfo", &sensor_msgs_msg_dds__CameraInfo__desc,
    "std_msgs/Header header\n"
    "uint32 height\n"
    "uint32 width\n"
    "string distortion_model\n"
    "float64[] d\n"
    "float64[9] k\n"
    "float64[9] r\n"
    "float64[12] p\n"
    "uint32 binning_x\n"
    "uint32 binning_y\n"
    "sensor_msgs/RegionOfInterest roi\n",
    kUsesHeaderAndRegion,
    "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"};

constexpr RosType kPointField{"sensor_msgs/msg/PointField", &sensor_msgs_msg_dds__PointField__desc,
                              "uint8 INT8=1\n"
                              "uint8 UINT8=2\n"
                              "uint8 INT16=3\n"
                              "uint8 UINT16=4\n"
                              "uint8 INT32=5\n"
                              "uint8 UINT32=6\n"
                              "uint8 FLOAT32=7\n"
                              "uint8 FLOAT64=8\n"
                              "string name\n"
                              "uint32 offset\n"
                              "uint8 datatype\n"
                              "uint32 count\n"};

constexpr std::array kUsesHeaderAndField = {&kHeader, &kPointField};
constexpr RosType kPointCloud{
    "sensor_msgs/msg/PointCloud2", &sensor_msgs_msg_dds__PointCloud2__desc,
    "std_msgs/Header header\n"
    "uint32 height\n"
    "uint32 width\n"
    "sensor_msgs/PointField[] fields\n"
    "bool is_bigendian\n"
    "uint32 point_step\n"
    "uint32 row_step\n"
    "uint8[] data\n"
    "bool is_dense\n",
    kUsesHeaderAndField, "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"};

constexpr std::array kUsesHeaderImageAndRegion = {&kHeader, &kImage, &kRegion};
constexpr RosType kDisparity{
    "stereo_msgs/msg/DisparityImage", &stereo_msgs_msg_dds__DisparityImage__desc,
    "std_msgs/Header header\n"
    "sensor_msgs/Image image\n"
    "float32 f\n"
    "float32 t\n"
    "sensor_msgs/RegionOfInterest valid_window\n"
    "float32 min_disparity\n"
    "float32 max_disparity\n"
    "float32 delta_d\n",
    kUsesHeaderImageAndRegion,
    "RIHS01_1ec1ff6b5bace919e4544a37f2d96ead9f81783701b7b7a4d97a09325ecf2711"};

constexpr RosType kVector3{"geometry_msgs/msg/Vector3", &geometry_msgs_msg_dds__Vector3__desc,
                           "float64 x\n"
                           "float64 y\n"
                           "float64 z\n"};

constexpr RosType kQuaternion{"geometry_msgs/msg/Quaternion",
                              &geometry_msgs_msg_dds__Quaternion__desc,
                              "float64 x 0\n"
                              "float64 y 0\n"
                              "float64 z 0\n"
                              "float64 w 1\n"};

constexpr std::array kUsesVectorAndQuaternion = {&kVector3, &kQuaternion};
constexpr RosType kTransform{"geometry_msgs/msg/Transform", &geometry_msgs_msg_dds__Transform__desc,
                             "geometry_msgs/Vector3 translation\n"
                             "geometry_msgs/Quaternion rotation\n",
                             kUsesVectorAndQuaternion};

constexpr std::array kUsesHeaderAndTransform = {&kHeader, &kTransform};
constexpr RosType kTransformStamped{"geometry_msgs/msg/TransformStamped",
                                    &geometry_msgs_msg_dds__TransformStamped__desc,
                                    "std_msgs/Header header\n"
                                    "string child_frame_id\n"
                                    "geometry_msgs/Transform transform\n",
                                    kUsesHeaderAndTransform};

constexpr std::array kUsesTransformStamped = {&kTransformStamped};
constexpr RosType kTransforms{
    "tf2_msgs/msg/TFMessage", &tf2_msgs_msg_dds__TFMessage__desc,
    "geometry_msgs/TransformStamped[] transforms\n", kUsesTransformStamped,
    "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"};

constexpr RosType kKeyValue{"diagnostic_msgs/msg/KeyValue",
                            &diagnostic_msgs_msg_dds__KeyValue__desc,
                            "string key\n"
                            "string value\n"};

constexpr std::array kUsesKeyValue = {&kKeyValue};
constexpr RosType kDiagnostic{"diagnostic_msgs/msg/DiagnosticStatus",
                              &diagnostic_msgs_msg_dds__DiagnosticStatus__desc,
                              "byte OK=0\n"
                              "byte WARN=1\n"
                              "byte ERROR=2\n"
                              "byte STALE=3\n"
                              "byte level\n"
                              "string name\n"
                              "string message\n"
                              "string hardware_id\n"
                              "diagnostic_msgs/KeyValue[] values\n",
                              kUsesKeyValue};

constexpr std::array kUsesHeaderAndDiagnostic = {&kHeader, &kDiagnostic};
constexpr RosType kDiagnostics{
    "diagnostic_msgs/msg/DiagnosticArray", &diagnostic_msgs_msg_dds__DiagnosticArray__desc,
    "std_msgs/Header header\n"
    "diagnostic_msgs/DiagnosticStatus[] status\n",
    kUsesHeaderAndDiagnostic,
    "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"};

constexpr RosType kGid{"rmw_dds_common/msg/Gid", &rmw_dds_common_msg_dds__Gid__desc,
                       "char[16] data\n"};

constexpr std::array kUsesGid = {&kGid};
constexpr RosType kNodeEntities{"rmw_dds_common/msg/NodeEntitiesInfo",
                                &rmw_dds_common_msg_dds__NodeEntitiesInfo__desc,
                                "string<=256 node_namespace\n"
                                "string<=256 node_name\n"
                                "rmw_dds_common/Gid[] reader_gid_seq\n"
                                "rmw_dds_common/Gid[] writer_gid_seq\n",
                                kUsesGid};

constexpr std::array kUsesGidAndNode = {&kGid, &kNodeEntities};
constexpr RosType kParticipantEntities{
    "rmw_dds_common/msg/ParticipantEntitiesInfo",
    &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
    "rmw_dds_common/Gid gid\n"
    "rmw_dds_common/NodeEntitiesInfo[] node_entities_info_seq\n",
    kUsesGidAndNode, "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"};

// A type that is sent by itself, found by its structure.
template <typename T>
struct TypeOf {
  const RosType* type;
};
constexpr std::tuple kTypeOf = {TypeOf<RosImage>{&kImage},
                                TypeOf<RosCompressedImage>{&kCompressedImage},
                                TypeOf<RosCameraInfo>{&kCameraInfo},
                                TypeOf<RosPointCloud>{&kPointCloud},
                                TypeOf<RosDisparity>{&kDisparity},
                                TypeOf<RosTransforms>{&kTransforms},
                                TypeOf<RosDiagnostics>{&kDiagnostics},
                                TypeOf<RosParticipantEntities>{&kParticipantEntities}};
constexpr std::array kTypes =
    std::apply([](auto... one) { return std::array{one.type...}; }, kTypeOf);

// Adds the types that a type uses, each once, in the order in which they are met.
void AddUsed(const RosType& type, std::vector<const RosType*>& used) {
  for (const RosType* one : type.uses) {
    if (std::ranges::find(used, one) != used.end()) continue;
    used.push_back(one);
    AddUsed(*one, used);
  }
}

// In schemas a type has no "msg" in its name.
std::string ShortName(std::string name) {
  const size_t at = name.find("/msg/");
  return name.erase(at, 4);
}

}  // namespace

template <typename T>
const RosType& RosTypeOf() {
  return *std::get<TypeOf<T>>(kTypeOf).type;
}
template const RosType& RosTypeOf<RosImage>();
template const RosType& RosTypeOf<RosCompressedImage>();
template const RosType& RosTypeOf<RosCameraInfo>();
template const RosType& RosTypeOf<RosPointCloud>();
template const RosType& RosTypeOf<RosDisparity>();
template const RosType& RosTypeOf<RosTransforms>();
template const RosType& RosTypeOf<RosDiagnostics>();
template const RosType& RosTypeOf<RosParticipantEntities>();

std::span<const RosType* const> RosTypes() { return kTypes; }

std::string RosSchema(const RosType& type) {
  std::vector<const RosType*> used;
  AddUsed(type, used);
  std::string text(type.text);
  for (const RosType* one : used) {
    text.append(80, '=').append("\nMSG: ").append(ShortName(one->name)).append("\n");
    text += one->text;
  }
  return text;
}

}  // namespace sprout
