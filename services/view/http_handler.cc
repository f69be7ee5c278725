#include "services/view/http_handler.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <exception>
#include <limits>
#include <system_error>
#include <utility>

#include "common/core/frame.h"
#include "common/core/prior_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "services/view/frame_ring.h"
#include "services/view/log_file.h"

namespace sprout::view {
namespace {

Result<void> SaveImage(const cv::Mat& image, const std::filesystem::path& path) {
  if (image.empty()) return Fail("the frame has no such image");
  return WritePng(path, image);
}

// Saves a map as a picture for people, with a title and a scale.
Result<void> SavePicture(const DisparityImage* map, const std::string& title,
                         const std::filesystem::path& path) {
  if (map == nullptr || map->empty()) return Fail("the frame has no such map");
  return WritePng(path, DisparityPicture(*map, DisparityRange(std::span(map, 1), {}), title));
}

Result<void> SavePfm(const DisparityImage* map, const std::filesystem::path& path) {
  if (map == nullptr || map->empty()) return Fail("the frame has no such map");
  return WritePfm(path, *map);
}

// Writes a part of a frame to a file, named left.png, right.png, confidence.png, disparity.png and
// prior.png (with a scale), disparity.pfm, prior.pfm, sigma.pfm (px; +inf: none, or not
// known), cloud.ply (m).
// @returns an error for another name, a missing part, or different sizes.
Result<void> SaveFrame(const Frame& frame, const std::string& what,
                       const std::filesystem::path& path) {
  const DisparityImage* map = frame.disparity ? &*frame.disparity : nullptr;
  const DisparityImage* prior = frame.prior ? &frame.prior->disparity : nullptr;
  if (what == "left.png") return SaveImage(frame.left, path);
  if (what == "right.png") return SaveImage(frame.right, path);
  if (what == "confidence.png") return SaveImage(frame.confidence, path);
  if (what == "disparity.png") return SavePicture(map, "Disparity", path);
  if (what == "prior.png") return SavePicture(prior, "Prior disparity", path);
  if (what == "disparity.pfm") return SavePfm(map, path);
  if (what == "prior.pfm") return SavePfm(prior, path);
  if (what == "sigma.pfm") {
    if (frame.sigma.type() != CV_8UC1 || frame.sigma.empty()) {
      return Fail("the frame has no standard deviations");
    }
    return WritePfm(path, SigmaToPx(cv::Mat1b(frame.sigma)));
  }
  if (what != "cloud.ply") {
    return Fail(
        "what: allowed are left.png, right.png, confidence.png, disparity.png, prior.png, "
        "disparity.pfm, prior.pfm, sigma.pfm, cloud.ply");
  }
  if (map == nullptr || !frame.rig || frame.left.empty()) {
    return Fail("a cloud needs disparity map, left image and calibration");
  }
  return WriteCloudPly(path, frame.rig->pair, *map, frame.left);
}

constexpr int kThumbnailWidth = 240;
constexpr int64_t kMaxKey = std::numeric_limits<int64_t>::max();
constexpr int64_t kMaxSeconds = 3600;
constexpr int64_t kMaxBuckets = 2000;

HttpReply Refusal(int status, std::string text) {
  return {.status = status, .body = std::move(text) + "\n"};
}

HttpReply Busy(const char* what) {
  return Refusal(503, std::string(what) + " is being saved already: try again in a moment");
}

HttpReply Gone() { return Refusal(404, "no such frame, or it is no longer there"); }

}  // namespace

Result<SharedFiles::File> SharedFiles::Take(const std::string& name, Clock::time_point now,
                                            const Write& write) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const Entry& entry) { return entry.file.expired(); });
  long readers = 0;
  for (const Entry& entry : entries_) readers += entry.file.use_count();
  if (readers >= kMaxReaders) return File();
  for (const Entry& entry : entries_) {
    if (entry.name != name || now - entry.written > kFresh) continue;
    if (File file = entry.file.lock()) return file;
  }
  if (entries_.size() >= max_files_) return File();
  auto file = std::make_shared<const MemoryFile>();
  if (auto written = write(file->path()); !written) return tl::unexpected(written.error());
  entries_.push_back({name, now, file});
  return file;
}

MemoryFile::MemoryFile() : descriptor_(memfd_create("sprout-view", MFD_CLOEXEC)) {
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "memory file");
}

MemoryFile::~MemoryFile() { close(descriptor_); }

