// A bad network between capture and the stages: what is lost there is counted, and no map is wrong.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <list>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "tests/system/graph.h"
#include "tests/system/graph_record.h"

namespace sprout {
namespace {

constexpr uint16_t kFrom = 7677;
constexpr uint16_t kTo = 7687;

// What a bad network does to datagrams: the share, 0 to 1, of them that it ...
struct NetworkFaults {
  double lost = 0;
  double doubled = 0;    // delivers twice
  double reordered = 0;  // delivers after one to four of those that follow
};

constexpr char kGroup[] = "239.255.76.67";
constexpr size_t kLargestDatagram = 65536;
constexpr int kPollMs = 20;  // without traffic, what waits is delivered

sockaddr_in AddressOf(uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  inet_pton(AF_INET, kGroup, &address.sin_addr);
  return address;
}

int OpenListener(uint16_t port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = AddressOf(port);
  ip_mreq group{};
  group.imr_multiaddr = address.sin_addr;
  const int yes = 1;
  const int buffer = 64 << 20;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) {
    throw std::runtime_error("relay: cannot listen");
  }
  return fd;
}

using Datagram = std::vector<uint8_t>;

// The sockets that stand for the senders.
class Senders {
 public:
  Senders() = default;
  ~Senders() {
    for (const auto& [address, fd] : sockets_) close(fd);
  }
  Senders(const Senders&) = delete;
  Senders& operator=(const Senders&) = delete;

  int SocketOf(const sockaddr_in& sender) {
    const std::pair key{sender.sin_addr.s_addr, sender.sin_port};
    if (const auto found = sockets_.find(key); found != sockets_.end()) return found->second;
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const sockaddr_in to = AddressOf(kTo);
    const int buffer = 8 << 20;
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
      throw std::runtime_error("relay: cannot send");
    }
    return sockets_[key] = fd;
  }

 private:
  std::map<std::pair<in_addr_t, in_port_t>, int> sockets_;
};

void Send(int fd, const Datagram& datagram) {
  static_cast<void>(send(fd, datagram.data(), datagram.size(), 0));
}

struct Waiting {
  int fd;
  Datagram datagram;
  int after;  // so many others
};

// A seeded bad network between two LCM ports of this host: passes what is sent to the group on one
// port on to the other port, datagram by datagram, each sender's from a socket of its own, as LCM
// tells senders apart. One direction only.
class Relay {
 public:
  explicit Relay(uint32_t seed) : random_(seed), socket_(OpenListener(kFrom)) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  ~Relay() {
    thread_.request_stop();
    thread_.join();
    close(socket_);
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  // From now on; none to begin with.
  void Set(const NetworkFaults& faults) {
    lost_share_ = faults.lost;
    doubled_share_ = faults.doubled;
    reordered_share_ = faults.reordered;
  }

  int64_t datagrams() const { return datagrams_; }  // that came
  int64_t lost() const { return lost_; }

 private:
  void Run(const std::stop_token& stop) {
    Senders senders;
    std::list<Waiting> waiting;
    const auto happens = [&](double share) {
      return std::uniform_real_distribution(0.0, 1.0)(random_) < share;
    };
    Datagram datagram(kLargestDatagram);
    pollfd readable{.fd = socket_, .events = POLLIN, .revents = 0};
    while (!stop.stop_requested()) {
      if (poll(&readable, 1, kPollMs) <= 0) {
        for (const Waiting& held : waiting) Send(held.fd, held.datagram);
        waiting.clear();
        continue;
      }
      sockaddr_in sender{};
      socklen_t size = sizeof sender;
      datagram.resize(kLargestDatagram);
      const ssize_t bytes = recvfrom(socket_, datagram.data(), datagram.size(), 0,
                                     reinterpret_cast<sockaddr*>(&sender), &size);
      if (bytes < 0) continue;
      datagram.resize(static_cast<size_t>(bytes));
      ++datagrams_;
      const int fd = senders.SocketOf(sender);
      if (happens(lost_share_)) {
        ++lost_;
      } else if (happens(reordered_share_)) {
        waiting.push_back({fd, datagram, std::uniform_int_distribution(1, 4)(random_)});
        continue;
      } else {
        Send(fd, datagram);
        if (happens(doubled_share_)) Send(fd, datagram);
      }
      for (auto held = waiting.begin(); held != waiting.end();) {
        if (--held->after > 0) {
          ++held;
          continue;
        }
        Send(held->fd, held->datagram);
        held = waiting.erase(held);
      }
    }
  }

  std::mt19937 random_;
  std::atomic<double> lost_share_ = 0;
  std::atomic<double> doubled_share_ = 0;
  std::atomic<double> reordered_share_ = 0;
  std::atomic<int64_t> datagrams_ = 0;
  std::atomic<int64_t> lost_ = 0;
  int socket_;
  std::jthread thread_;  // last: stops before the rest is destroyed
};

std::string Url(uint16_t port) {
  return "udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0&recv_buf_size=67108864";
}

class NetworkFaultsSystem : public ::testing::Test {
 protected:
  NetworkFaultsSystem() {
    for (const char* stage : kChain) {
      Process& process = Start(stage, Url(kTo), {});
      EXPECT_TRUE(stages_.WaitUntil([pid = process.pid()](GraphRecord& r) {
        return r.statuses.contains(pid);
      })) << process.Output();
    }
  }

  Process& Start(const std::string& stage, const std::string& url,
                 const std::vector<std::string>& flags) {
    std::vector<std::string> command = {ProgramPath("sprout-" + stage), "--lcm-url", url,
                                        "--config", "default"};
    command.insert(command.end(), flags.begin(), flags.end());
    return *(processes_[stage] = std::make_unique<Process>(command));
  }

