#include "services/capture/ros2/ros_settings.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/number_text.h"
#include "common/ros/ros_node.h"
#include "common/scenes/source_options.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {
namespace {

constexpr std::string_view kRos2 = "ros2:";
constexpr std::string_view kMcap = "mcap:";
constexpr std::string_view kCompressed = "/compressed";
constexpr std::string_view kCompressedDepth = "/compressedDepth";

ConfigError Bad(const std::string& source, const std::string& reason) {
  return scenes::BadSource(
      source, reason,
      "left=TOPIC&right=TOPIC with left_info, right_info, points, depth, depth_info, "
      "tf=TOPIC, pose=x,y,z,qx,qy,qz,qw (m) of the range sensor in the left image's frame, "
      "rig=FILE, max_spread_ms=0.001 to 1000, bits=8 to 16, and for ros2: domain=0 to 232");
}

// "/stereo/left/image_raw/compressed" → "/stereo/left/camera_info"
std::string InfoBeside(std::string topic) {
  for (const std::string_view transport : {kCompressed, kCompressedDepth}) {
    if (topic.ends_with(transport)) topic.resize(topic.size() - transport.size());
  }
  const size_t slash = topic.rfind('/');
  return (slash == std::string::npos ? "" : topic.substr(0, slash)) + "/camera_info";
}

// Each role with the option that names its topic.
struct TopicRow {
  RosRole role;
  std::string_view option;
  std::string RosSettings::*topic;
};
constexpr std::array kTopics = {
    TopicRow{RosRole::kLeft, "left", &RosSettings::left},
    TopicRow{RosRole::kRight, "right", &RosSettings::right},
    TopicRow{RosRole::kLeftInfo, "left_info", &RosSettings::left_info},
    TopicRow{RosRole::kRightInfo, "right_info", &RosSettings::right_info},
    TopicRow{RosRole::kPoints, "points", &RosSettings::points},
    TopicRow{RosRole::kDepth, "depth", &RosSettings::depth},
    TopicRow{RosRole::kDepthInfo, "depth_info", &RosSettings::depth_info},
    TopicRow{RosRole::kTf, "tf", &RosSettings::tf}};

std::string* TextOf(RosSettings& settings, std::string_view name) {
  if (name == "rig") return &settings.rig;
  const auto row = std::ranges::find(kTopics, name, &TopicRow::option);
  return row == kTopics.end() ? nullptr : &(settings.*row->topic);
}

// x,y,z,qx,qy,qz,qw, as ROS's static_transform_publisher has them, or x,y,z alone.
std::optional<Pose> ParsePose(std::string_view text) {
  constexpr double kMaxOffUnit = 1e-3;
  std::vector<double> numbers = ParseNumbers<double>(',', text).value_or(std::vector<double>());
  if (numbers.size() == 3) numbers.insert(numbers.end(), {0, 0, 0, 1});
  if (numbers.size() != 7) return std::nullopt;
  const Eigen::Quaterniond rotation(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (std::abs(rotation.norm() - 1) > kMaxOffUnit) return std::nullopt;
  return Pose{.rotation = rotation.normalized(),
              .translation_m = {numbers[0], numbers[1], numbers[2]}};
}

// @returns whether the option is known and its value allowed.
bool Apply(const scenes::SourceOption& option, RosSettings& settings) {
  if (std::string* const text = TextOf(settings, option.name)) {
    *text = option.value;
    return !text->empty();
  }
  if (option.name == "max_spread_ms") {
    const std::optional<double> number = ParseNumber<double>(option.value);
    settings.max_spread_ms = number.value_or(0);
    return settings.max_spread_ms >= 0.001 && settings.max_spread_ms <= 1000;
  }
  if (option.name == "bits") {
    settings.bits = ParseNumber<int>(option.value).value_or(0);
    return settings.bits >= 8 && settings.bits <= 16;
  }
  if (option.name == "pose") {
    settings.left_from_range = ParsePose(option.value);
    return settings.left_from_range.has_value();
  }
  if (option.name == "domain" && settings.file.empty()) {
    settings.domain = ParseNumber<int>(option.value).value_or(-1);
    return settings.domain >= 0 && settings.domain <= 232;
  }
  return false;
}

int DomainOfEnvironment(const std::string& source) {
  try {
    return RosDomainOfEnvironment().value_or(0);
  } catch (const ConfigError& e) {
    throw ConfigError("capture.source = " + source + ": " + e.what());
  }
}

void CompleteNames(RosSettings& settings) {
  for (const TopicRow& row : kTopics) {
    std::string& topic = settings.*row.topic;
    if (!topic.empty() && topic.front() != '/') topic.insert(0, "/");
  }
  const bool is_raw = !settings.rig.empty();
  if (!is_raw && settings.left_info.empty()) settings.left_info = InfoBeside(settings.left);
  if (!is_raw && settings.right_info.empty()) settings.right_info = InfoBeside(settings.right);
  if (!is_raw && !settings.depth.empty() && settings.depth_info.empty()) {
    settings.depth_info = InfoBeside(settings.depth);
  }
}

// Each camera has a topic of its own, and so has the calibration of each of the two.
void RequireDifferentTopics(const std::string& source, const RosSettings& settings) {
  const auto require = [&](std::initializer_list<std::pair<const char*, std::string>> topics) {
    std::map<std::string, const char*> names;
    for (const auto& [name, topic] : topics) {
      if (topic.empty()) continue;
      const auto [before, is_new] = names.emplace(topic, name);
      if (is_new) continue;
      throw Bad(source, std::string(before->second) + " and " + name + " are both " + topic);
    }
  };
  require({{"left", settings.left},
           {"right", settings.right},
           {"points", settings.points},
           {"depth", settings.depth}});
  require({{"left_info", settings.left_info}, {"right_info", settings.right_info}});
}

}  // namespace

std::vector<std::string> TransformTopics(const std::string& topic) {
  std::vector<std::string> topics;
  for (size_t slash = 0; slash != std::string::npos; slash = topic.find('/', slash + 1)) {
    for (const char* name : {"/tf_static", "/tf"}) topics.push_back(topic.substr(0, slash) + name);
  }
  return topics;
}

std::vector<std::string> RosSettings::TopicsOf(RosRole role) const {
  const std::string& topic = this->*std::ranges::find(kTopics, role, &TopicRow::role)->topic;
  if (role != RosRole::kTf) return topic.empty() ? std::vector<std::string>() : std::vector{topic};
  if (!rig.empty() || left_info.empty()) return {};  // nothing to place
  return topic.empty() ? TransformTopics(left) : std::vector{topic};
}

bool NameHas(std::string image, std::string_view word) {
  for (const std::string_view transport : {kCompressed, kCompressedDepth}) {
    if (image.ends_with(transport)) image.resize(image.size() - transport.size());
  }
  return image.find(word, image.rfind('/')) != std::string::npos;
}

bool RosSettings::DepthIsRectified() const {
  return depth_info == left_info || depth_info == right_info || SaysRectified(depth);
}

std::vector<const RosType*> TypesOf(RosRole role) {
  switch (role) {
    case RosRole::kLeft:
    case RosRole::kRight:
    case RosRole::kDepth:
      return {&RosTypeOf<RosImage>(), &RosTypeOf<RosCompressedImage>()};
    case RosRole::kPoints:
      return {&RosTypeOf<RosPointCloud>()};
    case RosRole::kTf:
      return {&RosTypeOf<RosTransforms>()};
    case RosRole::kLeftInfo:
    case RosRole::kRightInfo:
    case RosRole::kDepthInfo:
      break;
  }
  return {&RosTypeOf<RosCameraInfo>()};
}

RosSettings ParseRosSource(const std::string& source) {
  RosSettings settings;
  std::vector<scenes::SourceOption> options;
  if (source.starts_with(kRos2)) {
    options = scenes::SourceOptions(std::string_view(source).substr(kRos2.size()));
  } else {
    scenes::SplitSourceText split = scenes::SplitSource(source);
    settings.file = split.place.substr(kMcap.size());
    options = std::move(split.options);
    if (settings.file.empty()) throw Bad(source, "no file");
  }
  if (settings.file.empty()) settings.domain = DomainOfEnvironment(source);
  for (const scenes::SourceOption& option : options) {
    if (!Apply(option, settings)) {
      throw Bad(source, "cannot be used: '" + std::string(option.text) + "'");
    }
  }
  if (settings.left.empty() || settings.right.empty()) {
    throw Bad(source, "no topic of the left or right images");
  }
  if (!settings.points.empty() && !settings.depth.empty()) {
    throw Bad(source, "points and depth: one range sensor");
  }
  if (settings.left_from_range && settings.points.empty() && settings.depth.empty()) {
    throw Bad(source, "pose, but neither points nor depth");
  }
  CompleteNames(settings);
  RequireDifferentTopics(source, settings);
  return settings;
}

}  // namespace sprout::capture
