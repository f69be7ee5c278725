#pragma once

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

namespace sprout {

/// What is logged while it lives. Nobody else logs when it begins and ends.
class LogText {
 public:
  LogText() : sink_(std::make_shared<Sink>()) {
    spdlog::default_logger()->sinks().push_back(sink_);
  }
  ~LogText() { std::erase(spdlog::default_logger()->sinks(), sink_); }
  LogText(const LogText&) = delete;
  LogText& operator=(const LogText&) = delete;

  void Forget() { sink_->Forget(); }

  /// Waits until it says that; false when it did not in half a minute.
  bool Says(const std::string& text) { return sink_->Says(text); }

 private:
  class Sink : public spdlog::sinks::base_sink<std::mutex> {
   public:
    void Forget() {
      const std::lock_guard lock(mutex_);
      text_.clear();
    }

    bool Says(const std::string& text) {
      std::unique_lock lock(mutex_);
      return changed_.wait_for(lock, std::chrono::seconds(30),
                               [&] { return text_.find(text) != std::string::npos; });
    }

   private:
    void sink_it_(const spdlog::details::log_msg& message) override {
      text_ += std::string(message.payload.data(), message.payload.size()) + "\n";
      changed_.notify_all();
    }
    void flush_() override {}

    std::condition_variable changed_;
    std::string text_;
  };

  std::shared_ptr<Sink> sink_;
};

}  // namespace sprout
