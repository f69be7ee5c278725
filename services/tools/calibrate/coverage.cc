#include "services/tools/calibrate/coverage.h"

#include <fmt/core.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "common/core/image.h"
#include "services/tools/calibrate/rig_model.h"

namespace sprout::calibrate {
namespace {

constexpr double kTiltedSine = 0.26;  // 15°
constexpr int kMinTilted = 2;         // of each kind

constexpr std::array<const char*, Coverage::kTilts> kTiltNames = {"right edge", "left edge",
                                                                  "lower edge", "upper edge"};

std::vector<cv::Point2d> PlacesOf(const Board& board, const std::vector<int>& ids) {
  std::vector<cv::Point2d> places;
  for (const int id : ids) places.emplace_back(board.corner(id).x(), board.corner(id).y());
  return places;
}

// The found corners, and those whose markers are too small to be read, at the places that the
// others predict.
BoardCorners AllCorners(const Board& board, const BoardCorners& found, const cv::Mat1f& amplitude) {
  if (found.size() < kMinCorners) return {};
  const cv::Mat homography = cv::findHomography(PlacesOf(board, found.ids), found.pixels);
  if (homography.empty()) return found;
  BoardCorners expected;
  for (int id = 0; id < board.corner_count(); ++id) expected.ids.push_back(id);
  cv::perspectiveTransform(PlacesOf(board, expected.ids), expected.pixels, homography);
  return FindCornersNear(board, expected, amplitude);
}

// Least move of a new view, as a share of the image's width: 1 cm at 1 m for a lens of 53°. Nearer
// views tell little more.
constexpr double kNewShift = 0.01;

// Fastest move of a board that counts as still, as a share of the image's width a second. When
// exposures are 5 ms apart (rig.proto, max_spread_ms), corners move by 0.2 px of 2000 meanwhile.
constexpr double kStillShiftPerS = 0.02;

// Triplets that are further apart in time than this, µs, do not show whether the board moves.
constexpr int64_t kMotionUs = 500'000;

// Mean distance of the corners that both have, px; nothing when there are few.
std::optional<double> MeanShift(const BoardCorners& a, const BoardCorners& b) {
  double sum = 0;
  int shared = 0;
  for (size_t i = 0, j = 0; i < a.ids.size() && j < b.ids.size();) {
    if (a.ids[i] < b.ids[j]) {
      ++i;
    } else if (b.ids[j] < a.ids[i]) {
      ++j;
    } else {
      sum += cv::norm(a.pixels[i++] - b.pixels[j++]);
      ++shared;
    }
  }
  if (shared < kMinCorners) return std::nullopt;
  return sum / shared;
}

}  // namespace

size_t NinthOf(const cv::Point2d& pixel, cv::Size size) {
  const auto part = [](double position, int length) {
    return std::clamp(static_cast<int>(3 * (position + 0.5) / length), 0, 2);
  };
  return static_cast<size_t>(3 * part(pixel.y, size.height) + part(pixel.x, size.width));
}

std::vector<std::string> MissingNinths(const std::string& camera, const Ninths& corners) {
  static constexpr std::array<const char*, 9> kNinths = {
      "upper left",   "upper middle", "upper right",  "middle left", "middle",
      "middle right", "lower left",   "lower middle", "lower right"};
  std::vector<std::string> lines;
  for (size_t i = 0; i < kNinths.size(); ++i) {
    if (corners[i] >= kMinCornersInNinth) continue;
    lines.push_back(
        fmt::format("the {} image's {} ninth has {}: show the board there", camera, kNinths[i],
                    corners[i] == 0 ? "no corner" : fmt::format("{} corners only", corners[i])));
  }
  return lines;
}

void Coverage::Add(const BoardView& view, const std::array<cv::Size, kCameraCount>& sizes) {
  for (const CameraIndex index : {kLeft, kRight, kTof}) {
    OfCamera& camera = cameras_[index];
    camera.size = sizes[index];
    const BoardCorners corners = index == kTof
                                     ? AllCorners(board_, view.corners[kTof], view.tof.amplitude)
                                     : view.corners[index];
    if (corners.size() < kMinCorners) continue;
    ++camera.views;
    for (const cv::Point2d& pixel : corners.pixels) ++camera.corners[NinthOf(pixel, camera.size)];
  }
  const CameraIndex best =
      view.corners[kLeft].size() < view.corners[kRight].size() ? kRight : kLeft;
  const std::optional<Placed> placed = PlaceOf(view.corners[best], sizes[best]);
  if (!placed) return;
  nearest_ = nearest_ == 0 ? placed->distance : std::min(nearest_, placed->distance);
  farthest_ = std::max(farthest_, placed->distance);
  // An edge is nearer when the board's normal, away from the cameras, leans to its side.
  tilted_[kRightNearer] += placed->normal[0] > kTiltedSine ? 1 : 0;
  tilted_[kLeftNearer] += placed->normal[0] < -kTiltedSine ? 1 : 0;
  tilted_[kLowerNearer] += placed->normal[1] > kTiltedSine ? 1 : 0;
  tilted_[kUpperNearer] += placed->normal[1] < -kTiltedSine ? 1 : 0;
}

// By a lens of 53° without distortion: good enough to tell directions and ratios.
std::optional<Coverage::Placed> Coverage::PlaceOf(const BoardCorners& corners,
                                                  cv::Size size) const {
  if (corners.size() < kMinCorners) return std::nullopt;
  std::vector<cv::Point3d> on_board;
  for (const int id : corners.ids) {
    on_board.emplace_back(board_.corner(id).x(), board_.corner(id).y(), 0);
  }
  const cv::Matx33d lens(size.width, 0, size.width / 2.0, 0, size.width, size.height / 2.0, 0, 0,
                         1);
  cv::Vec3d turn;
  cv::Vec3d place;
  if (!cv::solvePnP(on_board, corners.pixels, lens, cv::noArray(), turn, place)) {
    return std::nullopt;
  }
  cv::Matx33d rotation;
  cv::Rodrigues(turn, rotation);
  const Eigen::Vector2d middle = board_.extent_m() / 2;
  return Placed{.normal = rotation * cv::Vec3d(0, 0, 1),
                .distance = cv::norm(rotation * cv::Vec3d(middle.x(), middle.y(), 0) + place)};
}

std::vector<std::string> Coverage::Missing() const {
  std::vector<std::string> missing;
  for (const CameraIndex camera : {kLeft, kRight, kTof}) {
    if (camera == kTof && !HasTof()) continue;
    if (views(camera) < kMinViewsOfCamera) {
      missing.push_back(fmt::format("the {} camera has {} views of {} or more",
                                    kCameraNames[camera], views(camera), kMinViewsOfCamera));
    }
    for (std::string& line : MissingNinths(kCameraNames[camera], ninths(camera))) {
      missing.push_back(std::move(line));
    }
  }
  for (size_t tilt = 0; tilt < kTilts; ++tilt) {
    if (tilted_[tilt] >= kMinTilted) continue;
    missing.push_back(fmt::format("tilt the board by 20 to 40 degrees, its {} nearer ({} of {})",
                                  kTiltNames[tilt], tilted_[tilt], kMinTilted));
  }
  if (farthest_ < kMinRangeRatio * nearest_ || nearest_ == 0) {
    missing.emplace_back("show the board nearer and farther, over the ranges that you will need");
  }
  return missing;
}

std::string Coverage::Text() const {
  std::string text;
  const auto row = [&](const char* name, const auto& cell) {
    text += fmt::format("{:<8}", name);
    for (const CameraIndex camera : {kLeft, kRight, kTof}) {
      if (camera != kTof || HasTof()) text += fmt::format("  {:<15}", cell(camera));
    }
    while (text.ends_with(' ')) text.pop_back();
    text += "\n";
  };
  row("", [&](CameraIndex camera) { return std::string(kCameraNames[camera]); });
  row("views", [&](CameraIndex camera) { return std::to_string(views(camera)); });
  for (size_t i = 0; i < 9; i += 3) {
    row(i == 0 ? "corners" : "", [&](CameraIndex camera) {
      const Ninths& n = ninths(camera);
      return fmt::format("{:>4} {:>4} {:>4}", n[i], n[i + 1], n[i + 2]);
    });
  }
  text += "tilted  ";
  for (size_t tilt = 0; tilt < kTilts; ++tilt) {
    text += fmt::format("  {} nearer {}{}", kTiltNames[tilt], tilted_[tilt],
                        tilt + 1 < kTilts ? "," : "\n");
  }
  if (nearest_ > 0) {
    text += fmt::format("farthest  {:.2f} times as far as the nearest\n", farthest_ / nearest_);
  }
  return text;
}

void ViewCollector::Add(const RigImages& images, std::optional<int64_t> utime) {
  ++counts_.images;
  const std::array<cv::Size, kCameraCount> sizes = {images.left.size(), images.right.size(),
                                                    images.tof.depth_m.size()};
  if (sizes[kLeft] != sizes[kRight]) {
    ++counts_.two_sizes;
    return;
  }
  if (!FitsTheViews(sizes)) {
    ++counts_.other_size;
    return;
  }
  Pair pair{.left = FindBoard(board_, ToGrey(images.left)),
            .right = FindBoard(board_, ToGrey(images.right))};
  const bool moves = Moves(pair, utime, sizes[kLeft].width);
  if (std::max(pair.left.size(), pair.right.size()) < kMinCorners) {
    ++counts_.no_board;
    if (images_without_board_.size() < kMaxWithoutBoard)
      images_without_board_.push_back(ToGrey(images.left).clone());
    if (std::max(pair.left.markers, pair.right.markers) >= kMinCorners) ++counts_.foreign;
  } else if (moves) {
    ++counts_.moving;
  } else if (IsSimilar(pair)) {
    ++counts_.similar;
  } else if (std::ssize(views_) == kMaxViews) {
    ++counts_.too_many;
  } else {
    if (views_.empty()) sizes_ = sizes;
    // A ToF camera may be silent for a while.
    if (sizes_[kTof].empty()) sizes_[kTof] = sizes[kTof];
    views_.push_back({.corners = {std::move(pair.left), std::move(pair.right),
                                  FindBoardInAmplitude(board_, images.tof.amplitude)},
                      .tof = {.depth_m = images.tof.depth_m.clone(),
                              .amplitude = images.tof.amplitude.clone()}});
    int corners = 0;
    for (const BoardCorners& of_camera : views_.back().corners) corners += of_camera.size();
    if (corners <= best_corners_) return;
    best_corners_ = corners;
    best_images_ = {
        .left = images.left.clone(), .right = images.right.clone(), .tof = views_.back().tof};
  }
}

bool ViewCollector::FitsTheViews(const std::array<cv::Size, kCameraCount>& sizes) const {
  if (views_.empty()) return true;
  const bool has_both_tof = !sizes[kTof].empty() && !sizes_[kTof].empty();
  return sizes[kLeft] == sizes_[kLeft] && (!has_both_tof || sizes[kTof] == sizes_[kTof]);
}

bool ViewCollector::Moves(const Pair& pair, std::optional<int64_t> utime, int width) {
  if (!utime) return false;
  const std::optional<Timed> before = std::exchange(newest_, Timed{*utime, pair});
  if (!before || *utime - before->utime > kMotionUs || *utime <= before->utime) return false;
  const std::optional<double> shift_px = Shift(pair, before->pair);
  const double seconds = static_cast<double>(*utime - before->utime) / 1e6;
  return !shift_px || *shift_px > kStillShiftPerS * seconds * width;
}

bool ViewCollector::IsSimilar(const Pair& pair) const {
  return std::ranges::any_of(views_, [&](const BoardView& view) {
    const auto shift_px = Shift(pair, {view.corners[kLeft], view.corners[kRight]});
    return shift_px && *shift_px < kNewShift * sizes_[kLeft].width;
  });
}

std::optional<double> ViewCollector::Shift(const Pair& a, const Pair& b) {
  const std::optional<double> left = MeanShift(a.left, b.left);
  return left ? left : MeanShift(a.right, b.right);
}

}  // namespace sprout::calibrate
