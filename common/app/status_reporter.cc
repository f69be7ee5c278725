#include "common/app/status_reporter.h"

#include <spdlog/spdlog.h>

#include <condition_variable>
#include <mutex>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout {

StatusReporter::StatusReporter(const ServiceContext& context, StageMonitor& monitor)
    : monitor_(monitor), publisher_(context.lcm_url, context.prefix) {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    do {
      Publish();
      stopped.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; });
    } while (!stop.stop_requested());
  });
}

StatusReporter::~StatusReporter() {
  thread_.request_stop();
  thread_.join();
  monitor_.SetStopped();
  Publish();
}

void StatusReporter::Publish() {
  if (!publisher_.Publish(kStatusChannel, EncodeStatus(monitor_.Snapshot()))) {
    spdlog::warn("status could not be published");
  }
}

}  // namespace sprout
