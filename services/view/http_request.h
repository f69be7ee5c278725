#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sprout::view {

/// The relevant parts of a request, untrusted.
struct HttpRequest {
  std::string_view method;
  std::string_view target;           ///< "/save?key=3&what=left.png"
  std::string_view host;             ///< of the header; empty: none
  std::string_view origin;           ///< of the header; empty: none
  std::string_view fetch_site = {};  ///< Sec-Fetch-Site; empty: none
};

/// A parsed target.
struct HttpTarget {
  std::string path;
  std::map<std::string, std::string> query;

  /// A whole number of the query; nothing when it is missing, not a number, or not from low to
  /// high.
  std::optional<int64_t> Number(const std::string& name, int64_t low, int64_t high) const;
};

/// Escapes such as %2e are not decoded: no name on this server needs them. O(length).
HttpTarget ParseTarget(std::string_view target);

/// Whether a Host header can be that of this server: localhost, this machine's name, or a numeric
/// address, with any port. Another name means that the page of another site had its own name point
/// here (DNS rebinding), to circumvent the browser's protection.
bool IsOwnHost(std::string_view host);

/// Whether a WebSocket may be opened: by a page of this server, or by a program that is not a
/// browser and so sends no origin.
bool IsOwnOrigin(std::string_view origin, std::string_view host);

/// Whether the browser says that a page of another site caused the request, for instance by a
/// picture, a link or a form. Browsers send this only to servers on their own machine or with TLS;
/// other programs do not send it.
bool IsCrossSite(const HttpRequest& request);

}  // namespace sprout::view
