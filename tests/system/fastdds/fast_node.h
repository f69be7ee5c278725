#pragma once

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>

#include "fast_peerPubSubTypes.h"

// A node of ROS 2 as rmw_fastrtps makes one, on Fast DDS alone: the QoS of its entities are those
// that its sources set (data sharing off, written synchronously, XCDR1, no type objects).
namespace sprout::fast_peer {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

/// How a topic's messages travel.
struct Qos {
  bool reliable = true;
  bool latched = false;
  int depth = 5;  ///< keep last
};

/// What discovery told about the others.
class Discovered : public dds::DomainParticipantListener {
 public:
  struct Endpoint {
    bool writes = false;
    std::string topic, type, user_data;
    bool reliable = false, latched = false;
  };
  struct Participant {
    std::string name, user_data;
  };

  std::map<std::string, Participant> participants() const;  ///< by GUID
  std::map<std::string, Endpoint> endpoints() const;        ///< by GUID

  void on_participant_discovery(dds::DomainParticipant*,
                                rtps::ParticipantDiscoveryInfo&& info) override;
  void on_subscriber_discovery(dds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) override;
  void on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, Participant> participants_;
  std::map<std::string, Endpoint> endpoints_;
};

/// A participant with one publisher and one subscriber.
class Node {
 public:
  /// @param on_localhost  discovers as ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST does: no multicast,
  ///                      the others on this host are peers.
  explicit Node(int domain, bool on_localhost = false);

  template <typename Type>
  dds::DataWriter* Writer(const std::string& topic, const Qos& qos,
                          const char* type_name = nullptr) {
    dds::DataWriterQos to = publisher_->get_default_datawriter_qos();
    to.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
    to.representation().m_value.push_back(dds::XCDR_DATA_REPRESENTATION);
    Set(qos, to);
    return Made(publisher_->create_datawriter(TopicOf<Type>(topic, type_name), to), topic);
  }

  template <typename Type>
  dds::DataReader* Reader(const std::string& topic, const Qos& qos,
                          dds::DataReaderListener* listener = nullptr) {
    dds::DataReaderQos to = subscriber_->get_default_datareader_qos();
    to.type_consistency().representation.m_value.push_back(dds::XCDR_DATA_REPRESENTATION);
    Set(qos, to);
    return Made(subscriber_->create_datareader(TopicOf<Type>(topic, nullptr), to, listener), topic);
  }

  Discovered discovered;

 private:
  template <typename DdsQos>
  static void Set(const Qos& qos, DdsQos& to) {
    to.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    to.data_sharing().off();
    to.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    to.history().depth = qos.depth;
    to.durability().kind =
        qos.latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    to.reliability().kind =
        qos.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  }

  template <typename Type>
  dds::Topic* TopicOf(const std::string& name, const char* type_name) {
    dds::TypeSupport type(new Type());
    if (type_name != nullptr) type->setName(type_name);
    type->auto_fill_type_object(false);
    type->auto_fill_type_information(false);
    type.register_type(participant_);
    dds::Topic*& topic = topics_[name];
    if (topic == nullptr) {
      topic = participant_->create_topic(name, type.get_type_name(),
                                         participant_->get_default_topic_qos());
    }
    return Made(topic, name);
  }

  template <typename T>
  static T* Made(T* entity, const std::string& topic) {
    if (entity == nullptr) throw std::runtime_error("Fast DDS makes nothing of " + topic);
    return entity;
  }

  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
  std::map<std::string, dds::Topic*> topics_;
};

}  // namespace sprout::fast_peer
