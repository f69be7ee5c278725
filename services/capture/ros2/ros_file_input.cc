#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/joined.h"
#include "common/ros/chunk_codec.h"
#include "common/ros/mcap_reader.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {
namespace {

// Names of a recording may have no slash in front.
std::string WithSlash(const std::string& topic) {
  return topic.starts_with('/') ? topic : "/" + topic;
}

bool IsTransforms(const McapTopic& topic) { return topic.type == RosTypeOf<RosTransforms>().name; }

class FileInput : public RosInput {
 public:
  FileInput(const RosSettings& settings, RosReports reports)
      : path_(settings.file),
        reports_(std::move(reports)),
        reader_(std::make_unique<McapReader>(McapParts(path_))),
        topics_(reader_->Topics()) {
    for (const RosRole role : kAllRosRoles) {
      for (const std::string& topic : settings.TopicsOf(role)) roles_[topic].push_back(role);
    }
    RequireTopics(settings);
    if (!settings.TopicsOf(RosRole::kTf).empty()) LookForTransforms(settings);
  }

  bool is_live() const override { return false; }

  void StartImages(const RosLimits& /*limits*/) override {
    try {
      reader_ = std::make_unique<McapReader>(McapParts(path_));
    } catch (const ConfigError& e) {
      throw ConfigError(std::string("capture.source = mcap: ") + e.what());
    }
    roles_to_come_.clear();
  }

  bool Next(RosBytes& message, const std::stop_token& stop,
            Clock::time_point /*deadline*/) override {
    while (roles_to_come_.empty() && !stop.stop_requested() && reader_->Next(read_)) TakeMessage();
    if (!roles_to_come_.empty()) {
      message = {.role = roles_to_come_.back(), .is_compressed = is_compressed_, .cdr = cdr_};
      roles_to_come_.pop_back();
      return true;
    }
    if (!std::exchange(has_told_, true)) {
      for (const std::string& line : reader_->trouble()) reports_.tell(path_ + ": " + line);
    }
    return false;
  }

  std::string Note() const override { return note_; }

  std::string Alternatives(RosRole /*role*/) override { return TopicsText(); }

 private:
  // Names the file's damage as well, since a missing topic may be in the damaged part.
  std::string TopicsText() const {
    std::string text = "topics in " + path_ + ":";
    for (const McapTopic& topic : topics_) text += " " + topic.name + " (" + topic.type + ")";
    const std::vector<std::string> damage = reader_->trouble();
    return text + (damage.empty() ? "" : "; the file is damaged: " + damage.front());
  }

  // Checked before reading, so that nobody waits for the file's end to learn of a misspelt topic.
  void RequireTopics(const RosSettings& settings) const {
    std::vector<std::string> missing;
    for (const RosRole role : kAllRosRoles) {
      if (role == RosRole::kTf && settings.tf.empty()) continue;
      for (const std::string& name : settings.TopicsOf(role)) {
        const auto found = std::ranges::find(
            topics_, name, [](const McapTopic& topic) { return WithSlash(topic.name); });
        if (found != topics_.end()) {
          RequireType(role, *found);
        } else if (std::ranges::find(missing, name) == missing.end()) {
          missing.push_back(name);
        }
      }
    }
    if (!missing.empty()) {
      throw ConfigError("no topic " + Joined(", ", missing) + "; " + TopicsText());
    }
  }

  void RequireType(RosRole role, const McapTopic& topic) const {
    if (topic.encoding == "ros1") {
      throw ConfigError(topic.name + " is in " + path_ +
                        ", but in ROS 1's encoding: make a bag of ROS 2 of the ROS 1 bag with "
                        "rosbags-convert (of Python's package rosbags)");
    }
    const std::vector<const RosType*> types = TypesOf(role);
    const bool is_of_type = std::ranges::find(types, topic.type, &RosType::name) != types.end();
    if (is_of_type && topic.encoding == "cdr") return;
    std::string allowed = types[0]->name;
    if (types.size() > 1) allowed += std::string(" and ") + types[1]->name;
    throw ConfigError(topic.name + " in " + path_ + " has type " + topic.type + " in encoding " +
                      topic.encoding + "; allowed is " + allowed + " in cdr");
  }

  // Finds the transforms of a robot with a namespace of its own, whose cameras have none.
  void LookForTransforms(const RosSettings& settings) {
    std::set<std::string> namespaces;
    for (const McapTopic& topic : topics_) {
      const std::string name = WithSlash(topic.name);
      if (!IsTransforms(topic)) continue;
      if (roles_.contains(name)) return;
      namespaces.insert(name.substr(0, name.rfind('/')));
    }
    const bool has_range = !settings.points.empty() || !settings.depth.empty();
    if (namespaces.size() != 1 || !has_range || settings.left_from_range) return;
    for (const std::string& topic : TransformTopics("/")) {
      roles_[*namespaces.begin() + topic].push_back(RosRole::kTf);
    }
    note_ = path_ + ": transforms are those of " + *namespaces.begin() + "/tf_static, /tf";
  }

  void TakeMessage() {
    const auto roles = roles_.find(WithSlash(read_.channel->topic));
    if (roles == roles_.end() || read_.channel->encoding != "cdr" || read_.schema == nullptr)
      return;
    cdr_ = read_.data;
    if (IsZstd(cdr_)) {
      Result<McapBytes> unpacked = UnpackMessage(cdr_);
      if (!unpacked && wrong_.insert(read_.channel->topic).second) {
        reports_.tell(path_ + ": " + read_.channel->topic + ": " + unpacked.error().text);
      }
      unpacked_ = unpacked ? std::move(*unpacked) : McapBytes();
      cdr_ = unpacked_;
    }
    is_compressed_ = read_.schema->name == RosTypeOf<RosCompressedImage>().name;
    for (const RosRole role : roles->second) {
      const std::vector<const RosType*> types = TypesOf(role);
      if (std::ranges::find(types, read_.schema->name, &RosType::name) != types.end()) {
        roles_to_come_.push_back(role);
      }
    }
  }

  std::string path_;
  RosReports reports_;
  std::unique_ptr<McapReader> reader_;
  std::vector<McapTopic> topics_;
  std::string note_;
  std::map<std::string, std::vector<RosRole>> roles_;  // of a topic, with a slash in front
  McapMessage read_;
  std::vector<RosRole> roles_to_come_;  // roles of the message in which it was not given yet
  bool is_compressed_ = false;
  std::span<const uint8_t> cdr_;
  McapBytes unpacked_;
  std::set<std::string> wrong_;  // topics with a message that cannot be unpacked
  bool has_told_ = false;
};

}  // namespace

std::unique_ptr<RosInput> ReadRosFile(const RosSettings& settings, RosReports reports) {
  try {
    return std::make_unique<FileInput>(settings, std::move(reports));
  } catch (const ConfigError& e) {
    throw ConfigError(std::string("capture.source = mcap: ") + e.what());
  }
}

}  // namespace sprout::capture
