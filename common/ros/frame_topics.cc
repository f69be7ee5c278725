#include "common/ros/frame_topics.h"

#include <cassert>
#include <utility>

namespace sprout {
namespace {

constexpr RosTopicRow kRows[] = {
    {RosTopic::kLeft, "left/image_rect", &RosTypeOf<RosImage>, Part::kLeft},
    {RosTopic::kLeftInfo, "left/camera_info", &RosTypeOf<RosCameraInfo>, Part::kLeft, true},
    {RosTopic::kRight, "right/image_rect", &RosTypeOf<RosImage>, Part::kRight},
    {RosTopic::kRightInfo, "right/camera_info", &RosTypeOf<RosCameraInfo>, Part::kRight, true},
    {RosTopic::kDepth, "depth/image_rect", &RosTypeOf<RosImage>, Part::kDepth},
    {RosTopic::kDepthInfo, "depth/camera_info", &RosTypeOf<RosCameraInfo>, Part::kDepth},
    {RosTopic::kDepthSigma, "depth/sigma", &RosTypeOf<RosImage>, Part::kDepthSigma},
    {RosTopic::kPoints, "points", &RosTypeOf<RosPointCloud>, Part::kCloud},
    {RosTopic::kDisparity, "disparity", &RosTypeOf<RosDisparity>, Part::kDisparity, true},
    {RosTopic::kConfidence, "confidence", &RosTypeOf<RosImage>, Part::kConfidence},
    {RosTopic::kFused, "fused/disparity", &RosTypeOf<RosDisparity>, Part::kFused, true},
    {RosTopic::kFusedConfidence, "fused/confidence", &RosTypeOf<RosImage>, Part::kFusedConfidence},
    {RosTopic::kTof, "tof/image_raw", &RosTypeOf<RosImage>, Part::kTof},
    {RosTopic::kTofAmplitude, "tof/amplitude", &RosTypeOf<RosImage>, Part::kTof},
    {RosTopic::kTofInfo, "tof/camera_info", &RosTypeOf<RosCameraInfo>, Part::kTof, true},
    {RosTopic::kTransforms, "/tf_static", &RosTypeOf<RosTransforms>, Part::kRig},
    {RosTopic::kDiagnostics, "/diagnostics", &RosTypeOf<RosDiagnostics>, Part::kRig},
};

template <typename T>
std::unique_ptr<AnyRosMessage> Any(RosMessage<T> message) {
  return std::make_unique<RosMessage<T>>(std::move(message));
}

std::unique_ptr<AnyRosMessage> ImageOf(const RosPlace& place, const cv::Mat& image) {
  if (image.empty()) return nullptr;
  return Any(ToRosImage(place, image.isContinuous() ? image : image.clone()));
}

}  // namespace

std::span<const RosTopicRow> RosTopicRows() { return kRows; }

const RosTopicRow& RowOf(RosTopic topic) {
  const RosTopicRow& row = kRows[static_cast<size_t>(topic)];
  assert(row.topic == topic);
  return row;
}

std::string RosTopicName(const RosTopicRow& row, std::string_view prefix) {
  if (row.name.starts_with('/')) return std::string(row.name);
  return std::string(prefix) + "/" + std::string(row.name);
}

std::unique_ptr<AnyRosMessage> ToRos(RosTopic topic, const FrameId& id, const PartValue& value,
                                     const Rig* rig, const RosTopicOptions& options) {
  if (RowOf(topic).needs_rig && rig == nullptr) return nullptr;
  const RosFrames& frames = options.frames;
  const RosPlace left{id.utime, frames.left};
  const RosPlace right{id.utime, frames.right};
  const RosPlace tof{id.utime, frames.tof};
  switch (topic) {
    case RosTopic::kLeft:
    case RosTopic::kConfidence:
    case RosTopic::kFusedConfidence:
      return ImageOf(left, std::get<cv::Mat>(value));
    case RosTopic::kLeftInfo:
      return Any(ToRosLeftInfo(left, rig->pair));
    case RosTopic::kRight:
      return ImageOf(right, std::get<cv::Mat>(value));
    case RosTopic::kRightInfo:
      return Any(ToRosRightInfo(right, rig->pair));
    case RosTopic::kDepth:
      return Any(ToRosDepth(left, std::get<DepthImage>(value), options.depth));
    case RosTopic::kDepthInfo:
      return Any(ToRosDepthInfo(left, std::get<DepthImage>(value)));
    case RosTopic::kDepthSigma:
      return Any(ToRosDepthSigma(left, std::get<DepthImage>(value)));
    case RosTopic::kPoints:
      return Any(ToRosCloud(left, std::get<PointCloud>(value)));
    case RosTopic::kDisparity:
    case RosTopic::kFused:
      return Any(ToRosDisparity(left, std::get<DisparityImage>(value), rig->pair));
    case RosTopic::kTof:
      return ImageOf(tof, std::get<TofImage>(value).depth_m);
    case RosTopic::kTofAmplitude:
      return ImageOf(tof, std::get<TofImage>(value).amplitude);
    case RosTopic::kTofInfo:
      return rig->tof.width > 0 ? Any(ToRosTofInfo(tof, rig->tof)) : nullptr;
    case RosTopic::kTransforms:
      return Any(ToRosTransforms(id.utime, std::get<Rig>(value), frames));
    case RosTopic::kDiagnostics:
      break;
  }
  return nullptr;
}

}  // namespace sprout
