// The tables of services/depth/NOTES.md, printed and held to their limits.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd/depth.hpp>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/quantile.h"
#include "common/scenes/dataset.h"
#include "common/scenes/lens_view.h"
#include "services/depth/depth_in_view.h"
#include "services/depth/flying.h"
#include "services/pipeline/pipeline.h"

namespace sprout::depth {
namespace {

using scenes::Solid;
using scenes::SyntheticScene;

constexpr double kPercent = 100;

// The room of synthetic_source.cc, seen by any camera.
class Room {
 public:
  Room(cv::Size left_size, int64_t index)
      : pair_{.width = left_size.width,
              .height = left_size.height,
              .focal_px = 0.9 * left_size.width,
              .cx = (left_size.width - 1) / 2.0,
              .cy = (left_size.height - 1) / 2.0,
              .cx_right = 1.01 * left_size.width / 2.0,
              .baseline_m = 0.2},
        solids_(SyntheticScene(1, 1.6 * left_size.height / (2 * pair_.focal_px)).At(index)) {}

  const RectifiedPair& pair() const { return pair_; }

  /// True depth along the axis of a camera.
  cv::Mat1f Depth(const Lens& lens, const Pose& left_from_camera) const {
    cv::Mat1f depth(lens.size(), std::numeric_limits<float>::quiet_NaN());
    scenes::LensView(lens, left_from_camera.rotation, left_from_camera.translation_m, 1)
        .Cast(solids_, pair_.focal_px, [&](int x, int y, double z, const scenes::Vec3&) {
          depth(y, x) = static_cast<float>(z);
        });
    return depth;
  }

  DisparityImage LeftMap() const {
    const cv::Mat1f depth = Depth(
        {pair_.width, pair_.height, pair_.focal_px, pair_.focal_px, pair_.cx, pair_.cy, {}}, {});
    DisparityImage map(pair_.size());
    for (int v = 0; v < map.height(); ++v) {
      for (int u = 0; u < map.width(); ++u) {
        map.counts()(v, u) = ToCounts(pair_.DisparityFromDepth(double{depth(v, u)}));
      }
    }
    return map;
  }

  /// Whether the left camera sees a point of a surface.
  bool LeftSees(const Eigen::Vector3d& point) const {
    if (!(point.z() > 0)) return false;
    const double u = pair_.focal_px * point.x() / point.z() + pair_.cx;
    const double v = pair_.focal_px * point.y() / point.z() + pair_.cy;
    if (u < 0 || v < 0 || u > pair_.width - 1 || v > pair_.height - 1) return false;
    const scenes::Ray ray{{}, {point.x() / point.z(), point.y() / point.z(), 1}};
    return std::none_of(solids_.begin(), solids_.end(), [&](const Solid& solid) {
      return scenes::Intersect(solid, ray) < point.z() * (1 - 1e-4);
    });
  }

 private:
  RectifiedPair pair_;
  std::vector<Solid> solids_;
};

// Shares of the target's pixels, %.
struct ViewScore {
  double right = 0;  // within 1 %, of those that both cameras see
  double wrong = 0;  // more than 1 % off, of all
  double ghost = 0;  // of these those of a depth that no pixel around has
};

bool IsWithin(double depth, double truth) { return std::abs(depth / truth - 1) <= 0.01; }

// The target's pixels that the left camera sees too.
cv::Mat1b SeenByBoth(const Room& room, const cv::Mat1f& truth, const View& view) {
  const Pose left_from_view = view.view_from_left.Inverse();
  cv::Mat1b both(truth.size());
  cv::parallel_for_({0, truth.rows}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < truth.cols; ++u) {
        const double z = double{truth(v, u)};
        const Eigen::Vector3d point((u - view.cx) * z / view.focal_px,
                                    (v - view.cy) * z / view.focal_px, z);
        both(v, u) = room.LeftSees(left_from_view.rotation * point + left_from_view.translation_m);
      }
    }
  });
  return both;
}

ViewScore ScoreOf(const cv::Mat1f& depth, const cv::Mat1f& truth, const cv::Mat1b& both) {
  int64_t right = 0, wrong = 0, ghost = 0;
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      const bool is_right = IsWithin(double{depth(v, u)}, double{truth(v, u)});
      right += both(v, u) != 0 && is_right;
      if (!(depth(v, u) > 0) || is_right) continue;
      ++wrong;
      const cv::Mat1f around = truth(cv::Rect(u - 1, v - 1, 3, 3) & cv::Rect({0, 0}, truth.size()));
      ghost += std::none_of(around.begin(), around.end(), [&](float near) {
        return IsWithin(double{depth(v, u)}, double{near});
      });
    }
  }
  const auto percent = [](int64_t count, double of) { return kPercent * double(count) / of; };
  const auto all = double(truth.total());
  return {.right = percent(right, cv::countNonZero(both)),
          .wrong = percent(wrong, all),
          .ghost = percent(ghost, all)};
}

