#include "services/view/http_request.h"

#include <arpa/inet.h>

#include <algorithm>

#include "common/core/host_name.h"
#include "common/core/number_text.h"

namespace sprout::view {
namespace {

// The name or address in "name:port" or "[::1]:port"; nothing when it is neither.
std::optional<std::string> NameOf(std::string_view host) {
  const bool brackets = host.starts_with('[');
  if (brackets) host.remove_prefix(1);
  const size_t end = std::min(host.find(brackets ? ']' : ':'), host.size());
  std::string_view port = host.substr(end);
  if (brackets) port.remove_prefix(std::min<size_t>(port.size(), 1));
  const bool is_port = port.starts_with(':') && std::ranges::all_of(port.substr(1), [](char c) {
                         return c >= '0' && c <= '9';
                       });
  if (!port.empty() && !is_port) return std::nullopt;
  return std::string(host.substr(0, end));
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
  for (const std::string_view pair : SplitAt('&', target.substr(mark + 1))) {
    const size_t equals = pair.find('=');
    if (equals != std::string_view::npos) {
      parsed.query[std::string(pair.substr(0, equals))] = pair.substr(equals + 1);
    }
  }
  return parsed;
}

std::optional<int64_t> HttpTarget::Number(const std::string& name, int64_t low,
                                          int64_t high) const {
  const auto found = query.find(name);
  if (found == query.end()) return std::nullopt;
  const std::string& text = found->second;
  const auto number = ParseNumber<int64_t>(text);
  return number && *number >= low && *number <= high ? number : std::nullopt;
}

bool IsOwnHost(std::string_view host) {
  const std::optional<std::string> name = NameOf(host);
  if (!name || name->empty()) return false;
  return *name == "localhost" || IsAddress(*name) || *name == HostName();
}

bool IsOwnOrigin(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  return origin.starts_with("http://") && origin.substr(7) == host;
}

bool IsCrossSite(const HttpRequest& request) {
  const std::string_view site = request.fetch_site;
  const bool is_own = site.empty() || site == "same-origin" || site == "none";  // none: typed
  return !is_own || !IsOwnOrigin(request.origin, request.host);
}

}  // namespace sprout::view
