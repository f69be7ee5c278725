#include "common/ros2/ros_node.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <string_view>

namespace sprout {
namespace {

// An image is thousands of Cyclone's default datagrams. 64 kB are the most that UDP has, and what
// Fast DDS sends; its receive buffer must hold the burst of an image. What CYCLONEDDS_URI says
// comes behind and counts.
constexpr char kNetwork[] =
    "<General><MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize></General>"
    "<Internal><SocketReceiveBufferSize min=\"default\" max=\"32MB\"/></Internal>";

int32_t Checked(int32_t handle, const std::string& what) {
  if (handle >= 0) return handle;
  throw RosError("DDS: " + what + ": " + dds_strretcode(-handle));
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
// How long a reliable writer waits for its readers before it gives a message up.
constexpr dds_duration_t kMaxBlocking = DDS_MSECS(100);

std::unique_ptr<dds_qos_t, QosDeleter> MakeQos(const RosQos& qos) {
  std::unique_ptr<dds_qos_t, QosDeleter> dds(dds_create_qos());
  dds_qset_reliability(dds.get(),
                       qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kMaxBlocking);
  dds_qset_durability(dds.get(),
                      qos.latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(dds.get(), qos.depth == 0 ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST,
                   std::max(qos.depth, 1));
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(dds.get(), 1, &xcdr1);
  return dds;
}

// ROS's topics are those of DDS behind "rt".
std::string DdsName(const std::string& topic) { return "rt" + topic; }

}  // namespace

RosNode::RosNode(int domain) {
  const char* const asked = std::getenv("CYCLONEDDS_URI");
  std::string config =
      std::string("<CycloneDDS><Domain id=\"any\">") + kNetwork + "</Domain></CycloneDDS>";
  if (asked != nullptr && *asked != '\0') config += std::string(",") + asked;
  // Of one that is there already, another node of this process made it.
  const int32_t made = dds_create_domain(static_cast<dds_domainid_t>(domain), config.c_str());
  if (made < 0 && made != DDS_RETCODE_PRECONDITION_NOT_MET) {
    Checked(made, "domain " + std::to_string(domain));
  }
  participant_ =
      Checked(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr),
              "no participant of domain " + std::to_string(domain));
  publications_ =
      Checked(dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
              "no discovery");
  waitset_ = Checked(dds_create_waitset(participant_), "no waitset");
}

RosNode::~RosNode() { dds_delete(participant_); }

RosNode::Handle RosNode::AddTopic(const std::string& topic, const RosType& type) {
  return Checked(dds_create_topic(participant_, type.dds, DdsName(topic).c_str(), nullptr, nullptr),
                 "topic " + topic);
}

RosNode::Handle RosNode::AddReader(const std::string& topic, const RosType& type,
                                   const RosQos& qos) {
  const Handle reader =
      Checked(dds_create_reader(participant_, AddTopic(topic, type), MakeQos(qos).get(), nullptr),
              "reader of " + topic);
  Checked(dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS), "status");
  Checked(dds_waitset_attach(waitset_, reader, reader), "waitset");
  return reader;
}

RosNode::Handle RosNode::AddWriter(const std::string& topic, const RosType& type,
                                   const RosQos& qos) {
  return Checked(
      dds_create_writer(participant_, AddTopic(topic, type), MakeQos(qos).get(), nullptr),
      "writer of " + topic);
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

bool RosNode::Take(Handle reader, std::vector<uint8_t>& cdr) {
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info{};
  while (dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) == 1) {
    // Of a publisher that is gone there is a sample without data.
    if (info.valid_data) {
      cdr.resize(ddsi_serdata_size(data));
      ddsi_serdata_to_ser(data, 0, cdr.size(), cdr.data());
    }
    ddsi_serdata_unref(data);
    if (info.valid_data) return true;
  }
  return false;
}

void RosNode::Wait(std::chrono::milliseconds longest) {
  std::array<dds_attach_t, 1> triggered{};
  dds_waitset_wait(waitset_, triggered.data(), triggered.size(), DDS_MSECS(longest.count()));
}

RosNode::Publishers RosNode::PublishersOf(const std::string& topic, const RosType& type) const {
  constexpr int kMost = 256;
  std::array<void*, kMost> samples{};
  std::array<dds_sample_info_t, kMost> infos{};
  const dds_return_t count =
      dds_read_mask(publications_, samples.data(), infos.data(), kMost, kMost,
                    DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  Publishers publishers;
  for (size_t i = 0; static_cast<dds_return_t>(i) < count; ++i) {
    const auto* const endpoint = static_cast<const dds_builtintopic_endpoint_t*>(samples.at(i));
    if (!infos.at(i).valid_data || endpoint->topic_name != DdsName(topic)) continue;
    const bool is_of_type = endpoint->type_name == std::string_view(type.dds->m_typename);
    ++(is_of_type ? publishers.of_type : publishers.of_others);
    if (!is_of_type) publishers.other_type = endpoint->type_name;
  }
  if (count > 0) dds_return_loan(publications_, samples.data(), count);
  return publishers;
}

}  // namespace sprout
