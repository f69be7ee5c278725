#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "services/view/http_request.h"
#include "services/view/server.h"

namespace sprout::view {

using ParsedRequest = boost::beast::http::request<boost::beast::http::empty_body>;

/// The relevant parts of a parsed request; valid as long as the request.
HttpRequest ViewOf(const ParsedRequest& request);

/// Answers requests on a connection until it ends, or becomes a WebSocket. Keeps itself alive. On
/// the thread of the sockets.
void ServeHttp(ServerState& state, boost::asio::ip::tcp::socket socket);

}  // namespace sprout::view