cv::Mat1f Metres(const DepthImage& depth) {
  cv::Mat1f metres(depth.size());
  depth.counts.convertTo(metres, CV_32F, depth.metres_per_count);
  return metres;
}

cv::Mat1f RegisterDepth(const DisparityImage& map, const RectifiedPair& pair, const View& view,
                        bool dilate) {
  cv::Mat1f depth(map.size(), 0.0F);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      depth(v, u) = static_cast<float>(pair.DepthFromDisparity(double{map.Px(u, v)}));
    }
  }
  const cv::Matx33d left(pair.focal_px, 0, pair.cx, 0, pair.focal_px, pair.cy, 0, 0, 1);
  const cv::Matx33d target(view.focal_px, 0, view.cx, 0, view.focal_px, view.cy, 0, 0, 1);
  const Eigen::Matrix3d r = view.view_from_left.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = view.view_from_left.translation_m;
  const cv::Matx44d transform(r(0, 0), r(0, 1), r(0, 2), t[0], r(1, 0), r(1, 1), r(1, 2), t[1],
                              r(2, 0), r(2, 1), r(2, 2), t[2], 0, 0, 0, 1);
  // Into an image at least as large as the map: OpenCV 4.6 writes outside its memory otherwise.
  const cv::Size size(std::max(view.size.width, map.width()),
                      std::max(view.size.height, map.height()));
  cv::Mat1f registered;
  cv::rgbd::registerDepth(left, target, cv::Mat(), transform, depth, size, registered, dilate);
  registered.setTo(0, registered != registered);
  return registered(cv::Rect({0, 0}, view.size));
}

// CPU of all threads, median; and on the clock, least: other programs take time, too.
struct Times {
  double cpu_ms = 0;
  double least_ms = std::numeric_limits<double>::infinity();
};

Times TimesOf(const std::function<void()>& work) {
  constexpr int kRuns = 5;
  Times times;
  std::vector<double> cpu_ms;
  for (int i = 0; i < kRuns; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t cpu_start = std::clock();
    work();
    cpu_ms.push_back(1000.0 * double(std::clock() - cpu_start) / CLOCKS_PER_SEC);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    times.least_ms = std::min(times.least_ms, took.count());
  }
  times.cpu_ms = Median(cpu_ms);
  return times;
}

Pose PoseOf(double degrees, const Eigen::Vector3d& axis, const Eigen::Vector3d& place_m) {
  const Eigen::AngleAxisd turn(degrees * 3.14159265358979 / 180, axis.normalized());
  return {.rotation = Eigen::Quaternion<double, Eigen::DontAlign>(Eigen::Quaterniond(turn)),
          .translation_m = place_m};
}

struct Target {
  const char* name;
  Lens lens;
  Pose pose;
};

TEST(DepthAccuracy, AnotherCameraGetsWhatBothSee) {
  const Target targets[] = {{"2 MP, 10 cm left, 3 deg",
                             {1600, 1250, 1400, 1400, 805, 620, {}},
                             PoseOf(3, {0.3, 1, 0.2}, {-0.1, 0.03, 0.02})},
                            {"0.3 MP thermal, 6 cm above",
                             {640, 512, 500, 500, 321, 250, {}},
                             PoseOf(2, {1, 0.5, 0.1}, {0.05, -0.06, -0.01})},
                            {"2 MP upright, 8 cm right",
                             {1250, 1600, 1400, 1400, 620, 805, {}},
                             PoseOf(90, {0, 0, 1}, {0.08, 0, 0})},
                            {"8 MP, 10 cm left",
                             {3200, 2500, 2900, 2900, 1600, 1250, {}},
                             PoseOf(0, {0, 0, 1}, {-0.1, 0, 0})}};
  std::printf("%-28s %-14s %8s %8s %8s %8s %8s\n", "target", "method", "right %", "wrong %",
              "ghosts %", "CPU ms", "least ms");
  const Room room({1600, 1250}, 40);
  const DisparityImage map = room.LeftMap();
  for (const Target& target : targets) {
    const View view = ViewOf(target.lens, target.pose);
    const cv::Mat1f truth = room.Depth(target.lens, target.pose);
    const cv::Mat1b both = SeenByBoth(room, truth, view);
    const auto score = [&](const char* method, const std::function<cv::Mat1f()>& compute) {
      cv::Mat1f depth;
      const Times times = TimesOf([&] { depth = compute(); });
      const ViewScore s = ScoreOf(depth, truth, both);
      std::printf("%-28s %-14s %8.3f %8.3f %8.3f %8.1f %8.1f\n", target.name, method, s.right,
                  s.wrong, s.ghost, times.cpu_ms, times.least_ms);
      return s;
    };
    const ViewScore ours =
        score("Sprout", [&] { return Metres(DepthInView(map, room.pair(), view, 0.001)); });
    score("OpenCV", [&] { return RegisterDepth(map, room.pair(), view, false); });
    score("OpenCV dilated", [&] { return RegisterDepth(map, room.pair(), view, true); });
    EXPECT_GE(ours.right, 99) << target.name;
    EXPECT_LT(ours.ghost, 0.1) << target.name;
    EXPECT_GT(cv::countNonZero(both), int64_t(truth.total()) / 2) << target.name;
  }
}

