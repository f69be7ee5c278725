// Nodes of ROS 2 on Fast DDS, its default middleware. Shares nothing with Sprout.
//   fast_peer send DOMAIN RIG WIDTHxHEIGHT HZ SECONDS [best_effort] [info=volatile|latched|none]
//       [encoding=mono8] [wait=SECONDS for a subscriber, 10] [points] [texture] [focal_at=N]
//       [jump_at=N jump_s=S] [huge=BYTES]
//     RIG/left|right/image_rect and /camera_info, texture: of a wall 2 m ahead; from frame N on
//     another focal length, or stamps S seconds away; images of BYTES whatever their size says
//   fast_peer hear DOMAIN SECONDS [best_effort] [latched] TOPIC=image|info|points|compressed|tf...
//     counts messages, those of no new stamp apart; SIGTERM ends it
//   fast_peer graph DOMAIN SECONDS [localhost]     participants, endpoints and nodes
//   fast_peer many DOMAIN SECONDS COUNT            publishers of strings
//   fast_peer strings DOMAIN SECONDS HZ TOPIC      strings that say they are images
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <set>
#include <sstream>
#include <thread>

#include "fast_camera.h"

namespace sprout::fast_peer {
namespace {

using eprosima::fastrtps::types::ReturnCode_t;

int Send(int count, char** words) {
  if (count < 5) return 2;
  unsigned width = 0;
  unsigned height = 0;
  if (std::sscanf(words[2], "%ux%u", &width, &height) != 2) return 2;
  const double hz = std::atof(words[3]);
  const double seconds = std::atof(words[4]);
  const Options options(count - 5, words + 5);
  Node node(std::atoi(words[0]));
  Camera camera(node, words[1], width, height, options);
  camera.WaitForSubscriber();
  SleepTo(Now() + 1);  // until the subscriber knows us, too
  int sent = 0;
  for (const double begin = Now(); sent < hz * seconds && !has_to_end; ++sent) {
    SleepTo(begin + sent / hz);
    camera.Send(sent);
  }
  SleepTo(Now() + 1);  // what is asked for again
  std::printf("sent %d, failed %d\n", sent, camera.failed());
  return 0;
}

// What came on a topic.
struct Heard {
  std::string topic;
  dds::DataReader* reader = nullptr;
  std::function<void(Heard&)> take;
  long messages = 0;
  std::set<double> stamps;
  unsigned long long bytes = 0;
  double last = 0, longest_pause_s = 0;
  std::vector<double> ages_s;
  std::string about;
};

template <typename Message>
double StampOf(const Message& message) {
  const auto& stamp = message.header().stamp();
  return stamp.sec() + stamp.nanosec() * 1e-9;
}
double StampOf(const tf2_msgs::msg::TFMessage&) { return 0; }

size_t SizeOf(const CameraInfo&) { return 0; }
size_t SizeOf(const tf2_msgs::msg::TFMessage& tf) { return tf.transforms().size(); }
template <typename Message>
size_t SizeOf(const Message& message) {
  return message.data().size();
}

template <typename Message>
std::string About(const Message&) {
  return "";
}
std::string About(const sensor_msgs::msg::CompressedImage& image) { return image.format(); }
std::string About(const sensor_msgs::msg::PointCloud2& cloud) {
  return std::to_string(cloud.width()) + "x" + std::to_string(cloud.height()) +
         (cloud.is_dense() ? " dense" : " with NaN");
}

template <typename Type>
void TakeAll(Heard& heard) {
  typename Type::type message;
  dds::SampleInfo info;
  while (heard.reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data) continue;
    const double now = Now();
    if (heard.messages > 0) {
      heard.longest_pause_s = std::max(heard.longest_pause_s, now - heard.last);
    }
    heard.last = now;
    if (heard.messages++ == 0) {
      std::printf("first message of %s\n", heard.topic.c_str());
      std::fflush(stdout);
    }
    heard.stamps.insert(StampOf(message));
    heard.ages_s.push_back(now - StampOf(message));
    heard.bytes += SizeOf(message);
    heard.about = About(message);
  }
}

template <typename Type>
void Listen(Node& node, const Qos& qos, Heard& heard) {
  heard.reader = node.Reader<Type>("rt" + heard.topic, qos);
  heard.take = &TakeAll<Type>;
}

void Report(Heard& heard) {
  std::sort(heard.ages_s.begin(), heard.ages_s.end());
  const auto rank = static_cast<size_t>(std::ceil(0.99 * static_cast<double>(heard.ages_s.size())));
  std::printf("%s %ld messages %llu bytes; %zu stamps, longest pause %.2f s, age p99 %.0f ms %s\n",
              heard.topic.c_str(), heard.messages, heard.bytes, heard.stamps.size(),
              heard.longest_pause_s, rank == 0 ? 0 : 1e3 * heard.ages_s[rank - 1],
              heard.about.c_str());
}

int Hear(int count, char** words) {
  if (count < 3) return 2;
  const Options options(count - 2, words + 2);
  const Qos qos{.reliable = !options.Has("best_effort"), .latched = options.Has("latched")};
  Node node(std::atoi(words[0]));
  std::vector<Heard> all;
  for (const std::string& word : options.words()) {
    const size_t equals = word.find('=');
    if (equals == std::string::npos) continue;
    const std::string type = word.substr(equals + 1);
    Heard heard;
    heard.topic = word.substr(0, equals);
    if (type == "image") Listen<sensor_msgs::msg::ImagePubSubType>(node, qos, heard);
    if (type == "info") Listen<sensor_msgs::msg::CameraInfoPubSubType>(node, qos, heard);
    if (type == "points") Listen<sensor_msgs::msg::PointCloud2PubSubType>(node, qos, heard);
    if (type == "compressed") Listen<sensor_msgs::msg::CompressedImagePubSubType>(node, qos, heard);
    if (type == "tf") Listen<tf2_msgs::msg::TFMessagePubSubType>(node, {.latched = true}, heard);
    if (heard.reader == nullptr) return 2;
    all.push_back(std::move(heard));
  }
  for (const double end = Now() + std::atof(words[1]); Now() < end && !has_to_end;) {
    for (Heard& heard : all) heard.take(heard);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  for (Heard& heard : all) Report(heard);
  return 0;
}

int ShowGraph(int count, char** words) {
  if (count < 2) return 2;
  Node node(std::atoi(words[0]), Options(count - 2, words + 2).Has("localhost"));
  using InfoType = rmw_dds_common::msg::ParticipantEntitiesInfoPubSubType;
  dds::DataReader* const infos = node.Reader<InfoType>(
      "ros_discovery_info", {.reliable = true, .latched = true, .depth = 100});
  SleepTo(Now() + std::atof(words[1]));
  for (const auto& [guid, one] : node.discovered.participants()) {
    std::printf("participant %s name '%s' user_data '%s'\n", guid.c_str(), one.name.c_str(),
                one.user_data.c_str());
  }
  for (const auto& [guid, one] : node.discovered.endpoints()) {
    std::printf("%s %s %s %s %s user_data '%s' guid %s\n", one.writes ? "writer" : "reader",
                one.topic.c_str(), one.type.c_str(), one.reliable ? "reliable" : "best_effort",
                one.latched ? "latched" : "volatile", one.user_data.c_str(), guid.c_str());
  }
  rmw_dds_common::msg::ParticipantEntitiesInfo of_one;
  dds::SampleInfo info;
  while (infos->take_next_sample(&of_one, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data) continue;
    for (const auto& one : of_one.node_entities_info_seq()) {
      std::printf("node %s%s readers %zu writers %zu", one.node_namespace().c_str(),
                  one.node_name().c_str(), one.reader_gid_seq().size(),
                  one.writer_gid_seq().size());
      // GIDs are GUIDs: those of which discovery knows the endpoints.
      size_t known = 0;
      for (const auto* gids : {&one.reader_gid_seq(), &one.writer_gid_seq()}) {
        for (const auto& gid : *gids) {
          rtps::GUID_t guid;
          std::memcpy(guid.guidPrefix.value, gid.data().data(), 12);
          std::memcpy(guid.entityId.value, gid.data().data() + 12, 4);
          std::ostringstream text;
          text << guid;
          known += node.discovered.endpoints().count(text.str());
        }
      }
      std::printf(" known %zu\n", known);
    }
  }
  return 0;
}

int ManyTopics(int count, char** words) {
  if (count < 3) return 2;
  Node node(std::atoi(words[0]));
  for (int i = 0; i < std::atoi(words[2]); ++i) {
    node.Writer<std_msgs::msg::StringPubSubType>("rt/many/topic_" + std::to_string(i), {});
  }
  std::printf("made\n");
  std::fflush(stdout);
  SleepTo(Now() + std::atof(words[1]));
  return 0;
}

int SendStrings(int count, char** words) {
  if (count < 4) return 2;
  Node node(std::atoi(words[0]));
  dds::DataWriter* const writer = node.Writer<std_msgs::msg::StringPubSubType>(
      std::string("rt") + words[3], {}, "sensor_msgs::msg::dds_::Image_");
  std_msgs::msg::String text;
  text.data("no image");
  const double hz = std::atof(words[2]);
  const int messages = static_cast<int>(hz * std::atof(words[1]));
  const double begin = Now();
  for (int i = 0; i < messages && !has_to_end; ++i) {
    SleepTo(begin + i / hz);
    writer->write(&text);
  }
  return 0;
}

int Main(int argc, char** argv) {
  std::signal(SIGTERM, [](int) { has_to_end = 1; });
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "send") return Send(argc - 2, argv + 2);
  if (what == "hear") return Hear(argc - 2, argv + 2);
  if (what == "graph") return ShowGraph(argc - 2, argv + 2);
  if (what == "many") return ManyTopics(argc - 2, argv + 2);
  if (what == "strings") return SendStrings(argc - 2, argv + 2);
  return 2;
}

}  // namespace
}  // namespace sprout::fast_peer

int main(int argc, char** argv) {
  const int result = sprout::fast_peer::Main(argc, argv);
  std::fflush(stdout);
  std::_Exit(result);  // Fast DDS waits for peers that are gone
}
