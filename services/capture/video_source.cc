#include "services/capture/video_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <utility>

#include "common/app/stage_monitor.h"
#include "common/config/required.h"
#include "common/core/image.h"
#include "common/core/number_text.h"
#include "common/core/pair_names.h"
#include "common/core/read_text.h"
#include "common/core/sleep.h"
#include "common/picture/eight_bits.h"
#include "services/capture/triplet_synchronizer.h"

namespace sprout::capture {
namespace {

// The text as a pattern of glob() that matches it alone.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '*' || c == '?' || c == '[' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

// Whether printf() writes a number so with at least `width` digits.
bool IsNumber(std::string_view text, size_t width) {
  const bool is_number =
      !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
  return is_number && text.size() >= width &&
         (text.size() == std::max<size_t>(width, 1) || text.front() != '0');
}

// The images whose names are a pattern with one number, such as left_%04d.png, in the order of
// their numbers.
// @throws ConfigError naming a pattern that is invalid, or that no image's name matches.
std::vector<std::string> ImageList(const std::string& pattern) {
  const auto refuse = [&](const std::string& why) {
    throw ConfigError("image list " + pattern + ": " + why);
  };
  const size_t percent = pattern.find('%');
  const size_t end = pattern.find('d', percent);
  const std::string before = pattern.substr(0, percent);
  const std::string after = end == std::string::npos ? std::string() : pattern.substr(end + 1);
  const std::string width = pattern.substr(percent + 1, end - percent - 1);
  const auto digits = width.empty() ? 0 : ParseNumber<int>(width);
  constexpr int kMaxDigits = 20;
  if (end == std::string::npos || after.find('%') != std::string::npos || !digits || *digits < 0 ||
      *digits > kMaxDigits) {
    refuse("not a name with one number; allowed: such as left_%04d.png");
  }
  std::vector<std::string> files = FilesMatching(Escaped(before) + '*' + Escaped(after));
  std::erase_if(files, [&](const std::string& file) {
    const std::string_view number =
        std::string_view(file).substr(before.size(), file.size() - before.size() - after.size());
    return !IsNumber(number, static_cast<size_t>(*digits));
  });
  if (files.empty()) refuse("cannot be opened: no image is called so" + WhyClosed(pattern));
  std::ranges::sort(files, ComesBefore);
  return files;
}

constexpr std::chrono::seconds kRetryPeriod{1};

bool IsList(const std::string& place) {
  return !IsDevice(place) && place.find('%') != std::string::npos;
}

// Joins the pictures of two videos by their times.
class VideoJoiner {
 public:
  using Both = std::array<std::unique_ptr<Pictures>, 2>;

  VideoJoiner(Both videos, double offset_ms)
      : videos_(std::move(videos)),
        offset_us_(std::llround(1000 * offset_ms)),
        synchronizer_({.max_spread_us = HalfPeriod(videos_), .has_tof = false}) {}

  static bool CanJoin(const Both& videos) { return videos[0]->Rate() > 0 && videos[1]->Rate() > 0; }

  // The next two pictures; nothing at the end of either video.
  std::optional<Triplet> Next() {
    while (true) {
      if (auto pair = synchronizer_.Next(std::min(newest_[0], newest_[1]))) return pair;
      const size_t behind = newest_[0] <= newest_[1] ? 0 : 1;
      if (!Push(behind)) return std::nullopt;
    }
  }

  std::string EndText() const {
    const std::string left = videos_[0]->EndText();
    return left.empty() ? videos_[1]->EndText() : left;
  }

  // Pictures of the slower video without a partner, since the last call.
  int64_t TakeLost() {
    const bool left_is_slower = videos_[0]->Rate() <= videos_[1]->Rate();
    const int64_t unpaired =
        synchronizer_.unpaired(left_is_slower ? RigPlace::kLeft : RigPlace::kRight);
    return unpaired - std::exchange(unpaired_, unpaired);
  }

 private:
  static int64_t HalfPeriod(const Both& videos) {
    return std::max<int64_t>(1,
                             std::llround(0.5e6 / std::max(videos[0]->Rate(), videos[1]->Rate())));
  }

