#include "fast_node.h"

#include <sstream>
#include <utility>

namespace sprout::fast_peer {
namespace {

template <typename T>
std::string Text(const T& value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

template <typename Octets>
std::string TextOf(const Octets& octets) {
  return {octets.begin(), octets.end()};
}

Discovered::Endpoint EndpointOf(bool writes, const auto& info) {
  const auto& qos = info.m_qos;
  return {writes,
          info.topicName().to_string(),
          info.typeName().to_string(),
          TextOf(qos.m_userData),
          qos.m_reliability.kind == dds::RELIABLE_RELIABILITY_QOS,
          qos.m_durability.kind == dds::TRANSIENT_LOCAL_DURABILITY_QOS};
}

void ListenOnLocalhost(dds::DomainParticipantQos& qos) {
  auto& builtin = qos.wire_protocol().builtin;
  builtin.metatrafficUnicastLocatorList.push_back(rtps::Locator_t());  // any, so no multicast
  rtps::Locator_t peer;
  rtps::IPLocator::setIPv4(peer, "127.0.0.1");
  builtin.initialPeersList.push_back(peer);
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->maxInitialPeersRange = 32;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(std::move(udp));
}

}  // namespace

std::map<std::string, Discovered::Participant> Discovered::participants() const {
  const std::scoped_lock lock(mutex_);
  return participants_;
}

std::map<std::string, Discovered::Endpoint> Discovered::endpoints() const {
  const std::scoped_lock lock(mutex_);
  return endpoints_;
}

void Discovered::on_participant_discovery(dds::DomainParticipant*,
                                          rtps::ParticipantDiscoveryInfo&& info) {
  const std::scoped_lock lock(mutex_);
  participants_[Text(info.info.m_guid)] = {info.info.m_participantName.to_string(),
                                           TextOf(info.info.m_userData)};
}

void Discovered::on_subscriber_discovery(dds::DomainParticipant*,
                                         rtps::ReaderDiscoveryInfo&& info) {
  const std::scoped_lock lock(mutex_);
  endpoints_[Text(info.info.guid())] = EndpointOf(false, info.info);
}

void Discovered::on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) {
  const std::scoped_lock lock(mutex_);
  endpoints_[Text(info.info.guid())] = EndpointOf(true, info.info);
}

Node::Node(int domain, bool on_localhost) {
  auto* const factory = dds::DomainParticipantFactory::get_instance();
  factory->load_profiles();  // FASTRTPS_DEFAULT_PROFILES_FILE
  dds::DomainParticipantQos qos = factory->get_default_participant_qos();
  const std::string enclave = "enclave=/;";
  qos.user_data().data_vec(std::vector<rtps::octet>(enclave.begin(), enclave.end()));
  qos.name("/");
  auto& builtin = qos.wire_protocol().builtin;
  builtin.readerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  builtin.writerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  if (on_localhost) ListenOnLocalhost(qos);
  participant_ = Made(factory->create_participant(static_cast<uint32_t>(domain), qos, &discovered,
                                                  dds::StatusMask::none()),
                      "a domain");
  publisher_ = Made(participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT), "a publisher");
  subscriber_ = Made(participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "a subscriber");
}

}  // namespace sprout::fast_peer
