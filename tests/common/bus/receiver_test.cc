#include "common/bus/receiver.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>

#include "common/bus/mailbox.h"
#include "common/bus/publisher.h"
#include "tests/common/bus/fake_tcpq_server.h"

namespace sprout {
namespace {

struct Heard {
  std::string channel;
  std::string data;
};

// A receiver on a server of its own; what it hears lands in a mailbox.
class ReceiverTest : public ::testing::Test {
 protected:
  // The constructor of the receiver waits for the handshake, so it runs beside the server.
  void Start(const std::vector<std::string_view>& channels) {
    auto started = std::async(std::launch::async, [&] {
      receiver_.emplace(server_.url(), "A_", channels,
                        [this](std::string_view channel, std::span<const uint8_t> bytes) {
                          heard_.Put({std::string(channel), {bytes.begin(), bytes.end()}});
                        });
    });
    ASSERT_TRUE(server_.Accept());
    for (const std::string_view channel : channels) ExpectSubscription(channel);
    started.get();
  }

  void ExpectSubscription(std::string_view channel) {
    const FakeTcpqServer::Received received = server_.Receive();
    EXPECT_EQ(received.type, 2);
    EXPECT_EQ(received.channel, "A_" + std::string(channel));
  }

  Heard Next() { return heard_.Take(std::stop_token()).value(); }

  FakeTcpqServer server_;
  Mailbox<Heard> heard_;
  std::optional<Receiver> receiver_;
};

TEST_F(ReceiverTest, HandsOverBytesWithTheChannelWithoutItsPrefix) {
  Start({"SPROUT_LEFT", "SPROUT_RIGHT"});
  server_.Send("A_SPROUT_LEFT", "abc");
  const Heard left = Next();
  EXPECT_EQ(left.channel, "SPROUT_LEFT");
  EXPECT_EQ(left.data, "abc");
  server_.Send("A_SPROUT_RIGHT", std::string("\0\xff", 2));
  const Heard right = Next();
  EXPECT_EQ(right.channel, "SPROUT_RIGHT");
  EXPECT_EQ(right.data, std::string("\0\xff", 2));
}

TEST_F(ReceiverTest, StopsWithinATenthOfASecondWithoutAnyMessage) {
  Start({"SPROUT_LEFT"});
  const auto started = std::chrono::steady_clock::now();
  receiver_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(2));
}

TEST_F(ReceiverTest, ConnectsAgainWhenTheServerHangsUp) {
  Start({"SPROUT_LEFT"});
  for (int round = 0; round < 2; ++round) {
    server_.Disconnect();
    ASSERT_TRUE(server_.Accept()) << "the receiver did not come back";
    ExpectSubscription("SPROUT_LEFT");
    server_.Send("A_SPROUT_LEFT", "again");
    EXPECT_EQ(Next().data, "again");
  }
}

TEST_F(ReceiverTest, SurvivesAndStopsWhenTheServerIsGone) {
  Start({"SPROUT_LEFT"});
  ASSERT_TRUE(server_.CloseAndWait()) << "the receiver did not notice";
  const auto started = std::chrono::steady_clock::now();
  receiver_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(2));
}

TEST(Receiver, CountsWhatItDropsWhenItsHandlerIsTooSlow) {
  FakeTcpqServer server;
  std::promise<void> released;
  const std::shared_future<void> release = released.get_future().share();
  std::atomic<int> heard = 0;
  std::atomic<int> dropped = 0;
  std::optional<Receiver> receiver;
  auto started = std::async(std::launch::async, [&] {
    receiver.emplace(
        server.url(), "", std::vector<std::string_view>{"A", "END"},
        [&](std::string_view channel, std::span<const uint8_t>) {
          release.wait();
          if (channel == "A") ++heard;
        },
        [&](std::string_view channel) {
          if (channel == "A")
            ++dropped;
          else
            released.set_value();
        },
        /*max_queued_bytes=*/10'000);
  });
  ASSERT_TRUE(server.Accept());
  for (int i = 0; i < 2; ++i) server.Receive();  // subscriptions
  started.get();
  for (int i = 0; i < 20; ++i) server.Send("A", std::string(1000, 'x'));
  server.Send("END", std::string(20'000, 'x'));  // fits never
  release.wait();
  EXPECT_GE(dropped, 10);
  const int kept = 20 - dropped;
  while (heard < kept) std::this_thread::yield();
  EXPECT_EQ(heard + dropped, 20);
}

TEST(Receiver, GoesOnWhenItsHandlerThrows) {
  FakeTcpqServer server;
  std::atomic<int> dropped = 0;
  std::promise<void> ended;
  std::optional<Receiver> receiver;
  auto started = std::async(std::launch::async, [&] {
    receiver.emplace(
        server.url(), "", std::vector<std::string_view>{"A", "END"},
        [&](std::string_view channel, std::span<const uint8_t>) {
          if (channel == "A") throw std::bad_alloc();
          ended.set_value();
        },
        [&](std::string_view) { ++dropped; });
  });
  ASSERT_TRUE(server.Accept());
  for (int i = 0; i < 2; ++i) server.Receive();  // subscriptions
  started.get();
  for (int i = 0; i < 3; ++i) server.Send("A", "x");
  server.Send("END", "x");
  ended.get_future().wait();
  EXPECT_EQ(dropped, 3);
}

TEST(Publisher, PutsThePrefixBeforeTheChannel) {
  FakeTcpqServer server;
  auto publishing = std::async(std::launch::async, [&] {
    const uint8_t bytes[] = {'x', 0, 'y'};
    return Publisher(server.url(), "B_").Publish("SPROUT_SEEDS", bytes);
  });
  ASSERT_TRUE(server.Accept());
  const FakeTcpqServer::Received received = server.Receive();
  EXPECT_EQ(received.type, 1);
  EXPECT_EQ(received.channel, "B_SPROUT_SEEDS");
  EXPECT_EQ(received.data, std::string("x\0y", 3));
  EXPECT_TRUE(publishing.get());
}

TEST(Publisher, RefusesWhatNobodyWouldTake) {
  FakeTcpqServer server;
  auto connecting = std::async(std::launch::async, [&] { return Publisher(server.url(), ""); });
  ASSERT_TRUE(server.Accept());
  const std::vector<uint8_t> bytes(DatagramJoiner::kMaxMessageBytes + 1);
  EXPECT_FALSE(connecting.get().Publish("SPROUT_LEFT", bytes));
}

TEST(Publisher, NeedsAConnection) { EXPECT_THROW(Publisher("nonsense", ""), BusError); }

TEST(Publisher, SaysSoWhenTheServerIsGone) {
  FakeTcpqServer server;
  auto connecting = std::async(std::launch::async, [&] { return Publisher(server.url(), ""); });
  ASSERT_TRUE(server.Accept());
  Publisher publisher = connecting.get();
  server.Close();
  const uint8_t byte = 1;
  // The first ones may still go into the socket's buffer.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  bool sent = true;
  while (sent && std::chrono::steady_clock::now() < end) {
    sent = publisher.Publish("SPROUT_SEEDS", {&byte, 1});
  }
  EXPECT_FALSE(sent);
}

}  // namespace
}  // namespace sprout
