#ifndef SPROUT_SERVICES_VIEW_HTTP_CONNECTION_H_
#define SPROUT_SERVICES_VIEW_HTTP_CONNECTION_H_

#include <boost/asio/ip/tcp.hpp>

#include "services/view/server_state.h"

namespace sprout {

/// Answers what comes on a connection until it ends, or until it becomes a WebSocket. Lives as long
/// as it needs. On the thread of the sockets.
void ServeHttp(ServerState& state, boost::asio::ip::tcp::socket socket);

}  // namespace sprout

#endif  // SPROUT_SERVICES_VIEW_HTTP_CONNECTION_H_
