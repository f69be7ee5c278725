#include "services/view/http_connection.h"

#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <optional>
#include <utility>

#include "services/view/page_connection.h"

namespace sprout::view {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr uint32_t kMaxHeaderBytes = 8192;

// How long a browser may take for a request, or leave a connection unused; and how long for an
// answer, which may be a log of a gigabyte.
constexpr std::chrono::seconds kReadTime{30};
constexpr std::chrono::seconds kWriteTime{120};

// Headers that forbid the page to load other sites' files, and other sites to frame or read it.
template <typename Body>
void SetHeaders(http::response<Body>& response, const HttpReply& reply, const std::string& host) {
  response.set(http::field::content_type, reply.type);
  response.set(http::field::cache_control, "no-cache");
  response.set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
               "connect-src 'self' ws://" +
                   host + "; frame-ancestors 'none'; base-uri 'none'");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Referrer-Policy", "no-referrer");
  if (reply.file_name.empty()) return;
  response.set(http::field::content_disposition,
               "attachment; filename=\"" + reply.file_name + "\"");
}

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(ServerState& state, boost::asio::ip::tcp::socket socket)
      : state_(state), count_(state), stream_(std::move(socket)) {}

  void Read() {
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(0);
    stream_.expires_after(kReadTime);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](beast::error_code error, size_t) { self->OnRead(error); });
  }

 private:
  void OnRead(beast::error_code error) {
    if (error == http::error::header_limit || error == http::error::body_limit ||
        error == http::error::unexpected_body) {
      keep_alive_ = false;
      return Write({.status = 413, .body = "the request is too large\n"});
    }
    if (error) return Close();
    request_ = parser_->release();
    keep_alive_ = request_.keep_alive();
    const HttpRequest request = ViewOf(request_);
    host_ = IsOwnHost(request.host) ? std::string(request.host) : std::string();
    const bool is_upgrade = beast::websocket::is_upgrade(request_);
    if (is_upgrade || request.target == "/ws") return ServeWebSocket(request, is_upgrade);
    // Making the answer may take a second, so another thread does that. It returns the connection
    // to the thread of the sockets, which alone may destroy it.
    boost::asio::post(state_.requests, [self = shared_from_this()]() mutable {
      HttpConnection& connection = *self;
      auto reply = std::make_shared<HttpReply>(
          connection.state_.parts.handler->Handle(ViewOf(connection.request_)));
      boost::asio::post(connection.stream_.get_executor(),
                        [self = std::move(self), reply] { self->Write(std::move(*reply)); });
    });
  }

  // A browser does not tell a page why its WebSocket was refused, so the page asks again by a plain
  // request.
  void ServeWebSocket(const HttpRequest& request, bool is_upgrade) {
    const auto refuse = [this](int status, const char* text) {
      keep_alive_ = false;
      Write({.status = status, .body = text});
    };
    if (request.target != "/ws") return refuse(404, "the WebSocket is at /ws\n");
    if (host_.empty() || !IsOwnOrigin(request.origin, request.host)) {
      return refuse(403, "requests of other sites' pages are refused\n");
    }
    if (state_.pages.size() >= Server::kMaxPages) {
      return refuse(503, "too many pages are open: allowed are 16\n");
    }
    if (!is_upgrade) return Write({.status = 200, .body = "there is room for a page\n"});
    stream_.expires_never();
    ServePage(state_, std::move(count_), stream_.release_socket(), std::move(request_));
  }

  void Write(HttpReply reply) {
    stream_.expires_after(kWriteTime);
    if (!reply.file) {
      auto response = std::make_shared<http::response<http::string_body>>();
      response->body() = std::move(reply.body);
      return Send(std::move(response), std::move(reply));
    }
    auto response = std::make_shared<http::response<http::file_body>>();
    beast::file_posix file;
    try {
      file.native_handle(reply.file->OpenForReading());
    } catch (const std::exception& e) {  // such as no file descriptor left
      return Write({.status = 500, .body = e.what() + std::string("\n")});
    }
    beast::error_code error;
    response->body().reset(std::move(file), error);
    if (error) return Close();
    Send(std::move(response), std::move(reply));
  }

  // Keeps the reply, and the file that it holds, until it is sent.
  template <typename Body>
  void Send(std::shared_ptr<http::response<Body>> response, HttpReply reply) {
    response->version(11);
    response->result(static_cast<unsigned>(reply.status));
    response->keep_alive(keep_alive_);
    SetHeaders(*response, reply, host_);
    response->prepare_payload();
    http::async_write(stream_, *response,
                      [self = shared_from_this(), response, file = std::move(reply.file)](
                          beast::error_code error, size_t) {
                        if (error || !self->keep_alive_) return self->Close();
                        self->Read();
                      });
  }

  void Close() {
    beast::error_code ignored;
    stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  }

  ServerState& state_;
  ConnectionCount count_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kMaxHeaderBytes * 2};
  std::optional<http::request_parser<http::empty_body>> parser_;
  ParsedRequest request_;
  std::string host_;  // header Host of the request, checked by IsOwnHost()
  bool keep_alive_ = true;
};

}  // namespace

HttpRequest ViewOf(const ParsedRequest& request) {
  const auto text = [](beast::string_view view) {
    return std::string_view(view.data(), view.size());
  };
  return {.method = text(request.method_string()),
          .target = text(request.target()),
          .host = text(request[http::field::host]),
          .origin = text(request[http::field::origin]),
          .fetch_site = text(request["Sec-Fetch-Site"])};
}

void ServeHttp(ServerState& state, boost::asio::ip::tcp::socket socket) {
  std::make_shared<HttpConnection>(state, std::move(socket))->Read();
}

}  // namespace sprout::view
