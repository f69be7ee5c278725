#include "services/tools/calibrate/coverage.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "services/tools/calibrate/rig_model.h"

namespace sprout::calibrate {
namespace {

constexpr double kTiltedSine = 0.26;  // 15°
constexpr int kFewTilted = 2;         // of each kind

constexpr std::array<const char*, Coverage::kTilts> kTiltNames = {"right edge", "left edge",
                                                                  "lower edge", "upper edge"};

// All corners of a board that shows some, as far as they can be told: those whose markers are too
// small to be read lie where the others say.
BoardCorners AllCorners(const Board& board, const BoardCorners& found, const cv::Mat1f& amplitude) {
  if (found.size() < kMinCorners) return {};
  std::vector<cv::Point2d> on_board;
  for (const int id : found.ids) on_board.emplace_back(board.corner(id).x(), board.corner(id).y());
  const cv::Mat homography = cv::findHomography(on_board, found.pixels);
  if (homography.empty()) return found;
  std::vector<cv::Point2d> all;
  for (int id = 0; id < board.corner_count(); ++id) {
    all.emplace_back(board.corner(id).x(), board.corner(id).y());
  }
  BoardCorners expected;
  cv::perspectiveTransform(all, expected.pixels, homography);
  for (int id = 0; id < board.corner_count(); ++id) expected.ids.push_back(id);
  return FindCornersNear(board, expected, amplitude);
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
    if (views(camera) < kFewViews) {
      missing.push_back(fmt::format("the {} camera has {} views of {} or more",
                                    kCameraNames[camera], views(camera), kFewViews));
    }
    for (std::string& line : MissingNinths(kCameraNames[camera], ninths(camera))) {
      missing.push_back(std::move(line));
    }
  }
  for (size_t tilt = 0; tilt < kTilts; ++tilt) {
    if (tilted_[tilt] >= kFewTilted) continue;
    missing.push_back(fmt::format("tilt the board by 20 to 40 degrees, its {} nearer ({} of {})",
                                  kTiltNames[tilt], tilted_[tilt], kFewTilted));
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

}  // namespace sprout::calibrate
