#ifndef SPROUT_SERVICES_VIEW_SERVER_STATE_H_
#define SPROUT_SERVICES_VIEW_SERVER_STATE_H_

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <memory>
#include <set>

#include "common/app/log_limiter.h"
#include "services/view/server.h"
#include "services/view/view_session.h"

namespace sprout::view {

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

#endif  // SPROUT_SERVICES_VIEW_SERVER_STATE_H_
