#ifndef SPROUT_SERVICES_VIEW_HTTP_HANDLER_H_
#define SPROUT_SERVICES_VIEW_HTTP_HANDLER_H_

#include <optional>
#include <string>

#include "services/view/frame_encoder.h"
#include "services/view/frame_source.h"
#include "services/view/http_request.h"
#include "services/view/memory_file.h"

namespace sprout::view {

class FrameRing;
class LogFile;

/// An answer. Either `file` or `body` is what it contains.
struct HttpReply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
  std::optional<MemoryFile> file;
  std::string file_name;  ///< to save it under; empty: shown, not saved
};

/// Answers requests, without a socket: the files of the page, thumbnails, the time line of a log,
/// and what people save. Thread-safe.
///
///   /                          the page, and its files
///   /thumb?key=K               the left image, small
///   /timeline?buckets=N        of a log
///   /save?key=K&what=FILE      left.png, disparity.png, disparity.pfm, prior.pfm, cloud.ply, ...
///   /save-log?seconds=S        the last seconds of the running graph as an LCM log
class HttpHandler {
 public:
  /// @param ring  of the running graph, or null.
  /// @param log   or null.
  HttpHandler(const FrameSource& source, FrameEncoder& encoder, const FrameRing* ring,
              const LogFile* log, std::string prefix)
      : source_(source), encoder_(encoder), ring_(ring), log_(log), prefix_(std::move(prefix)) {}

  /// Never throws. O(size of the answer).
  HttpReply Handle(const HttpRequest& request) const;

 private:
  HttpReply Answer(const HttpTarget& target) const;
  HttpReply Thumbnail(const HttpTarget& target) const;
  HttpReply Save(const HttpTarget& target) const;
  HttpReply SaveLog(const HttpTarget& target) const;
  HttpReply TimeLine(const HttpTarget& target) const;

  const FrameSource& source_;
  FrameEncoder& encoder_;
  const FrameRing* ring_;
  const LogFile* log_;
  std::string prefix_;
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_HTTP_HANDLER_H_
