#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sprout {

/// As much of an LCM tcpq server as one client needs: handshake, subscriptions, messages. Lives on
/// a free port of this host; works when it is told to, on the caller's thread. Serves the newest
/// client; earlier ones stay connected, and what they send is never read. Numbers on the wire are
/// big-endian int32.
class FakeTcpqServer {
 public:
  struct Received {
    int32_t type = 0;  ///< 1 publish, 2 subscribe, 3 unsubscribe; 0 the client is gone
    std::string channel;
    std::string data;  ///< of a publish
  };

  FakeTcpqServer();
  ~FakeTcpqServer();
  FakeTcpqServer(const FakeTcpqServer&) = delete;
  FakeTcpqServer& operator=(const FakeTcpqServer&) = delete;

  std::string url() const;

  /// Waits for the next client (at most 10 s) and shakes hands; false when none came.
  bool Accept();
  Received Receive();
  void Send(const std::string& channel, const std::string& data);
  /// Hangs up on the newest client.
  void Disconnect();
  /// Hangs up on the newest client, refuses new ones, and waits (at most 10 s) until the client has
  /// hung up, too; false when it has not.
  bool CloseAndWait();
  /// Hangs up on all and refuses new clients, as if the server were gone.
  void Close();

 private:
  void StopListening();
  std::string ReadBytes(size_t count);
  int32_t ReadInt32();

  int listening_ = -1;
  int client_ = -1;
  std::vector<int> earlier_clients_;
  uint16_t port_ = 0;
};

}  // namespace sprout