  // Whether a frame that is sent from now on comes through all stages.
  bool Delivers() {
    const size_t sent = capture_.SentNow();
    return stages_.WaitUntil([&](GraphRecord& r) {
      const auto newest = r.frames.rbegin();
      return newest != r.frames.rend() && newest->second.at.contains(Part::kDisparity) &&
             newest->first.second >= static_cast<int64_t>(sent);
    });
  }

  // Three seconds of it, between times when all is well.
  void Run(const NetworkFaults& faults) {
    Process& capture =
        Start("capture", Url(kFrom), {"--source", "synthetic:320x240", "--rate", "10"});
    ASSERT_TRUE(Delivers()) << capture.Output();
    relay_.Set(faults);
    std::this_thread::sleep_for(std::chrono::seconds(3));
    relay_.Set({});
    ASSERT_TRUE(Delivers());
    capture.Signal(SIGTERM);
    ASSERT_EQ(capture.Wait(), 0) << capture.Output();
    ASSERT_TRUE(capture_.WaitUntil([&](GraphRecord& r) {
      const StageStatus& status = r.statuses[capture.pid()];
      return status.state == StageStatus::State::kStopped &&
             status.frames_out == static_cast<int64_t>(r.sent.size());
    }));
  }

  // Every frame that was sent is answered or counted, by every stage.
  void ExpectBalance() {
    const auto sent = static_cast<int64_t>(capture_.SentNow());
    for (const char* stage : kChain) {
      StageStatus status;
      EXPECT_TRUE(stages_.WaitUntil(
          [&](GraphRecord& r) {
            status = r.statuses[processes_.at(stage)->pid()];
            return status.newest_frame.seq == sent - 1 && AccountedFor(status) == sent;
          },
          std::chrono::seconds(10)))
          << stage << ": of " << sent << " frames " << AccountText(status);
      EXPECT_EQ(status.bad_messages, 0) << stage << ": " << status.last_error;
      counted_[stage] = status;
    }
  }

  // What the stages made, beside what capture sent.
  Comparison Compare() {
    std::map<GraphRecord::Key, GraphRecord::Heard> frames = capture_.FramesNow();
    stages_.Now([&](GraphRecord& r) {
      for (auto& [key, heard] : frames) {
        const GraphRecord::Heard& answered = r.frames[key];
        if (!answered.at.contains(Part::kDisparity)) continue;
        heard.at.emplace(Part::kDisparity, answered.at.at(Part::kDisparity));
        heard.frame.disparity = answered.frame.disparity;
        heard.frame.confidence = answered.frame.confidence;
      }
    });
    const Comparison comparison = CompareWithPipeline(frames, LoadConfig({"default"}));
    std::cout << capture_.SentNow() << " frames sent, " << relay_.lost() << " of "
              << relay_.datagrams() << " datagrams lost, " << comparison.maps << " maps, "
              << comparison.wrong << " wrong; grow: " << AccountText(counted_["grow"]) << "\n";
    return comparison;
  }

  // Nothing is lost without being counted, and no map is wrong.
  void RunAndBalance(const NetworkFaults& faults) {
    Run(faults);
    ExpectBalance();
    EXPECT_EQ(Objection(Compare(), 11), "");
  }

  Relay relay_{1};
  GraphRecord capture_{Url(kFrom)};
  GraphRecord stages_{Url(kTo)};
  std::map<std::string, std::unique_ptr<Process>> processes_;
  std::map<std::string, StageStatus> counted_;
};

TEST_F(NetworkFaultsSystem, CountsWhatOnePercentLossTakes) { RunAndBalance({.lost = 0.01}); }

TEST_F(NetworkFaultsSystem, CountsWhatTenPercentLossTakes) {
  RunAndBalance({.lost = 0.1});
  EXPECT_GT(counted_["grow"].frames_incomplete, 0);
}

TEST_F(NetworkFaultsSystem, TakesDatagramsInAnotherOrder) { RunAndBalance({.reordered = 0.1}); }

TEST_F(NetworkFaultsSystem, TakesDatagramsTwice) { RunAndBalance({.doubled = 0.1}); }

TEST_F(NetworkFaultsSystem, TakesAllOfThatAtOnce) {
  RunAndBalance({.lost = 0.01, .doubled = 0.05, .reordered = 0.05});
}

// As an adapter that is unplugged, or a VPN that starts again. Nobody else may listen meanwhile:
// the kernel gives a group's datagrams to all who listen when one has joined.
TEST(NetworkDeviceSystem, IsHeardAgainWhenItWasReplaced) {
  const auto run = [](const std::string& command) { return std::system(command.c_str()) == 0; };
  const std::string plug =
      "ip link add plug type veth peer name socket && ip link set socket up && ip addr add "
      "10.99.0.1/24 dev plug && ip link set plug up && ip route add 239.99.0.1/32 dev plug";
  if (!run(plug)) GTEST_SKIP() << "this kernel has no veth devices";
  const std::string url = "udpm://239.99.0.1:7667?ttl=0";
  std::atomic<int> heard = 0;
  const Receiver receiver(url, "", {"SPROUT_STATUS"},
                          [&](std::string_view, std::span<const uint8_t>) { ++heard; });
  Publisher publisher(url, "");
  const auto hears = [&] {
    heard = 0;
    for (int i = 0; i < 200 && heard == 0; ++i) {
      static_cast<void>(publisher.Publish("SPROUT_STATUS", std::vector<uint8_t>(100)));
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return heard > 0;
  };
  EXPECT_TRUE(hears());
  ASSERT_TRUE(run("ip link del plug"));
  ASSERT_TRUE(run(plug));
  EXPECT_TRUE(hears());
  EXPECT_TRUE(run("ip link del plug"));
}

}  // namespace
}  // namespace sprout
