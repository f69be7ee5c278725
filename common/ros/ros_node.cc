#include "common/ros/ros_node.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsrt/log.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "common/core/printable.h"

namespace sprout {
namespace {

int32_t Checked(int32_t handle, const std::string& what) {
  if (handle >= 0) return handle;
  throw ConfigError("DDS: " + what + ": " + dds_strretcode(-handle));
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using QosPtr = std::unique_ptr<dds_qos_t, QosDeleter>;

void SetUserData(dds_qos_t* qos, const std::string& text) {
  dds_qset_userdata(qos, text.data(), text.size());
}

QosPtr MakeQos(const RosQos& qos) {
  QosPtr dds(dds_create_qos());
  // The time is of no account: a writer that keeps the last messages waits for nobody.
  dds_qset_reliability(dds.get(),
                       qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_durability(dds.get(),
                      qos.latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(dds.get(), DDS_HISTORY_KEEP_LAST, qos.depth);
  if (qos.latched) {
    dds_qset_durability_service(dds.get(), 0, DDS_HISTORY_KEEP_LAST, qos.depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(dds.get(), 1, &xcdr1);
  return dds;
}

QosPtr MakeQos(const RosQos& qos, const RosType& type) {
  QosPtr dds = MakeQos(qos);
  SetUserData(dds.get(), std::string("typehash=") + type.hash + ";");
  return dds;
}

// ROS's topics are those of DDS behind "rt".
std::string DdsName(const std::string& topic) { return "rt" + topic; }

// The QoS that an endpoint known to discovery offers.
RosQos OfferedBy(const dds_qos_t* qos) {
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_duration_t ignored = 0;
  dds_qget_reliability(qos, &reliability, &ignored);
  dds_qget_durability(qos, &durability);
  return {.reliable = reliability == DDS_RELIABILITY_RELIABLE,
          .latched = durability >= DDS_DURABILITY_TRANSIENT_LOCAL};
}

std::string PolicyName(uint32_t policy) {
  static const std::map<uint32_t, std::string> kNames = {
      {DDS_DURABILITY_QOS_POLICY_ID, "DURABILITY"},
      {DDS_DEADLINE_QOS_POLICY_ID, "DEADLINE"},
      {DDS_LATENCYBUDGET_QOS_POLICY_ID, "LATENCY_BUDGET"},
      {DDS_OWNERSHIP_QOS_POLICY_ID, "OWNERSHIP"},
      {DDS_LIVELINESS_QOS_POLICY_ID, "LIVELINESS"},
      {DDS_RELIABILITY_QOS_POLICY_ID, "RELIABILITY"},
      {DDS_DATA_REPRESENTATION_QOS_POLICY_ID, "DATA_REPRESENTATION"}};
  const auto name = kNames.find(policy);
  return name != kNames.end() ? name->second : "policy " + std::to_string(policy);
}

void OnLog(void* warn, const dds_log_data_t* data) {
  if ((data->priority & (DDS_LC_FATAL | DDS_LC_ERROR | DDS_LC_WARNING)) == 0) return;
  std::string text(data->message, data->size);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const bool is_of_message = text.find("deserialization") != std::string::npos ||
                             text.find("oversize") != std::string::npos;
  (*static_cast<RosWarnings::Warn*>(warn))("DDS: " + text, is_of_message);
}

// A domain and its other configuration, for errors: DDS does not say which of them is wrong.
std::string PlaceOf(int domain) {
  const std::string place = "domain " + std::to_string(domain);
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  return uri == nullptr ? place : place + " with CYCLONEDDS_URI = '" + Printable(uri) + "'";
}

template <size_t kBytes>
void SetBounded(char (&field)[kBytes], std::string_view text) {
  const size_t size = std::min(text.size(), kBytes - 1);
  std::memcpy(field, text.data(), size);
  field[size] = '\0';
}

void SetGid(RosGid& gid, dds_entity_t entity) {
  dds_guid_t guid{};
  dds_get_guid(entity, &guid);
  static_assert(sizeof guid.v == sizeof gid.data);
  std::memcpy(gid.data, guid.v, sizeof gid.data);
}

void SetGids(auto& sequence, const std::vector<RosNode::Handle>& entities) {
  const std::span gids = ResizeRos(sequence, entities.size());
  for (size_t i = 0; i < gids.size(); ++i) SetGid(gids[i], entities[i]);
}

}  // namespace

RosWarnings::RosWarnings(Warn warn) : warn_(std::make_unique<Warn>(std::move(warn))) {
  dds_set_log_sink(&OnLog, warn_.get());
}

RosWarnings::~RosWarnings() { dds_set_log_sink(nullptr, nullptr); }

RosNode::RosNode(const RosNodeOptions& options) : name_(options.name) {
  const auto domain = static_cast<dds_domainid_t>(options.domain);
  const std::string place = PlaceOf(options.domain);
  const int32_t made = dds_create_domain(domain, CycloneConfig(options.max_message_bytes).c_str());
  // If the domain exists already, another node of this process made it.
  if (made != DDS_RETCODE_PRECONDITION_NOT_MET) domain_ = Checked(made, place);
  try {
    const QosPtr qos(dds_create_qos());
    SetUserData(qos.get(), "enclave=/;");
    participant_ =
        Checked(dds_create_participant(domain, qos.get(), nullptr), "no participant of " + place);
    publications_ = Checked(
        dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
        "no discovery");
    waitset_ = Checked(dds_create_waitset(participant_), "no waitset");
    const RosType& type = RosTypeOf<RosParticipantEntities>();
    const Handle topic = Checked(
        dds_create_topic(participant_, type.dds, "ros_discovery_info", nullptr, nullptr), "graph");
    graph_ =
        Checked(dds_create_writer(
                    participant_, topic,
                    MakeQos({.reliable = true, .latched = true, .depth = 1}, type).get(), nullptr),
                "graph");
  } catch (...) {
    dds_delete(domain_ > 0 ? domain_ : participant_);
    throw;
  }
}

RosNode::~RosNode() { dds_delete(domain_ > 0 ? domain_ : participant_); }

RosNode::Handle RosNode::AddTopic(const std::string& topic, const RosType& type) {
  return Checked(dds_create_topic(participant_, type.dds, DdsName(topic).c_str(), nullptr, nullptr),
                 "topic " + topic);
}

RosNode::Handle RosNode::AddReader(const std::string& topic, const RosType& type,
                                   const RosQos& qos) {
  const Handle reader = Checked(
      dds_create_reader(participant_, AddTopic(topic, type), MakeQos(qos, type).get(), nullptr),
      "reader of " + topic);
  Reader& counts = readers_[reader];
  counts.depth = qos.depth;
  const std::unique_ptr<dds_listener_t, decltype(&dds_delete_listener)> listener(
      dds_create_listener(&counts.came), dds_delete_listener);
  dds_lset_data_available(listener.get(), [](dds_entity_t, void* came) {
    ++*static_cast<std::atomic<int64_t>*>(came);  // once a message
  });
  Checked(dds_set_listener(reader, listener.get()), "listener");
  // The listener takes the status, so the waitset looks at what there is.
  counts.has_data = Checked(dds_create_readcondition(reader, DDS_ANY_STATE), "condition");
  Checked(dds_waitset_attach(waitset_, counts.has_data, counts.has_data), "waitset");
  return reader;
}

RosNode::Handle RosNode::AddWriter(const std::string& topic, const RosType& type,
                                   const RosQos& qos) {
  writers_.push_back(Checked(
      dds_create_writer(participant_, AddTopic(topic, type), MakeQos(qos, type).get(), nullptr),
      "writer of " + topic));
  return writers_.back();
}

void RosNode::RemoveReader(Handle reader) {
  dds_waitset_detach(waitset_, readers_.at(reader).has_data);
  const dds_entity_t topic = dds_get_topic(reader);
  dds_delete(reader);  // with its condition, and after its listener's last call
  dds_delete(topic);
  readers_.erase(reader);
}

void RosNode::Announce() {
  RosMessage<RosParticipantEntities> info;
  SetGid(info->gid, participant_);
  RosNodeEntities& node = ResizeRos(info->node_entities_info_seq, 1)[0];
  SetBounded(node.node_namespace, "/");
  SetBounded(node.node_name, name_);
  std::vector<Handle> readers;
  for (const auto& [reader, counts] : readers_) readers.push_back(reader);
  SetGids(node.reader_gid_seq, readers);
  SetGids(node.writer_gid_seq, writers_);
  Checked(dds_write(graph_, info.data()), "graph");
}

bool RosNode::HasReaders(Handle writer) const {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK &&
         status.current_count > 0;
}

Result<void> RosNode::Write(Handle writer, const AnyRosMessage& message) {
  const dds_return_t written = dds_write(writer, message.data());
  if (written == DDS_RETCODE_OK) return {};
  return Fail(std::string(message.type().name) + ": " + dds_strretcode(-written));
}

std::optional<RosNode::Taken> RosNode::Take(Handle reader, size_t max_bytes,
                                            std::vector<uint8_t>& cdr) {
  Reader& counts = readers_.at(reader);
  const int64_t came = counts.came;
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info{};
  while (dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) == 1) {
    ++counts.taken;
    Taken taken{.bytes = ddsi_serdata_size(data), .publisher = info.publication_handle};
    taken.is_too_big = taken.bytes > max_bytes;
    // A publisher that is gone leaves a sample without data.
    if (info.valid_data && !taken.is_too_big) {
      cdr.resize(taken.bytes);
      ddsi_serdata_to_ser(data, 0, cdr.size(), cdr.data());
    }
    ddsi_serdata_unref(data);
    if (!info.valid_data) continue;
    counts.replaced = std::max(counts.replaced, came - counts.taken - (counts.depth - 1));
    return taken;
  }
  counts.replaced = std::max(counts.replaced, came - counts.taken);
  return std::nullopt;
}

int64_t RosNode::TakeReplaced(Handle reader) {
  Reader& counts = readers_.at(reader);
  return counts.replaced - std::exchange(counts.told, counts.replaced);
}

void RosNode::Wait(std::chrono::milliseconds longest) {
  std::array<dds_attach_t, 1> triggered{};
  dds_waitset_wait(waitset_, triggered.data(), triggered.size(), DDS_MSECS(longest.count()));
}

std::string RosNode::TakeMisfit(Handle reader_or_writer) {
  dds_requested_incompatible_qos_status_t requested{};
  if (dds_get_requested_incompatible_qos_status(reader_or_writer, &requested) == DDS_RETCODE_OK) {
    return requested.total_count_change > 0 ? PolicyName(requested.last_policy_id) : "";
  }
  dds_offered_incompatible_qos_status_t offered{};
  if (dds_get_offered_incompatible_qos_status(reader_or_writer, &offered) != DDS_RETCODE_OK) {
    return "";
  }
  return offered.total_count_change > 0 ? PolicyName(offered.last_policy_id) : "";
}

// A robot of 30 nodes has some hundred endpoints: whatever is new, in pieces.
void RosNode::Discover() {
  constexpr int kPiece = 64;
  std::array<void*, kPiece> samples{};
  std::array<dds_sample_info_t, kPiece> infos{};
  while (true) {
    const dds_return_t count =
        dds_take(publications_, samples.data(), infos.data(), kPiece, kPiece);
    if (count <= 0) return;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      const dds_sample_info_t& info = infos.at(i);
      if (!info.valid_data || info.instance_state != DDS_IST_ALIVE) {
        endpoints_.erase(info.instance_handle);
        continue;
      }
      const auto* const one = static_cast<const dds_builtintopic_endpoint_t*>(samples.at(i));
      endpoints_.insert_or_assign(info.instance_handle,
                                  Endpoint{one->topic_name, one->type_name, OfferedBy(one->qos)});
    }
    dds_return_loan(publications_, samples.data(), count);
    samples.fill(nullptr);
  }
}

RosNode::Publishers RosNode::PublishersOf(const std::string& topic, const RosType& type) {
  Discover();
  Publishers publishers{.offered = {.reliable = true, .latched = true}};
  for (const auto& [handle, endpoint] : endpoints_) {
    if (endpoint.topic != DdsName(topic)) continue;
    if (endpoint.type != type.dds->m_typename) {
      ++publishers.of_others;
      publishers.other_type = endpoint.type;
      continue;
    }
    ++publishers.of_type;
    RosQos& least = publishers.offered;
    least.reliable = least.reliable && endpoint.offered.reliable;
    least.latched = least.latched && endpoint.offered.latched;
  }
  return publishers;
}

std::set<std::string> RosNode::TopicsOf(const RosType& type) {
  Discover();
  std::set<std::string> topics;
  for (const auto& [handle, endpoint] : endpoints_) {
    const bool is_ros = endpoint.topic.starts_with(DdsName("/"));
    if (is_ros && endpoint.type == type.dds->m_typename) {
      topics.insert(endpoint.topic.substr(DdsName("").size()));
    }
  }
  return topics;
}

}  // namespace sprout