// What FindFlying() does to a map with truth.
struct FlyingScore {
  int64_t flying = 0, removed = 0, good = 0, lost = 0;

  double RemovedPercent() const { return kPercent * double(removed) / double(flying); }
  double LostPercent() const { return kPercent * double(lost) / double(good); }
};

// Good is an error of at most 1 px. A disparity flies when among the truths at most 4 px away there
// are nearer and farther ones, and none within 1 px of it.
FlyingScore ScoreOf(const DisparityImage& map, const cv::Mat1f& truth) {
  constexpr int kAround = 4;
  const cv::Mat1b found = FindFlying(map);
  FlyingScore score;
  for (int v = kAround; v < truth.rows - kAround; ++v) {
    for (int u = kAround; u < truth.cols - kAround; ++u) {
      const float d = map.Px(u, v);
      if (!(std::abs(truth(v, u)) < 1e4F) || !map.IsValid(u, v)) continue;
      if (std::abs(d - truth(v, u)) <= 1) {
        ++score.good;
        score.lost += found(v, u) != 0;
        continue;
      }
      bool nearer = false, farther = false, same = false;
      for (int y = v - kAround; y <= v + kAround; ++y) {
        for (int x = u - kAround; x <= u + kAround; ++x) {
          nearer |= truth(y, x) > d + 1;
          farther |= truth(y, x) < d - 1;
          same |= std::abs(truth(y, x) - d) <= 1;
        }
      }
      if (!nearer || !farther || same) continue;
      ++score.flying;
      score.removed += found(v, u) != 0;
    }
  }
  return score;
}

DisparityImage Blurred(const cv::Mat1f& truth, int side_px) {
  cv::Mat1f blurred;
  cv::blur(truth, blurred, {side_px, side_px});
  return FromPx(blurred);
}

scenes::DatasetFrame FrameOf(const std::string& source, Rig& rig, int64_t index) {
  const auto dataset = scenes::OpenDataset(source);
  rig = dataset->rig();
  return dataset->Get(index);
}

TEST(DepthAccuracy, FlyingPointsGoAndGoodOnesStay) {
  std::vector<std::string> sources = {"synthetic:800x625?tof=sr4000"};
  if (const char* data = std::getenv("SPROUT_DATA")) {
    sources.push_back(std::string("middlebury:") + data + "/middlebury/half/Art?tof=sr4000");
    sources.push_back(std::string("middlebury:") + data + "/middlebury/half/Dolls?tof=sr4000");
  }
  std::printf("%-12s %-16s %9s %9s %9s %9s\n", "scene", "map", "flying %", "removed %", "good %",
              "lost %");
  for (const std::string& source : sources) {
    const bool synthetic = source.starts_with("synthetic");
    const std::string path = source.substr(0, source.find('?'));
    const std::string scene = synthetic ? "synthetic" : path.substr(path.rfind('/') + 1);
    Rig rig;
    const scenes::DatasetFrame frame = FrameOf(source, rig, synthetic ? 40 : 0);
    const auto score = [&](const std::string& name, const DisparityImage& map) {
      const FlyingScore s = ScoreOf(map, frame.truth.left);
      const auto all = static_cast<double>(frame.truth.left.total());
      std::printf("%-12s %-16s %9.2f %9.1f %9.2f %9.2f\n", scene.c_str(), name.c_str(),
                  kPercent * double(s.flying) / all, s.RemovedPercent(),
                  kPercent * double(s.good) / all, s.LostPercent());
      return s;
    };
    for (const int side : {3, 5, 7}) {
      if (!synthetic) continue;  // holes of the truth would spread
      const FlyingScore s =
          score("truth, " + std::to_string(side) + " px blur", Blurred(frame.truth.left, side));
      EXPECT_GT(s.RemovedPercent(), 90);
      EXPECT_LT(s.LostPercent(), 1);
    }
    for (const char* preset : {"default", "fast", "paper"}) {
      Pipeline pipeline(LoadConfig({preset}));
      const auto computed = pipeline.Compute(frame.left, frame.right, frame.tof, rig);
      ASSERT_TRUE(computed) << computed.error().text;
      const FlyingScore s = score(preset, computed->disparity);
      EXPECT_LT(s.LostPercent(), 1) << scene << ", " << preset;
    }
  }
}

}  // namespace
}  // namespace sprout::depth
