#ifndef SPROUT_SERVICES_VIEW_SERVER_H_
#define SPROUT_SERVICES_VIEW_SERVER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "services/view/frame_encoder.h"
#include "services/view/frame_source.h"
#include "services/view/http_handler.h"

namespace sprout::view {

/// The address cannot be listened on. what() is one line.
class ListenError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a server serves. All of it must outlive the server.
struct ServerParts {
  const FrameSource* source = nullptr;
  FrameEncoder* encoder = nullptr;
  const HttpHandler* handler = nullptr;
  std::function<std::string()> hello;   ///< JSON, the first message to a page; any thread
  std::function<std::string()> status;  ///< JSON, once a second; any thread
  size_t keep_bytes = 0;                ///< see KeepBudget
};

/// Serves pages: HTTP requests, and WebSockets (at /ws) with frames and statuses.
///
/// Three threads: one for all sockets, which never works long; one that makes pictures, one that
/// answers other requests; these two at a low priority, so that the graph goes first. Every page is
/// served by itself: of what it cannot take in time only the newest is kept.
class Server {
 public:
  /// Most connections, and of these WebSockets. A browser opens up to six, and one WebSocket.
  static constexpr int kMaxConnections = 96;
  static constexpr int kMaxPages = 16;

  /// Listens before it returns.
  /// @param address  in numbers. @param port  0: any that is free.
  /// @throws ListenError.
  Server(const std::string& address, uint16_t port, ServerParts parts);
  ~Server();

  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;

  /// FrameSource::Newest() is another one. Any thread; returns at once.
  void FrameChanged();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_SERVER_H_
