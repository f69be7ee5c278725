#include "services/capture/video_source.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <opencv2/videoio.hpp>
#include <optional>
#include <utility>

#include "common/config/config.h"
#include "common/core/image.h"
#include "common/core/number_text.h"

namespace sprout::capture {
namespace {

constexpr std::chrono::seconds kRetryPeriod{1};

bool IsDevice(const std::string& place) {
  return ParseNumber<int>(place).has_value() || place.starts_with("/dev/");
}

// With the backend that is for it: OpenCV's others try what they cannot open, and one of them looks
// through all USB devices and keeps what it found.
bool OpenPlace(const std::string& place, cv::VideoCapture& video) {
  if (const std::optional<int> number = ParseNumber<int>(place)) {
    return video.open(*number, cv::CAP_V4L2);
  }
  if (IsDevice(place)) return video.open(place, cv::CAP_V4L2);
  if (place.find('%') != std::string::npos) return video.open(place, cv::CAP_IMAGES);
  return video.open(place, cv::CAP_FFMPEG);
}

// Sleeps until the time is over or a stop is asked for.
void Wait(const std::stop_token& stop, std::chrono::seconds time) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, time, [] { return false; });
}

class VideoSource : public RawSource {
 public:
  explicit VideoSource(const VideoSettings& settings)
      : settings_(settings),
        is_live_(std::any_of(settings.places.begin(), settings.places.end(), IsDevice)) {
    if (const std::optional<std::string> refused = Open()) {
      throw ConfigError("video " + *refused +
                        ": cannot be opened; allowed: a video, an image list (left_%04d.png), a "
                        "device (/dev/video0)");
    }
  }

  bool is_live() const override { return is_live_; }

  std::optional<datasets::CapturedFrame> Next(const std::stop_token& stop) override {
    std::string trouble;
    bool opened_again = false;
    while (!stop.stop_requested()) {
      if (std::optional<datasets::CapturedFrame> frame = Grab()) {
        Require(*frame);
        frame->trouble = trouble;
        return frame;
      }
      if (is_live_) {
        trouble = settings_.places.front() + ": no picture, opened again";
        Wait(stop, kRetryPeriod);
      } else if (!settings_.loop || std::exchange(opened_again, true)) {
        return std::nullopt;
      }
      Open();
    }
    return std::nullopt;
  }

 private:
  // @returns what cannot be opened.
  std::optional<std::string> Open() {
    videos_.clear();
    for (const std::string& place : settings_.places) {
      cv::VideoCapture& video = videos_.emplace_back();
      if (!OpenPlace(place, video)) return place;
      if (settings_.width > 0) video.set(cv::CAP_PROP_FRAME_WIDTH, settings_.width);
      if (settings_.height > 0) video.set(cv::CAP_PROP_FRAME_HEIGHT, settings_.height);
      if (settings_.fps > 0) video.set(cv::CAP_PROP_FPS, settings_.fps);
    }
    return std::nullopt;
  }

  // Takes both pictures before it decodes either, so that they are of one time.
  std::optional<datasets::CapturedFrame> Grab() {
    for (cv::VideoCapture& video : videos_) {
      if (!video.grab()) return std::nullopt;
    }
    std::vector<cv::Mat> pictures;
    for (cv::VideoCapture& video : videos_) {
      cv::Mat picture;
      if (!video.retrieve(picture) || picture.empty()) return std::nullopt;
      pictures.push_back(picture.clone());  // the next one may take its memory
    }
    datasets::CapturedFrame frame;
    if (pictures.size() == 2) {
      frame.left = pictures[0];
      frame.right = pictures[1];
    } else {
      const cv::Mat& both = pictures[0];
      frame.left = both.colRange(0, both.cols / 2).clone();
      frame.right = both.colRange(both.cols - both.cols / 2, both.cols).clone();
    }
    return frame;
  }

  static void Require(const datasets::CapturedFrame& frame) {
    if (frame.left.size() != frame.right.size()) {
      throw ConfigError("video: the left picture has " + SizeText(frame.left.size()) +
                        ", the right one " + SizeText(frame.right.size()) + "; allowed: one size");
    }
    for (const cv::Mat& picture : {frame.left, frame.right}) {
      if (picture.type() == CV_8UC1 || picture.type() == CV_8UC3) continue;
      throw ConfigError("video: pictures of OpenCV's type " + std::to_string(picture.type()) +
                        "; allowed: 8-bit grey or colour");
    }
  }

  VideoSettings settings_;
  bool is_live_;
  std::vector<cv::VideoCapture> videos_;
};

}  // namespace

std::unique_ptr<RawSource> OpenVideo(const VideoSettings& settings) {
  return std::make_unique<VideoSource>(settings);
}

}  // namespace sprout::capture
