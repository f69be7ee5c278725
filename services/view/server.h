#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "common/app/log_limiter.h"
#include "services/view/frame_encoder.h"
#include "services/view/frame_source.h"
#include "services/view/http_handler.h"
#include "services/view/view_session.h"

namespace sprout::view {

/// What a server serves. All of it must outlive the server.
struct ServerParts {
  const FrameSource* source = nullptr;
  FrameEncoder* encoder = nullptr;
  const HttpHandler* handler = nullptr;
  std::function<std::string()> hello;   ///< JSON, the first message to a page; any thread
  std::function<std::string()> status;  ///< JSON, once a second; any thread
  size_t keep_bytes = 0;                ///< see PausedFrameBudget
};

class PageConnection;

/// State shared by a server's connections. Used only on the thread of the sockets.
struct ServerState {
  explicit ServerState(ServerParts what) : parts(std::move(what)), budget(parts.keep_bytes) {}

  ServerParts parts;
  PausedFrameBudget budget;
  int connections = 0;
  LimitedWarnings bad_pages;
  std::set<PageConnection*> pages;
  boost::asio::io_context sockets{1};
  boost::asio::thread_pool pictures{1};
  boost::asio::thread_pool requests{1};
};

/// Serves pages: HTTP requests, and WebSockets (at /ws) with frames and statuses.
///
/// Three threads: one for all sockets, which is never busy for long; one that makes pictures, and
/// one that answers other requests, both at low priority, so that the graph goes first. Pages are
/// independent: for a slow page only the newest frame is kept.
class Server {
 public:
  /// Most connections, and most WebSockets among them. A browser opens up to six, and one
  /// WebSocket.
  static constexpr int kMaxConnections = 96;
  static constexpr int kMaxPages = 16;

  /// Listens before it returns.
  /// @param address  numeric. @param port 0: any free port.
  /// @throws ConfigError when it cannot listen on the address.
  Server(const std::string& address, uint16_t port, ServerParts parts);
  ~Server();

  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;

  /// FrameSource::Newest() has changed. Any thread; returns at once.
  void FrameChanged();

 private:
  void Listen(const std::string& address, uint16_t port);
  void Accept();
  void Tick();

  ServerState state_;
  boost::asio::ip::tcp::acceptor acceptor_{state_.sockets};
  boost::asio::steady_timer timer_{state_.sockets};
  boost::asio::steady_timer retry_{state_.sockets};
  std::jthread thread_;
};

/// Counts a connection during its life.
class ConnectionCount {
 public:
  explicit ConnectionCount(ServerState& state) : state_(&state) { ++state_->connections; }
  ConnectionCount(ConnectionCount&& other) noexcept
      : state_(std::exchange(other.state_, nullptr)) {}
  ConnectionCount& operator=(ConnectionCount&&) = delete;
  ~ConnectionCount() {
    if (state_ != nullptr) --state_->connections;
  }

 private:
  ServerState* state_;
};

}  // namespace sprout::view