  bool Push(size_t which) {
    Pictures& video = *videos_[which];
    if (!video.Grab()) return false;
    const std::optional<int64_t> time = video.Time();
    cv::Mat picture = video.Retrieve().pixels;
    if (!time || picture.empty()) return false;
    newest_[which] = *time + (which == 1 ? offset_us_ : 0);
    synchronizer_.Push(which == 0 ? RigPlace::kLeft : RigPlace::kRight,
                       {.utime = newest_[which], .image = std::move(picture), .tof = {}});
    return true;
  }

  Both videos_;
  int64_t offset_us_;
  TripletSynchronizer synchronizer_;
  std::array<int64_t, 2> newest_ = {-1, -1};  // times, µs; −1: none yet
  int64_t unpaired_ = 0;
};

class VideoSource : public RawSource {
 public:
  explicit VideoSource(const VideoSettings& settings)
      : settings_(settings),
        is_live_(std::any_of(settings.places.begin(), settings.places.end(), IsDevice)),
        eight_bits_(settings.bits) {
    if (const std::optional<std::string> refused = Open()) {
      throw ConfigError("video " + *refused + ": cannot be opened" + WhyClosed(*refused) +
                        "; allowed: a video, an image list (left_%04d.png), a "
                        "device (/dev/video0)");
    }
  }

  bool is_live() const override { return is_live_; }

  std::optional<scenes::CapturedFrame> Next(const std::stop_token& stop) override {
    std::string trouble;
    bool opened_again = false;
    while (!stop.stop_requested()) {
      if (std::optional<scenes::CapturedFrame> frame = Grab()) {
        Require(*frame);
        TakeLostInto(*frame);
        if (!trouble.empty()) frame->trouble = trouble;
        return frame;
      }
      if (is_live_) {
        if (trouble.empty()) {
          TellWaiting(settings_.waiting, silent_ + ": no picture, is opened again every second");
        }
        trouble = silent_ + ": no picture, opened again";
        SleepFor(kRetryPeriod, stop);
      } else if (!settings_.loop || std::exchange(opened_again, true)) {
        return std::nullopt;
      }
      if (std::optional<std::string> refused = Open()) silent_ = *std::move(refused);
    }
    return std::nullopt;
  }

  scenes::LostFrames lost_at_end() const override {
    if (is_live_) return {};
    scenes::LostFrames lost{.count = lost_, .trouble = trouble_};
    for (const auto& video : videos_) {
      if (std::string text = video->EndText(); !text.empty()) lost.trouble = std::move(text);
    }
    if (joiner_ && !joiner_->EndText().empty()) lost.trouble = joiner_->EndText();
    return lost;
  }

 private:
  // @returns the place that cannot be opened; nothing when all can.
  std::optional<std::string> Open() {
    videos_.clear();
    joiner_.reset();
    const std::vector<std::string>& places = settings_.places;
    if (places.size() == 2 && IsList(places[0]) && IsList(places[1])) {
      OpenLists(places[0], places[1]);
      return std::nullopt;
    }
    for (const std::string& place : places) {
      std::unique_ptr<Pictures> opened =
          IsList(place) ? OpenImages(ImageList(place)) : OpenVideoPictures(place, settings_.device);
      if (!opened) {
        videos_.clear();  // a single video would be taken for one with both views
        return place;
      }
      videos_.push_back(std::move(opened));
    }
    if (videos_.size() != 2 || is_live_) return std::nullopt;
    VideoJoiner::Both both = {std::move(videos_[0]), std::move(videos_[1])};
    if (VideoJoiner::CanJoin(both)) {
      videos_.clear();
      joiner_.emplace(std::move(both), settings_.offset_ms);
    } else {
      videos_[0] = std::move(both[0]);
      videos_[1] = std::move(both[1]);
    }
    return std::nullopt;
  }

  void OpenLists(const std::string& left, const std::string& right) {
    const std::vector<std::string> lefts = ImageList(left);
    const std::vector<std::string> rights = ImageList(right);
    const PairedNames paired =
        Required(PairNames(lefts, rights), "image lists " + left + " and " + right + ": ");
    std::vector<std::string> first;
    std::vector<std::string> second;
    for (const auto& pair : paired.pairs) {
      first.push_back(lefts[pair.first]);
      second.push_back(rights[pair.second]);
    }
    videos_.push_back(OpenImages(std::move(first)));
    videos_.push_back(OpenImages(std::move(second)));
    lost_ = std::ssize(paired.alone_first) + std::ssize(paired.alone_second);
    if (lost_ == 0) return;
    trouble_ = (paired.alone_first.empty() ? rights[paired.alone_second.front()]
                                           : lefts[paired.alone_first.front()]) +
               ": has no partner";
    if (lost_ == 2) trouble_ += ", nor has one other";
    if (lost_ > 2) trouble_ += fmt::format(", nor have {} others", lost_ - 1);
  }

