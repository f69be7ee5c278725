#include <string_view>

#include "services/capture/capture_feed.h"
#include "services/capture/log_feed.h"
#include "services/capture/source_feed.h"

namespace sprout {
namespace {

constexpr std::string_view kLog = "log:";
constexpr std::string_view kPrefix = "?prefix=";

}  // namespace

std::unique_ptr<CaptureFeed> OpenCaptureFeed(const CaptureConfig& config, bool loop,
                                             StageMonitor& monitor) {
  const std::string_view source = config.source();
  if (!source.starts_with(kLog)) return OpenSourceFeed(config, loop);
  std::string_view path = source.substr(kLog.size());
  std::string_view prefix;
  if (const size_t at = path.rfind(kPrefix); at != std::string_view::npos) {
    prefix = path.substr(at + kPrefix.size());
    path = path.substr(0, at);
  }
  return OpenLogFeed(std::string(path), std::string(prefix), loop, monitor);
}

}  // namespace sprout
