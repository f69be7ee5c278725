#include "services/capture/ros2/ros_triplets.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/core/image.h"
#include "common/core/printable.h"
#include "common/ros/from_ros.h"

namespace sprout::capture {
namespace {

TripletConfig ConfigOf(const RosSettings& settings, bool takes_points) {
  return {.max_spread_us = std::llround(settings.max_spread_ms * 1000),
          .has_tof = takes_points || !settings.depth.empty()};
}

// Number of newest stamps of each camera that WhyUnpaired() compares: those of a second or two.
constexpr size_t kStamps = 16;

// Decodes a message and gives its content to `convert`, and its stamp to `timed`.
template <typename Ros, typename Convert>
std::invoke_result_t<Convert, const Ros&> Stamped(const RosBytes& message, TimedImage& timed,
                                                  const Convert& convert) {
  const Result<RosMessage<Ros>> ros = ReadCdr<Ros>(message.cdr);
  if (!ros) return tl::unexpected(ros.error());
  const Result<int64_t> utime = FromRosStamp((*ros)->header);
  if (!utime) return tl::unexpected(utime.error());
  timed.utime = *utime;
  return convert(**ros);
}

// Decodes an image that may be compressed.
// @param size     that it must have; nothing: any.
// @param convert  takes a RosImage, or a RosCompressedImage and the size.
template <typename Convert>
std::invoke_result_t<Convert, const RosImage&> Decoded(const RosBytes& message,
                                                       const std::string& what,
                                                       const std::optional<cv::Size>& size,
                                                       TimedImage& timed, const Convert& convert) {
  auto image = message.is_compressed
                   ? Stamped<RosCompressedImage>(
                         message, timed, [&](const auto& ros) { return convert(ros, size); })
                   : Stamped<RosImage>(message, timed, convert);
  if (!image || !size) return image;
  const Result<void> fits = CheckImageSize(what, image->size(), *size);
  return fits.map([&] { return std::move(*image); });
}

RigPlace PlaceOf(RosRole role) {
  if (role == RosRole::kLeft) return RigPlace::kLeft;
  return role == RosRole::kRight ? RigPlace::kRight : RigPlace::kTof;
}

// Smallest distance between a stamp of left and one of right, ms.
double NearestMs(const std::array<std::deque<int64_t>, 2>& stamps) {
  double nearest_ms = std::numeric_limits<double>::infinity();
  for (const int64_t left : stamps[0]) {
    for (const int64_t right : stamps[1]) {
      nearest_ms = std::min(nearest_ms, std::abs(static_cast<double>(left - right)) * 1e-3);
    }
  }
  return nearest_ms;
}

}  // namespace

void CloudWatch::Add(size_t count, size_t usable, std::string_view frame, const TofImage& image) {
  if (has_hit_) return;
  ++clouds_;
  has_hit_ = std::ranges::any_of(image.depth_m, IsReturn);
  count_ = count;
  usable_ = usable;
  frame_ = frame;
}

std::string CloudWatch::Trouble(const std::string& topic, bool at_end) {
  const bool is_due = clouds_ > 0 && !has_hit_ && (at_end || clouds_ >= next_report_);
  if (!is_due) return {};
  while (next_report_ <= clouds_) next_report_ *= 10;
  if (count_ == 0) return fmt::format("the {} clouds of {} have no points", clouds_, topic);
  const size_t left_out = count_ - usable_;
  return fmt::format(
      "none of {} points of {} is in the left image{}; allowed are m along the axes of their frame "
      "'{}' (of an optical one z points ahead), where the transforms, pose or rig file place it",
      count_, topic,
      left_out > 0 ? fmt::format(", {} are not finite or beyond 1000 m (in mm?)", left_out) : "",
      Printable(frame_));
}

RosTriplets::RosTriplets(const RosSettings& settings, std::optional<cv::Size> size,
                         std::optional<cv::Size> range_size, ImageOfPoints image)
    : size_(size),
      range_size_(range_size),
      image_of_points_(std::move(image)),
      topics_{settings.left, settings.right},
      sensor_(settings.depth.empty() ? settings.points : settings.depth),
      synchronizer_(ConfigOf(settings, image_of_points_ != nullptr)),
      eight_bits_(settings.bits),
      max_spread_ms_(settings.max_spread_ms) {}

Result<TimedImage> RosTriplets::DecodePoints(const RosBytes& message) {
  TimedImage timed;
  size_t count = 0;
  std::string frame;
  const auto points = Stamped<RosPointCloud>(message, timed, [&](const RosPointCloud& ros) {
    count = size_t{ros.width} * ros.height;
    frame = RosText(ros.header.frame_id);
    return FromRosCloud(ros);
  });
  if (!points) return tl::unexpected(points.error());
  timed.tof = image_of_points_(*points);
  cloud_watch_.Add(count, points->size(), frame, timed.tof);
  return timed;
}

Result<TimedImage> RosTriplets::Decode(const RosBytes& message) {
  if (message.role == RosRole::kPoints) return DecodePoints(message);
  TimedImage timed;
  if (message.role == RosRole::kDepth) {
    const auto convert = [](const auto&... ros) { return FromRosDepth(ros...); };
    return Decoded(message, "range image", range_size_, timed, convert).map([&](cv::Mat1f depth_m) {
      timed.tof.depth_m = std::move(depth_m);
      return std::move(timed);
    });
  }
  const auto convert = [](const auto&... ros) { return FromRosImage(ros...); };
  return Decoded(message, "image", size_, timed, convert).map([&](cv::Mat image) {
    timed.image = std::move(image);
    return std::move(timed);
  });
}

Result<void> RosTriplets::Take(const RosBytes& message) {
  const bool is_image = message.role == RosRole::kLeft || message.role == RosRole::kRight ||
                        message.role == RosRole::kDepth ||
                        (message.role == RosRole::kPoints && image_of_points_);
  if (!is_image) return {};
  Result<TimedImage> timed = Decode(message);
  const RigPlace place = PlaceOf(message.role);
  const size_t side = place == RigPlace::kLeft ? 0 : 1;
  if (place != RigPlace::kTof) ++came_[side];
  if (timed && place != RigPlace::kTof) {
    if (first_stamps_[side].size() < kStamps) first_stamps_[side].push_back(timed->utime);
    const Result<void> noted = NoteStamp(stamps_[side], timed->utime);
    if (!noted) timed = tl::unexpected(noted.error());
  }
  if (!timed) {
    // Counted when its partner is found to have none; this is the reason that is then given.
    trouble_ = timed.error().text;
    (place == RigPlace::kTof ? range_trouble_ : refusal_) = trouble_;
    return tl::unexpected(timed.error());
  }
  synchronizer_.Push(place, std::move(*timed));
  return {};
}

// Refuses a stamp that was there before: images are joined by nothing but their stamps.
Result<void> RosTriplets::NoteStamp(std::deque<int64_t>& stamps, int64_t utime) {
  if (!stamps.empty() && stamps.back() == utime) {
    return Fail(
        fmt::format("header.stamp = {:.6f}: that of the image before it{}; allowed is the "
                    "time of each image, by which left and right are joined",
                    static_cast<double>(utime) * 1e-6, utime == 0 ? ", none was set" : ""));
  }
  newest_utime_ = utime;
  stamps.push_back(utime);
  if (stamps.size() > kStamps) stamps.pop_front();
  return {};
}

void RosTriplets::Use(cv::Size size, std::optional<cv::Size> range_size, ImageOfPoints image) {
  size_ = size;
  range_size_ = range_size;
  image_of_points_ = std::move(image);
}

// Why an image has no partner: stamps differ, or single images did not come.
std::string RosTriplets::WhyUnpaired() const {
  const double nearest_ms = NearestMs(stamps_);
  if (nearest_ms <= max_spread_ms_) {
    return "an image of left or right without its partner: that was lost on the way, or never sent";
  }
  return fmt::format(
      "left and right images are {:.1f} ms apart or more: allowed is max_spread_ms = {}",
      nearest_ms, max_spread_ms_);
}

// Why most images of a whole recording became no frame; empty when at least half of them did, or
// when none did, which the newest trouble explains.
std::string RosTriplets::WhyMostAreLost() const {
  for (size_t side = 0; side < topics_.size(); ++side) {
    if (came_[side] == 0) return "no message came on " + topics_[side];
  }
  const int64_t pairs = synchronizer_.tof_joins().pairs;
  if (pairs == 0 || 2 * pairs >= std::min(came_[0], came_[1])) return {};
  std::string why = refusal_.empty() ? WhyUnpaired() : refusal_;
  if (refusal_.empty() && NearestMs(first_stamps_) <= max_spread_ms_) {
    why =
        "left and right ones of one time stand too far apart by the log times of the recording; "
        "allowed is that these follow the stamps";
  }
  return fmt::format("of {} left and {} right images {} pairs became frames: {}", came_[0],
                     came_[1], pairs, why);
}

scenes::LostFrames RosTriplets::LostSince(bool at_end) {
  const int64_t unpaired =
      synchronizer_.unpaired(RigPlace::kLeft) + synchronizer_.unpaired(RigPlace::kRight);
  if (begins_) unpaired_ = unpaired;
  begins_ = stamps_[0].empty() || stamps_[1].empty();
  scenes::LostFrames lost{.count = unpaired - std::exchange(unpaired_, unpaired)};
  // A message that was refused explains why its partner has none.
  if (lost.count > 0) lost.trouble = trouble_.empty() ? WhyUnpaired() : std::exchange(trouble_, {});
  if (!lost.trouble.empty() && !at_end) return lost;
  if (at_end) {
    if (std::string why = WhyMostAreLost(); !why.empty()) {
      lost.trouble = std::move(why);
      lost.lacks_most = true;
    }
  }
  const TofJoins& joins = synchronizer_.tof_joins();
  std::string no_ranges = JoinTrouble(joins, synchronizer_.config(), sensor_, at_end);
  std::string no_points = cloud_watch_.Trouble(sensor_, at_end);
  const bool lacks_most =
      10 * joins.joined <= std::min(joins.came, joins.pairs) || !no_points.empty();
  if (!no_points.empty() && (joins.joined > 0 || no_ranges.empty()))
    no_ranges = std::move(no_points);
  if (no_ranges.empty()) return lost;
  if (joins.came == 0 && !range_trouble_.empty()) {
    no_ranges = fmt::format("no range image of {} can be used: {}", sensor_, range_trouble_);
  }
  lost.lacks_most |= at_end && lacks_most;
  lost.trouble += (lost.trouble.empty() ? "" : "; ") + no_ranges;
  return lost;
}

std::optional<scenes::CapturedFrame> RosTriplets::Next() {
  // At the end no image is waited for.
  constexpr int64_t kForever = std::numeric_limits<int64_t>::max() / 2;
  std::optional<Triplet> triplet = synchronizer_.Next(is_finished_ ? kForever : newest_utime_);
  if (!triplet) return std::nullopt;
  CameraImage left{.pixels = std::move(triplet->left.image)};
  CameraImage right{.pixels = std::move(triplet->right.image)};
  eight_bits_.Convert({&left, &right});
  scenes::CapturedFrame frame{.left = std::move(left.pixels),
                              .right = std::move(right.pixels),
                              .tof = triplet->tof ? std::move(triplet->tof->tof) : TofImage{},
                              .utime = triplet->utime()};
  frame.spread_ms = triplet->spread_ms();
  scenes::LostFrames lost = LostSince(/*at_end=*/false);
  frame.lost = lost.count;
  frame.trouble = std::move(lost.trouble);
  if (frame.trouble.empty()) frame.trouble = eight_bits_.TakeNote();
  trouble_.clear();
  return frame;
}

}  // namespace sprout::capture
