#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <memory>
#include <string>

#include "services/view/server.h"

namespace sprout::view {

/// An open page: its session on a WebSocket. On the thread of the sockets.
class PageConnection : public std::enable_shared_from_this<PageConnection> {
 public:
  PageConnection(ServerState& state, ConnectionCount count, boost::asio::ip::tcp::socket socket);
  ~PageConnection();

  void Accept(boost::beast::http::request<boost::beast::http::empty_body> request);

  /// Sends a frame, once the page has drawn the last one. Sends nothing while a message is being
  /// sent, whatever the page says: so a page that does not read takes no memory.
  void Pump();

  /// Sends a status, unless one is still waiting.
  void SendStatus(const std::string& status);

 private:
  struct Message {
    std::string bytes;
    bool is_text;
    bool is_status;
  };

  void Read();
  void OnRead(boost::beast::error_code error);
  void Send(Message message);
  void Write();

  /// Runs work on the thread for pictures, and sends its result.
  /// @param busy  true meanwhile.
  template <typename Work>
  void SendLater(Work work, bool is_text, bool PageConnection::*busy);

  ServerState& state_;
  ConnectionCount count_;
  ViewSession session_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::beast::flat_buffer buffer_;
  std::deque<Message> outbox_;  // the first is being sent
  bool status_waits_ = false;
  bool encoding_ = false;
  bool probing_ = false;
  bool measuring_ = false;
  bool open_ = false;
};

/// Turns a connection into a WebSocket, as `request` asked.
void ServePage(ServerState& state, ConnectionCount count, boost::asio::ip::tcp::socket socket,
               boost::beast::http::request<boost::beast::http::empty_body> request);

}  // namespace sprout::view
