#include "services/view/server.h"

#include <boost/asio/post.hpp>
#include <chrono>

#include "common/app/compute.h"
#include "common/config/config_error.h"
#include "services/view/http_connection.h"
#include "services/view/page_connection.h"

namespace sprout::view {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::seconds kStatusPeriod{1};

}  // namespace

Server::Server(const std::string& address, uint16_t port, ServerParts parts)
    : state_(std::move(parts)) {
  Listen(address, port);
  asio::post(state_.pictures, LowerPriority);
  asio::post(state_.requests, LowerPriority);
  Accept();
  Tick();
  thread_ = std::jthread([this] { state_.sockets.run(); });
}

// Destroys handlers that never ran before the members that their connections use.
Server::~Server() {
  state_.sockets.stop();
  thread_.join();
  state_.pictures.join();
  state_.requests.join();
}

uint16_t Server::port() const { return acceptor_.local_endpoint().port(); }

void Server::FrameChanged() {
  asio::post(state_.sockets, [this] {
    for (PageConnection* page : state_.pages) page->Pump();
  });
}

void Server::Listen(const std::string& address, uint16_t port) {
  boost::system::error_code error;
  const auto numbers = asio::ip::make_address(address, error);
  if (error) {
    throw ConfigError("--address " + address + ": allowed is an address in numbers");
  }
  const tcp::endpoint endpoint(numbers, port);
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (!error) return;
  const std::string hint = error == asio::error::address_in_use
                               ? "; is another sprout-view running? --port chooses another port"
                               : "";
  throw ConfigError(address + ":" + std::to_string(port) + ": " + error.message() + hint);
}

void Server::Accept() {
  acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) {  // such as no file descriptor left, so it waits before the next try
      retry_.expires_after(std::chrono::milliseconds(100));
      return retry_.async_wait([this](boost::system::error_code) { Accept(); });
    }
    // A client beyond kMaxConnections is disconnected at once.
    if (state_.connections < kMaxConnections) {
      boost::system::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      ServeHttp(state_, std::move(socket));
    }
    Accept();
  });
}

void Server::Tick() {
  timer_.expires_after(kStatusPeriod);
  timer_.async_wait([this](boost::system::error_code error) {
    if (error) return;
    if (!state_.pages.empty()) {
      const std::string status = state_.parts.status();
      for (PageConnection* page : state_.pages) page->SendStatus(status);
    }
    Tick();
  });
}

}  // namespace sprout::view