std::filesystem::path MemoryFile::path() const { return "/dev/fd/" + std::to_string(descriptor_); }

int MemoryFile::OpenForReading() const {
  const std::string name = "/proc/self/fd/" + std::to_string(descriptor_);
  const int descriptor = open(name.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw std::system_error(errno, std::generic_category(), name);
  return descriptor;
}

HttpReply HttpHandler::Handle(const HttpRequest& request) const {
  try {
    if (!IsOwnHost(request.host)) {
      return Refusal(403,
                     "the Host header names another host: allowed are localhost, this machine's "
                     "name, and addresses in numbers");
    }
    if (request.method != "GET") return Refusal(405, "allowed is GET");
    return Answer(request);
  } catch (const std::exception& e) {
    return Refusal(500, e.what());
  }
}

HttpReply HttpHandler::Answer(const HttpRequest& request) const {
  const HttpTarget target = ParseTarget(request.target);
  const std::string_view path = target.path == "/" ? "/index.html" : std::string_view(target.path);
  for (const PageFile& file : PageFiles()) {
    if (file.path != path) continue;
    return {.type = std::string(file.type), .body = std::string(file.bytes)};
  }
  if (IsCrossSite(request)) return Refusal(403, "requests of other sites' pages are refused");
  if (target.path == "/thumb") return Thumbnail(target);
  if (target.path == "/save") return Save(target);
  if (target.path == "/save-log") return SaveLog(target);
  if (target.path == "/timeline") return TimeLine(target);
  return Refusal(404, "no such page");
}

HttpReply HttpHandler::Thumbnail(const HttpTarget& target) const {
  const auto key = target.Number("key", 0, kMaxKey);
  if (!key) return Refusal(400, "key: a whole number is needed");
  const StoredFramePtr frame = source_.Get(*key);
  if (!frame) return Gone();
  EncodedPartPtr picture = encoder_.EncodePicture(frame, Picture::kLeft, kThumbnailWidth);
  if (!picture) picture = encoder_.EncodePicture(frame, Picture::kDisparity, kThumbnailWidth);
  if (!picture) return Refusal(404, "the frame has no picture");
  return {.type = "image/jpeg", .body = picture->body};
}

HttpReply HttpHandler::Save(const HttpTarget& target) const {
  const auto key = target.Number("key", 0, kMaxKey);
  if (!key) return Refusal(400, "key: a whole number is needed");
  const auto what = target.query.find("what");
  if (what == target.query.end()) return Refusal(400, "what: the name of a file is needed");
  const StoredFramePtr frame = source_.Get(*key);
  if (!frame) return Gone();
  const auto file =
      frames_.Take(fmt::format("{} {} {}", frame->key, frame->version, what->second),
                   SharedFiles::Clock::now(), [&](const std::filesystem::path& path) {
                     return SaveFrame(encoder_.Decode(frame)->ToFrame(), what->second, path);
                   });
  if (!file) return Refusal(404, file.error().text);
  if (!*file) return Busy("a frame");
  return {.type = "application/octet-stream",
          .file = *file,
          .file_name = fmt::format("{:06}_{}", frame->id.seq, what->second)};
}

HttpReply HttpHandler::SaveLog(const HttpTarget& target) const {
  if (ring_ == nullptr) return Refusal(404, "a log is shown; sprout-log cut takes a part of it");
  const auto seconds = target.Number("seconds", 1, kMaxSeconds);
  if (!seconds) return Refusal(400, fmt::format("seconds: allowed are 1 to {}", kMaxSeconds));
  const auto file = logs_.Take(std::to_string(*seconds), SharedFiles::Clock::now(),
                               [&](const std::filesystem::path& path) -> Result<void> {
                                 ring_->WriteLog(path, prefix_, static_cast<double>(*seconds));
                                 return {};
                               });
  if (!file) return Refusal(500, file.error().text);
  if (!*file) return Busy("a log");
  return {.type = "application/octet-stream", .file = *file, .file_name = "sprout.lcm"};
}

HttpReply HttpHandler::TimeLine(const HttpTarget& target) const {
  if (log_ == nullptr) return Refusal(404, "only a log has a time line");
  const auto buckets = target.Number("buckets", 1, kMaxBuckets);
  if (!buckets) return Refusal(400, fmt::format("buckets: allowed are 1 to {}", kMaxBuckets));
  return {.type = "application/json", .body = log_->TimeLineText(static_cast<int>(*buckets))};
}

}  // namespace sprout::view
