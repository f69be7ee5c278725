#include <map>
#include <set>

#include "common/config/config_error.h"
#include "common/mcap/mcap_reader.h"
#include "common/ros2/ros_type.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {
namespace {

// The types that a topic may have; the second one of images.
std::vector<const RosType*> TypesOf(RosRole role) {
  switch (role) {
    case RosRole::kLeft:
    case RosRole::kRight:
      return {&RosTypeOf<RosImage>(), &RosTypeOf<RosCompressedImage>()};
    case RosRole::kDepth:
      return {&RosTypeOf<RosImage>()};
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

class FileInput : public RosInput {
 public:
  FileInput(const RosSettings& settings, TellPeople tell)
      : path_(settings.file), tell_(std::move(tell)), reader_(path_) {
    for (size_t i = 0; i < kRosRoles; ++i) {
      const auto role = static_cast<RosRole>(i);
      if (const std::string& topic = settings.TopicOf(role); !topic.empty()) roles_[topic] = role;
    }
  }

  bool is_live() const override { return false; }

  bool Next(RosBytes& message, const std::stop_token& stop) override {
    for (McapMessage read; !stop.stop_requested() && reader_.Next(read);) {
      const std::string& topic = read.channel->topic;
      const std::string type = read.schema != nullptr ? read.schema->name : "";
      if (met_.insert(topic + " (" + type + ")").second && met_.size() > kMostTopics) met_.clear();
      const auto role = roles_.find(topic);
      if (role == roles_.end() || read.channel->encoding != "cdr") continue;
      const std::vector<const RosType*> types = TypesOf(role->second);
      size_t which = 0;
      while (which < types.size() && types[which]->name != type) ++which;
      if (which == types.size()) {
        if (wrong_.insert(topic).second) {
          tell_(path_ + ": " + topic + " has type " + type + "; allowed is " + types[0]->name);
        }
        continue;
      }
      message = {.role = role->second, .is_compressed = which == 1, .cdr = read.data};
      return true;
    }
    if (!has_told_) {
      for (const std::string& line : reader_.trouble()) tell_(path_ + ": " + line);
    }
    has_told_ = true;
    return false;
  }

  std::string Instead(RosRole /*role*/) override {
    std::string text = "topics in " + path_ + ":";
    for (const std::string& topic : met_) text += " " + topic;
    return text;
  }

 private:
  static constexpr size_t kMostTopics = 1000;
  std::string path_;
  TellPeople tell_;
  McapReader reader_;
  std::map<std::string, RosRole> roles_;
  std::set<std::string> met_;
  std::set<std::string> wrong_;
  bool has_told_ = false;
};

}  // namespace

std::unique_ptr<RosInput> ReadRosFile(const RosSettings& settings, TellPeople tell) {
  try {
    return std::make_unique<FileInput>(settings, std::move(tell));
  } catch (const McapError& e) {
    throw ConfigError(std::string("capture.source = mcap:") + e.what());
  }
}

}  // namespace sprout::capture
