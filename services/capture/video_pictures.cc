#include "services/capture/video_pictures.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <cmath>
#include <opencv2/videoio.hpp>
#include <span>
#include <utility>

#include "common/config/required.h"
#include "common/core/image.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"

namespace sprout::capture {
namespace {

using Clock = std::chrono::steady_clock;

// A picture that seems to be older is stamped by another clock.
constexpr std::chrono::seconds kMaxAge{10};

class ListedPictures : public Pictures {
 public:
  explicit ListedPictures(std::vector<std::string> files) : files_(std::move(files)) {}

  bool Grab() override {
    if (taken_ == files_.size()) return false;
    ++taken_;
    return true;
  }

  CameraImage Retrieve() override { return Required(ReadCameraImage(files_[taken_ - 1])); }

 private:
  std::vector<std::string> files_;
  size_t taken_ = 0;
};

class VideoPictures : public Pictures {
 public:
  explicit VideoPictures(std::string place) : place_(std::move(place)) {}

  // Opens the place with its own backend: OpenCV's others try what they cannot open, and one of
  // them looks through all USB devices and keeps what it found.
  bool Open(const PictureMode& settings) {
    if (!OpenPlace()) return false;
    if (settings.width > 0) video_.set(cv::CAP_PROP_FRAME_WIDTH, settings.width);
    if (settings.height > 0) video_.set(cv::CAP_PROP_FRAME_HEIGHT, settings.height);
    if (settings.fps > 0) video_.set(cv::CAP_PROP_FPS, settings.fps);
    RequireSize();
    return true;
  }

  bool Grab() override {
    has_ended_ = !video_.grab();
    taken_ += has_ended_ ? 0 : 1;
    return !has_ended_;
  }

  std::optional<int64_t> Time() const override {
    if (IsDevice(place_)) return std::nullopt;
    const double time_us = 1000 * video_.get(cv::CAP_PROP_POS_MSEC);
    // Where the container has no times, OpenCV gives 0 for all.
    if (taken_ > 1 && time_us <= 0) {
      return Rate() > 0
                 ? std::optional(std::llround(1e6 * static_cast<double>(taken_ - 1) / Rate()))
                 : std::nullopt;
    }
    return std::llround(time_us);
  }

  // V4L2 stamps pictures with the clock of steady_clock; some drivers use another one, or none.
  std::optional<std::chrono::microseconds> Age() const override {
    if (!IsDevice(place_)) return std::nullopt;
    const std::chrono::duration<double, std::milli> taken(video_.get(cv::CAP_PROP_POS_MSEC));
    const auto age = std::chrono::duration_cast<std::chrono::microseconds>(
        Clock::now().time_since_epoch() - taken);
    if (age < age.zero() || age > kMaxAge) return std::nullopt;
    return age;
  }

  double Rate() const override {
    const double rate = video_.get(cv::CAP_PROP_FPS);
    return std::isfinite(rate) && rate > 0 ? rate : 0;
  }

  // A frame that cannot be decoded ends a video like the end of its file. How many there are, is
  // estimated from the length where the header does not say.
  std::string EndText() const override {
    const double claimed = video_.get(cv::CAP_PROP_FRAME_COUNT);
    if (!has_ended_ || static_cast<double>(taken_) >= 0.95 * claimed - 1) return {};
    return fmt::format("video {}: {} frames could be read; {:.0f} are in it by its header", place_,
                       taken_, claimed);
  }

  CameraImage Retrieve() override {
    RequireSize();  // before OpenCV takes memory for it; a stream may change its size
    cv::Mat picture;
    if (!video_.retrieve(picture)) return {};
    return {picture.clone()};  // OpenCV may reuse the memory for the next picture
  }

 private:
  bool OpenPlace() {
    NoteInputFile(place_);
    if (const std::optional<int> number = ParseNumber<int>(place_)) {
      return video_.open(*number, cv::CAP_V4L2);
    }
    return video_.open(place_, IsDevice(place_) ? cv::CAP_V4L2 : cv::CAP_FFMPEG);
  }

  void RequireSize() const {
    const cv::Size2d size(video_.get(cv::CAP_PROP_FRAME_WIDTH),
                          video_.get(cv::CAP_PROP_FRAME_HEIGHT));
    if (std::max(size.width, size.height) <= kMaxSide && size.area() <= kMaxPixels) return;
    throw ConfigError(fmt::format("video {}: {}x{} px; allowed: 1 to {} px a side and {} pixels",
                                  place_, size.width, size.height, kMaxSide, kMaxPixels));
  }

  std::string place_;
  cv::VideoCapture video_;
  int64_t taken_ = 0;
  bool has_ended_ = false;
};

}  // namespace

// A picture that had to be waited for is the newest. By then it is one or two intervals old.
bool GrabNewest(Pictures& pictures) {
  constexpr int kMaxQueued = 16;
  const std::chrono::duration<double> interval(pictures.Rate() > 0 ? 1 / pictures.Rate() : 0);
  for (int i = 0; i < kMaxQueued; ++i) {
    const Clock::time_point begun = Clock::now();
    if (!pictures.Grab()) return false;
    const auto age = pictures.Age();
    if (interval.count() == 0 || !age || *age <= 3 * interval ||
        Clock::now() - begun > interval / 4) {
      break;
    }
  }
  return true;
}

bool IsDevice(const std::string& place) {
  return ParseNumber<int>(place).has_value() || place.starts_with("/dev/");
}

std::vector<std::string> FilesMatching(const std::string& pattern) {
  glob_t found{};
  std::vector<std::string> files;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    for (const char* path : std::span(found.gl_pathv, found.gl_pathc)) files.emplace_back(path);
  }
  globfree(&found);
  return files;
}

std::unique_ptr<Pictures> OpenImages(std::vector<std::string> files) {
  return std::make_unique<ListedPictures>(std::move(files));
}

std::unique_ptr<Pictures> OpenVideoPictures(const std::string& place, const PictureMode& device) {
  auto video = std::make_unique<VideoPictures>(place);
  if (!video->Open(device)) return nullptr;
  return video;
}

}  // namespace sprout::capture
