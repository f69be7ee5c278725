#include "services/view/http_request.h"

#include <arpa/inet.h>
#include <unistd.h>

#include <array>
#include <charconv>

namespace sprout {
namespace {

// The name or address in "name:port" or "[::1]:port".
std::string NameOf(std::string_view host) {
  if (host.starts_with('[')) {
    const size_t end = host.find(']');
    return std::string(end == std::string_view::npos ? "" : host.substr(1, end - 1));
  }
  return std::string(host.substr(0, host.find(':')));
}

bool IsAddress(const std::string& name) {
  in6_addr address{};
  return inet_pton(AF_INET, name.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, name.c_str(), &address) == 1;
}

}  // namespace

HttpTarget ParseTarget(std::string_view target) {
  HttpTarget parsed;
  const size_t mark = target.find('?');
  parsed.path = target.substr(0, mark);
  if (mark == std::string_view::npos) return parsed;
  std::string_view rest = target.substr(mark + 1);
  while (!rest.empty()) {
    const size_t end = rest.find('&');
    const std::string_view pair = rest.substr(0, end);
    const size_t equals = pair.find('=');
    if (equals != std::string_view::npos) {
      parsed.query[std::string(pair.substr(0, equals))] = pair.substr(equals + 1);
    }
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  return parsed;
}

std::optional<int64_t> HttpTarget::Number(const std::string& name, int64_t low,
                                          int64_t high) const {
  const auto found = query.find(name);
  if (found == query.end()) return std::nullopt;
  const std::string& text = found->second;
  int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number < low || number > high ? std::nullopt : std::optional(number);
}

bool IsOwnHost(std::string_view host) {
  const std::string name = NameOf(host);
  if (name == "localhost" || IsAddress(name)) return true;
  std::array<char, 256> own{};
  return gethostname(own.data(), own.size() - 1) == 0 && !name.empty() && name == own.data();
}

bool IsOwnOrigin(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  return origin.starts_with("http://") && origin.substr(7) == host;
}

}  // namespace sprout
