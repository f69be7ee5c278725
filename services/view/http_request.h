#ifndef SPROUT_SERVICES_VIEW_HTTP_REQUEST_H_
#define SPROUT_SERVICES_VIEW_HTTP_REQUEST_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sprout::view {

/// What matters of a request; nothing of it is trusted.
struct HttpRequest {
  std::string_view method;
  std::string_view target;           ///< "/save?key=3&what=left.png"
  std::string_view host;             ///< of the header; empty: none
  std::string_view origin;           ///< of the header; empty: none
  std::string_view fetch_site = {};  ///< Sec-Fetch-Site; empty: none
};

/// A target taken apart.
struct HttpTarget {
  std::string path;
  std::map<std::string, std::string> query;

  /// A whole number of the query; nothing when it is not there, none, or not from low to high.
  std::optional<int64_t> Number(const std::string& name, int64_t low, int64_t high) const;
};

/// Characters are taken as they are: no name of ours needs an escape, so %2e and the like find
/// nothing. O(length).
HttpTarget ParseTarget(std::string_view target);

/// Whether a Host header can be that of this server: localhost, this machine's name, or an address
/// in numbers, with any port. The name of another host means that a page from elsewhere had its
/// own name point here (DNS rebinding), to read what its browser should not let it read.
bool IsOwnHost(std::string_view host);

/// Whether a WebSocket may be opened: by a page from this very server, or by a program that is no
/// browser and so names no origin.
bool IsOwnOrigin(std::string_view origin, std::string_view host);

/// Whether a browser says that a page from elsewhere made it ask, with a picture, a link or a form,
/// say. Browsers tell only servers on their own machine or behind TLS; programs do not tell.
bool IsFromElsewhere(const HttpRequest& request);

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_HTTP_REQUEST_H_
