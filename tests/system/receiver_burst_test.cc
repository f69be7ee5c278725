#include <gtest/gtest.h>

#include <cstdlib>
#include <future>
#include <mutex>

#include "common/bus/publisher.h"
#include "common/bus/receiver.h"

namespace sprout {
namespace {

// LCM itself holds some messages a channel and drops the rest without a word.
TEST(ReceiverSystem, LosesNothingOfABurstWhileItsHandlerIsBusy) {
  constexpr int kMessages = 2000;
  std::promise<void> released;
  const std::shared_future<void> release = released.get_future().share();
  std::mutex mutex;
  std::condition_variable all;
  int heard = 0;
  const Receiver receiver(kDefaultLcmUrl, "", {"SPROUT_STATUS"},
                          [&](std::string_view, std::span<const uint8_t>) {
                            release.wait();
                            const std::lock_guard lock(mutex);
                            if (++heard == kMessages) all.notify_one();
                          });
  Publisher publisher(kDefaultLcmUrl, "");
  const std::vector<uint8_t> bytes(1000, 7);
  for (int i = 0; i < kMessages; ++i) ASSERT_TRUE(publisher.Publish("SPROUT_STATUS", bytes));
  released.set_value();
  std::unique_lock lock(mutex);
  all.wait_for(lock, std::chrono::seconds(30), [&] { return heard == kMessages; });
  EXPECT_EQ(heard, kMessages);
}

// LCM reports that such messages were sent.
TEST(PublisherSystem, SaysWhyAMessageOfSeveralDatagramsWasNotSent) {
  Publisher publisher(kDefaultLcmUrl, "");
  const std::vector<uint8_t> image(1'000'000);
  EXPECT_TRUE(publisher.Publish("SPROUT_LEFT", image));
  ASSERT_EQ(std::system("ip link set lo down"), 0);
  EXPECT_FALSE(publisher.Publish("SPROUT_LEFT", image));
  EXPECT_EQ(publisher.failure(), "SPROUT_LEFT: could not be published (Network is unreachable)");
  for (size_t size = 65400; size < 65600; ++size) {  // from one datagram to two
    EXPECT_FALSE(publisher.Publish("SPROUT_LEFT", std::span(image).first(size))) << size;
  }
  ASSERT_EQ(std::system("ip link set lo up && ip route add 224.0.0.0/4 dev lo"), 0);
  EXPECT_TRUE(publisher.Publish("SPROUT_LEFT", image));
}

}  // namespace
}  // namespace sprout
