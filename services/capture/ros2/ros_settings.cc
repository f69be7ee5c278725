#include "services/capture/ros2/ros_settings.h"

#include <optional>
#include <string_view>

#include "common/config/config_error.h"
#include "common/core/number_text.h"
#include "services/datasets/source_options.h"

namespace sprout::capture {
namespace {

constexpr std::string_view kRos2 = "ros2:";
constexpr std::string_view kMcap = "mcap:";
constexpr std::string_view kCompressed = "/compressed";

ConfigError BadSource(const std::string& source, const std::string& reason) {
  return ConfigError("capture.source = " + source + ": " + reason +
                     "; allowed: left=TOPIC&right=TOPIC with left_info, right_info, points, depth, "
                     "depth_info=TOPIC, rig=FILE, max_spread_ms=0.001 to 1000, and for ros2: "
                     "domain=0 to 232");
}

// "/stereo/left/image_raw/compressed" → "/stereo/left/camera_info"
std::string InfoBeside(std::string topic) {
  if (topic.ends_with(kCompressed)) topic.resize(topic.size() - kCompressed.size());
  const size_t slash = topic.rfind('/');
  return (slash == std::string::npos ? "" : topic.substr(0, slash)) + "/camera_info";
}

std::string* TextOf(RosSettings& settings, std::string_view name) {
  if (name == "left") return &settings.left;
  if (name == "right") return &settings.right;
  if (name == "left_info") return &settings.left_info;
  if (name == "right_info") return &settings.right_info;
  if (name == "points") return &settings.points;
  if (name == "depth") return &settings.depth;
  if (name == "depth_info") return &settings.depth_info;
  if (name == "rig") return &settings.rig;
  return nullptr;
}

// @returns whether it was understood.
bool Apply(const datasets::SourceOption& option, RosSettings& settings) {
  if (std::string* const text = TextOf(settings, option.name)) {
    *text = option.value;
    return !text->empty();
  }
  if (option.name == "max_spread_ms") {
    const std::optional<double> number = ParseNumber<double>(option.value);
    settings.max_spread_ms = number.value_or(0);
    return settings.max_spread_ms >= 0.001 && settings.max_spread_ms <= 1000;
  }
  if (option.name == "domain" && settings.file.empty()) {
    settings.domain = ParseNumber<int>(option.value).value_or(-1);
    return settings.domain >= 0 && settings.domain <= 232;
  }
  return false;
}

void CompleteNames(RosSettings& settings) {
  for (std::string* topic :
       {&settings.left, &settings.right, &settings.left_info, &settings.right_info,
        &settings.points, &settings.depth, &settings.depth_info}) {
    if (!topic->empty() && topic->front() != '/') topic->insert(0, "/");
  }
  const bool is_raw = !settings.rig.empty();
  if (!is_raw && settings.left_info.empty()) settings.left_info = InfoBeside(settings.left);
  if (!is_raw && settings.right_info.empty()) settings.right_info = InfoBeside(settings.right);
  if (!is_raw && !settings.depth.empty() && settings.depth_info.empty()) {
    settings.depth_info = InfoBeside(settings.depth);
  }
}

}  // namespace

const std::string& RosSettings::TopicOf(RosRole role) const {
  static const std::string kTfStatic = "/tf_static";
  switch (role) {
    case RosRole::kLeft:
      return left;
    case RosRole::kRight:
      return right;
    case RosRole::kLeftInfo:
      return left_info;
    case RosRole::kRightInfo:
      return right_info;
    case RosRole::kPoints:
      return points;
    case RosRole::kDepth:
      return depth;
    case RosRole::kDepthInfo:
      return depth_info;
    case RosRole::kTf:
      break;
  }
  return kTfStatic;
}

bool NamesRos(const std::string& source) {
  return source.starts_with(kRos2) || source.starts_with(kMcap);
}

RosSettings ParseRosSource(const std::string& source) {
  RosSettings settings;
  std::vector<datasets::SourceOption> options;
  if (source.starts_with(kRos2)) {
    options = datasets::SourceOptions(std::string_view(source).substr(kRos2.size()));
  } else {
    datasets::SplitSourceText split = datasets::SplitSource(source);
    settings.file = split.place.substr(kMcap.size());
    options = std::move(split.options);
    if (settings.file.empty()) throw BadSource(source, "no file");
  }
  for (const datasets::SourceOption& option : options) {
    if (!Apply(option, settings)) {
      throw BadSource(source, "cannot be used: '" + std::string(option.text) + "'");
    }
  }
  if (settings.left.empty() || settings.right.empty()) {
    throw BadSource(source, "no topic of the left or right images");
  }
  if (!settings.points.empty() && !settings.depth.empty()) {
    throw BadSource(source, "points and depth: one range sensor");
  }
  CompleteNames(settings);
  return settings;
}

}  // namespace sprout::capture
