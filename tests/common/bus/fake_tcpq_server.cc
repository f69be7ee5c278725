#include "tests/common/bus/fake_tcpq_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

// For the leak sanitizer: LCM 1.3.1 loses the buffer of a channel's name on tcpq. Nothing of
// ours allocates through GLib.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:g_malloc\n"; }

namespace sprout {
namespace {

constexpr int32_t kServerMagic = 0x287617fa;
constexpr int32_t kProtocolVersion = 0x0100;
constexpr int32_t kPublish = 1;

void AppendInt32(std::string& bytes, int32_t value) {
  const uint32_t network = htonl(static_cast<uint32_t>(value));
  bytes.append(reinterpret_cast<const char*>(&network), sizeof network);
}

void SendAll(int fd, const std::string& bytes) {
  if (send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("fake server: cannot send");
  }
}

}  // namespace

// No program that a test starts inherits the sockets: it would keep the server alive.
FakeTcpqServer::FakeTcpqServer() : listening_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(listening_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      listen(listening_, 5) != 0 ||
      getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("fake server: cannot listen");
  }
  port_ = ntohs(address.sin_port);
}

FakeTcpqServer::~FakeTcpqServer() { Close(); }

std::string FakeTcpqServer::url() const { return "tcpq://127.0.0.1:" + std::to_string(port_); }

bool FakeTcpqServer::Accept() {
  pollfd waiting{.fd = listening_, .events = POLLIN, .revents = 0};
  if (poll(&waiting, 1, 10'000) != 1) return false;
  if (client_ >= 0) earlier_clients_.push_back(client_);
  client_ = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
  ReadBytes(8);  // the client's magic and version
  std::string hello;
  AppendInt32(hello, kServerMagic);
  AppendInt32(hello, kProtocolVersion);
  SendAll(client_, hello);
  return true;
}

FakeTcpqServer::Received FakeTcpqServer::Receive() {
  try {
    Received received;
    received.type = ReadInt32();
    received.channel = ReadBytes(static_cast<size_t>(ReadInt32()));
    if (received.type == kPublish) received.data = ReadBytes(static_cast<size_t>(ReadInt32()));
    return received;
  } catch (const std::runtime_error&) {
    return {};
  }
}

void FakeTcpqServer::Send(const std::string& channel, const std::string& data) {
  std::string bytes;
  AppendInt32(bytes, kPublish);
  AppendInt32(bytes, static_cast<int32_t>(channel.size()));
  bytes += channel;
  AppendInt32(bytes, static_cast<int32_t>(data.size()));
  bytes += data;
  SendAll(client_, bytes);
}

void FakeTcpqServer::Disconnect() {
  if (client_ >= 0) close(client_);
  client_ = -1;
}

void FakeTcpqServer::Close() {
  Disconnect();
  for (const int client : earlier_clients_) close(client);
  earlier_clients_.clear();
  StopListening();
}

bool FakeTcpqServer::CloseAndWait() {
  StopListening();
  shutdown(client_, SHUT_WR);
  pollfd client{.fd = client_, .events = POLLIN, .revents = 0};
  char byte;
  while (poll(&client, 1, 10'000) == 1) {
    if (recv(client_, &byte, 1, 0) > 0) continue;  // what it had sent before
    Close();
    return true;
  }
  return false;
}

void FakeTcpqServer::StopListening() {
  if (listening_ >= 0) close(listening_);
  listening_ = -1;
}

std::string FakeTcpqServer::ReadBytes(size_t count) {
  std::string bytes(count, '\0');
  if (count > 0 && recv(client_, bytes.data(), count, MSG_WAITALL) != static_cast<ssize_t>(count)) {
    throw std::runtime_error("fake server: the client is gone");
  }
  return bytes;
}

int32_t FakeTcpqServer::ReadInt32() {
  const std::string bytes = ReadBytes(4);
  uint32_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<uint8_t>(byte);
  return static_cast<int32_t>(value);
}

}  // namespace sprout
