#ifndef SPROUT_SERVICES_VIEW_HTTP_HANDLER_H_
#define SPROUT_SERVICES_VIEW_HTTP_HANDLER_H_

#include <string>

#include "services/view/frame_encoder.h"
#include "services/view/frame_source.h"
#include "services/view/http_request.h"
#include "services/view/shared_files.h"

namespace sprout::view {

class FrameRing;
class LogFile;

/// An answer. Its content is either `file` or `body`.
struct HttpReply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body = {};
  SharedFiles::File file = {};  ///< held until it is sent
  std::string file_name = {};   ///< to save it under; empty: shown, not saved
};

/// Answers requests, without a socket: the files of the page, thumbnails, the time line of a log,
/// and files to save. Thread-safe.
///
///   /                          the page, and its files
///   /thumb?key=K               the left image, small
///   /timeline?buckets=N        of a log
///   /save?key=K&what=FILE      left.png, disparity.png, disparity.pfm, prior.pfm, cloud.ply, ...
///   /save-log?seconds=S        the last seconds of the running graph as an LCM log
///
/// Everything except the files of the page is for this page only: requests of pages of other sites
/// are refused, by the headers Sec-Fetch-Site and Origin. Two browsers at a time may save a frame,
/// and two a log, which they share.
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
  HttpReply Answer(const HttpRequest& request) const;
  HttpReply Thumbnail(const HttpTarget& target) const;
  HttpReply Save(const HttpTarget& target) const;
  HttpReply SaveLog(const HttpTarget& target) const;
  HttpReply TimeLine(const HttpTarget& target) const;

  const FrameSource& source_;
  FrameEncoder& encoder_;
  const FrameRing* ring_;
  const LogFile* log_;
  std::string prefix_;
  mutable SharedFiles frames_{SharedFiles::kMaxReaders};
  mutable SharedFiles logs_{1};
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_HTTP_HANDLER_H_