  std::optional<scenes::CapturedFrame> Grab() {
    if (!joiner_) return GrabTogether();
    std::optional<Triplet> pair = joiner_->Next();
    const int64_t lost = joiner_->TakeLost();
    if (lost > 0) trouble_ = "a picture of one video without one of the other at its time";
    lost_ += lost;
    if (!pair) return std::nullopt;
    scenes::CapturedFrame frame;
    frame.left = std::move(pair->left.image);
    frame.right = std::move(pair->right.image);
    frame.spread_ms = pair->spread_ms();
    return frame;
  }

  // Takes both pictures before it decodes either, so that they are of one time.
  std::optional<scenes::CapturedFrame> GrabTogether() {
    if (videos_.empty()) return std::nullopt;  // a lost device that could not be opened again yet
    const auto is_silent = [&](size_t i) {
      silent_ = settings_.places[i];
      return std::nullopt;
    };
    for (size_t i = 0; i < videos_.size(); ++i) {
      if (!GrabNewest(*videos_[i])) return is_silent(i);
    }
    scenes::CapturedFrame frame;
    Stamp(frame);
    std::vector<CameraImage> pictures;
    for (size_t i = 0; i < videos_.size(); ++i) {
      pictures.push_back(videos_[i]->Retrieve());
      if (pictures.back().pixels.empty()) return is_silent(i);
    }
    eight_bits_.Convert({&pictures.front(), &pictures.back()});
    if (std::string note = eight_bits_.TakeNote(); !note.empty()) trouble_ = std::move(note);
    if (pictures.size() == 2) {
      frame.left = pictures[0].pixels;
      frame.right = pictures[1].pixels;
    } else {
      const cv::Mat& both = pictures[0].pixels;
      frame.left = both.colRange(0, both.cols / 2).clone();
      frame.right = both.colRange(both.cols - both.cols / 2, both.cols).clone();
    }
    return frame;
  }

  // Sets the time at which the devices took the pictures, if their drivers give it.
  void Stamp(scenes::CapturedFrame& frame) const {
    const auto left = videos_.front()->Age();
    const auto right = videos_.back()->Age();
    if (!left || !right) return;
    frame.utime = NowUtime() - (*left + *right).count() / 2;
    frame.spread_ms = std::abs(static_cast<double>((*left - *right).count())) * 1e-3;
  }

  void TakeLostInto(scenes::CapturedFrame& frame) {
    frame.lost = std::exchange(lost_, 0);
    frame.trouble = std::exchange(trouble_, {});
  }

  static void Require(const scenes::CapturedFrame& frame) {
    if (frame.left.size() != frame.right.size()) {
      throw ConfigError("video: the left picture has " + SizeText(frame.left.size()) +
                        ", the right one " + SizeText(frame.right.size()) + "; allowed: one size");
    }
    for (const cv::Mat& picture : {frame.left, frame.right}) {
      if (picture.type() == CV_8UC1 || picture.type() == CV_8UC3) continue;
      throw ConfigError("video: pictures of OpenCV's type " + cv::typeToString(picture.type()) +
                        "; allowed: grey or colour with 8 or 16 bits");
    }
  }

  VideoSettings settings_;
  bool is_live_;
  EightBits eight_bits_;
  std::vector<std::unique_ptr<Pictures>> videos_;
  std::optional<VideoJoiner> joiner_;  // instead of videos_, for two videos with known rates
  std::string silent_;                 // place that gave no picture, or could not be opened again
  int64_t lost_ = 0;                   // since the last frame
  std::string trouble_;
};

}  // namespace

std::unique_ptr<RawSource> OpenVideo(const VideoSettings& settings) {
  return std::make_unique<VideoSource>(settings);
}

}  // namespace sprout::capture
