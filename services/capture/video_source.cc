#include "services/capture/video_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <opencv2/videoio.hpp>
#include <optional>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"
#include "common/core/sleep.h"
#include "services/capture/image_list.h"

namespace sprout::capture {
namespace {

constexpr std::chrono::seconds kRetryPeriod{1};

bool IsDevice(const std::string& place) {
  return ParseNumber<int>(place).has_value() || place.starts_with("/dev/");
}

// Pictures, one after the other.
class Pictures {
 public:
  virtual ~Pictures() = default;
  virtual bool Grab() = 0;         // whether there is one more
  virtual cv::Mat Retrieve() = 0;  // the one that was grabbed; empty when it cannot be decoded
  virtual std::string EndText() const { return {}; }  // what is wrong with its end
};

class ListedPictures : public Pictures {
 public:
  explicit ListedPictures(const std::string& pattern) : list_(pattern) {}
  bool Grab() override { return list_.HasNext(); }
  cv::Mat Retrieve() override { return list_.Next(); }

 private:
  ImageList list_;
};

class VideoPictures : public Pictures {
 public:
  explicit VideoPictures(std::string place) : place_(std::move(place)) {}

  // With the backend that is for it: OpenCV's others try what they cannot open, and one of them
  // looks through all USB devices and keeps what it found.
  bool Open(const VideoSettings& settings) {
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

  // A frame that cannot be decoded ends a video like the end of its file. How many there are, is
  // estimated from the length where the header does not say.
  std::string EndText() const override {
    const double claimed = video_.get(cv::CAP_PROP_FRAME_COUNT);
    if (!has_ended_ || static_cast<double>(taken_) >= 0.95 * claimed - 1) return {};
    return fmt::format("video {}: {} frames could be read; {:.0f} are in it by its header", place_,
                       taken_, claimed);
  }

  cv::Mat Retrieve() override {
    RequireSize();  // before OpenCV takes memory for it; a stream may change its size
    cv::Mat picture;
    if (!video_.retrieve(picture)) return {};
    return picture.clone();  // the next one may take its memory
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

// Nothing when it cannot be opened.
std::unique_ptr<Pictures> OpenPictures(const std::string& place, const VideoSettings& settings) {
  if (!IsDevice(place) && place.find('%') != std::string::npos) {
    return std::make_unique<ListedPictures>(place);
  }
  auto video = std::make_unique<VideoPictures>(place);
  if (!video->Open(settings)) return nullptr;
  return video;
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
        SleepFor(kRetryPeriod, stop);
      } else if (!settings_.loop || std::exchange(opened_again, true)) {
        return std::nullopt;
      }
      Open();
    }
    return std::nullopt;
  }

  datasets::LostFrames lost_at_end() const override {
    if (is_live_) return {};
    for (const auto& video : videos_) {
      if (std::string text = video->EndText(); !text.empty()) return {.trouble = std::move(text)};
    }
    return {};
  }

 private:
  // @returns what cannot be opened.
  std::optional<std::string> Open() {
    videos_.clear();
    for (const std::string& place : settings_.places) {
      std::unique_ptr<Pictures> opened = OpenPictures(place, settings_);
      if (!opened) return place;
      videos_.push_back(std::move(opened));
    }
    return std::nullopt;
  }

  // Takes both pictures before it decodes either, so that they are of one time.
  std::optional<datasets::CapturedFrame> Grab() {
    for (const auto& video : videos_) {
      if (!video->Grab()) return std::nullopt;
    }
    std::vector<cv::Mat> pictures;
    for (const auto& video : videos_) {
      pictures.push_back(video->Retrieve());
      if (pictures.back().empty()) return std::nullopt;
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
  std::vector<std::unique_ptr<Pictures>> videos_;
};

}  // namespace

std::unique_ptr<RawSource> OpenVideo(const VideoSettings& settings) {
  return std::make_unique<VideoSource>(settings);
}

}  // namespace sprout::capture
