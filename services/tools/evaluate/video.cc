#include "services/tools/evaluate/video.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/output_file.h"
#include "common/core/quantile.h"
#include "common/inputs/check_inputs.h"
#include "common/measure/score.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/scenes/dataset.h"
#include "services/pipeline/chain.h"
#include "services/temporal/temporal_filter.h"
#include "services/tools/evaluate/scene.h"
#include "services/tools/evaluate/truth_check.h"

namespace sprout::evaluate {
namespace {

constexpr float kAverageWeight = 0.4F;
constexpr float kAverageStepPx = 20.0F / 32;

// The rival: a running average, see EvaluateVideo().
class RunningAverage {
 public:
  cv::Mat1f Add(const cv::Mat1f& map) {
    if (average_.empty()) average_ = map.clone();
    cv::Mat1f next = map.clone();
    for (int v = 0; v < map.rows; ++v) {
      for (int u = 0; u < map.cols; ++u) {
        const float old = average_(v, u);
        if (!std::isfinite(map(v, u))) next(v, u) = old;
        if (std::abs(map(v, u) - old) < kAverageStepPx) {
          next(v, u) = old + kAverageWeight * (map(v, u) - old);
        }
      }
    }
    return average_ = next;
  }

 private:
  cv::Mat1f average_;
};

cv::Mat WithNoise(const cv::Mat& image, double sigma, cv::RNG& random) {
  if (sigma == 0) return image;
  cv::Mat noise(image.size(), CV_16SC(image.channels()));
  random.fill(noise, cv::RNG::NORMAL, 0, sigma);
  cv::Mat sum;
  cv::add(image, noise, sum, cv::noArray(), image.depth());
  return sum;
}

std::unique_ptr<scenes::Dataset> Open(const std::string& source, const SproutConfig& config) {
  CaptureConfig capture = config.capture();
  capture.set_source(source);
  return scenes::OpenDataset(capture);
}

std::string Text(const char* format, std::optional<double> value) {
  return value ? fmt::format(fmt::runtime(format), *value) : "–";
}

std::string VideoRow(const std::string& name, const char* method, const VideoFigures& f) {
  return fmt::format("| {} | {} | {:.2f} | {:.2f} | {:.3f} | {:.3f} | {} | {} | {} | {} | {} |\n",
                     name, method, f.bad1_percent, f.bad3_percent, f.mean_px, f.change_px,
                     Text("{:.3f}", f.along_px), Text("{:.1f}", f.trail_percent),
                     Text("{:.1f}", f.covered_percent), Text("{:.3f}", f.flicker_median_px),
                     Text("{:.3f}", f.flicker_p95_px));
}

std::optional<double> MeanOf(const std::vector<VideoResult>& results,
                             VideoFigures VideoResult::*method,
                             const std::function<std::optional<double>(const VideoFigures&)>& of) {
  double sum = 0;
  for (const VideoResult& result : results) {
    const std::optional<double> value = of(result.*method);
    if (!value) return std::nullopt;
    sum += *value;
  }
  return sum / static_cast<double>(results.size());
}

VideoFigures MeanFigures(const std::vector<VideoResult>& results,
                         VideoFigures VideoResult::*method) {
  const auto mean = [&](auto member) {
    return MeanOf(results, method, [member](const VideoFigures& figures) {
      return std::optional<double>(figures.*member);
    });
  };
  return {.bad1_percent = *mean(&VideoFigures::bad1_percent),
          .bad3_percent = *mean(&VideoFigures::bad3_percent),
          .mean_px = *mean(&VideoFigures::mean_px),
          .change_px = *mean(&VideoFigures::change_px),
          .along_px = mean(&VideoFigures::along_px),
          .trail_percent = mean(&VideoFigures::trail_percent),
          .covered_percent = mean(&VideoFigures::covered_percent),
          .flicker_median_px = mean(&VideoFigures::flicker_median_px),
          .flicker_p95_px = mean(&VideoFigures::flicker_p95_px)};
}

constexpr int kStripRows = 6;
constexpr std::array<const char*, 3> kLineColors = {"#888888", "#3070c0", "#c03020"};

std::string FileName(std::string source) {
  std::ranges::replace_if(
      source, [](unsigned char c) { return std::isalnum(c) == 0 && c != '.' && c != '-'; }, '_');
  return source;
}

double BadPercent(const cv::Mat1f& error_px) {
  const int scored = cv::countNonZero(error_px >= 0);  // NaN is not
  return scored == 0 ? std::nan("") : 100.0 * cv::countNonZero(error_px > 3) / scored;
}

// A line for each map, over the numbers of the frames.
LinePlot PlotOf(const std::string& title, const std::array<std::vector<double>, 3>& lines) {
  LinePlot plot = {.title = title,
                   .along = "frame",
                   .up = "bad 3, %",
                   .right = static_cast<double>(std::max<size_t>(2, lines[0].size()) - 1),
                   .top = 0,
                   .lines = {},
                   .size = {480, 200}};
  for (size_t i = 0; i < lines.size(); ++i) {
    LinePlot::Line line = {.points = {}, .color = kLineColors[i], .name = kVideoMapNames[i]};
    for (size_t k = 0; k < lines[i].size(); ++k) {
      line.points.emplace_back(static_cast<double>(k), lines[i][k]);
      plot.top = std::max(plot.top, lines[i][k]);  // not for NaN
    }
    plot.lines.push_back(std::move(line));
  }
  if (plot.top == 0) plot.top = 1;
  return plot;
}

// Frames that are evaluated: as many as wanted, or as the source has. A scene of Middlebury's is
// shown again and again; a frame of KITTI's is no video.
// @throws ConfigError when none of them would be scored.
int FrameCount(const scenes::Dataset& dataset, const std::string& source, int wanted) {
  const bool one_scene = dataset.frame_count() == 1 && !IsKitti(source);
  int frames = wanted;
  if (!one_scene && dataset.frame_count()) {
    frames = static_cast<int>(std::min<int64_t>(frames, *dataset.frame_count()));
  }
  if (frames <= VideoScore::kFirstScored) {
    throw ConfigError(fmt::format(
        "{}: {} frames (--frames): allowed are {} and more, since the first {} are not scored",
        source, frames, VideoScore::kFirstScored + 1, VideoScore::kFirstScored));
  }
  return frames;
}

// @throws ConfigError when it has no truth.
scenes::DatasetFrame FrameWithTruth(scenes::Dataset& dataset, const std::string& source, int i) {
  scenes::DatasetFrame captured = dataset.Get(i);
  if (captured.truth.left.empty()) {
    throw ConfigError(fmt::format(
        "{}: frame {} has no ground truth; allowed: frames with ground truth", source, i));
  }
  return captured;
}

// The frame as the chain gets it, with noise that is new in each.
Frame NoisyFrame(const scenes::DatasetFrame& captured, const Rig& rig,
                 const VideoSettings& settings, int i, cv::RNG& random) {
  Frame frame;
  frame.id = {.utime = static_cast<int64_t>(std::llround(1e6 * (i + 1) / settings.rate_hz)),
              .seq = i,
              .rig_id = "video"};
  frame.left = WithNoise(captured.left, settings.image_noise, random);
  frame.right = WithNoise(captured.right, settings.image_noise, random);
  frame.tof = captured.tof;
  frame.tof_zones = captured.tof_zones;
  frame.rig = rig;
  return frame;
}

}  // namespace

VideoResult EvaluateVideo(const std::string& source, const VideoSettings& settings,
                          const std::function<void(int)>& on_frame) {
  const std::unique_ptr<scenes::Dataset> dataset = Open(source, settings.config);
  VideoResult result;
  result.source = source;
  result.frames = FrameCount(*dataset, source, settings.frames);
  const std::vector<Pose> motions = TrueMotions(source, result.frames);
  result.motion_known = !motions.empty();
  const Rig& rig = dataset->rig();
  const std::optional<TofProjector> scanner =
      IsKitti(source) ? std::optional<TofProjector>(rig) : std::nullopt;
  SproutConfig config = settings.config;
  config.mutable_grow()->set_publish_confidence(true);  // which the filter needs
  config.mutable_temporal()->set_in_pipeline(false);    // it runs here, to be timed
  Chain chain(config);
  temporal::TemporalFilter filter(config.temporal());
  RunningAverage average;
  AwayFromPoints away;
  std::array<VideoScore, 3> scores;
  VideoPictures pictures(source, result.frames);
  cv::RNG random(settings.config.capture().seed());
  std::vector<double> times_ms;
  for (int i = 0; i < result.frames; ++i) {
    on_frame(i);
    const scenes::DatasetFrame captured = FrameWithTruth(*dataset, source, i);
    if (i == 0) {
      result.wrong_inputs =
          BadText(inputs::CheckInputs(captured.left, captured.right, captured.tof, rig));
      if (result.wrong_inputs.empty()) {
        result.wrong_inputs = WrongTruthText(captured, rig.pair, scanner ? &*scanner : nullptr);
      }
    }
    Frame frame = NoisyFrame(captured, rig, settings, i, random);
    ChainObserver nobody;
    chain.Run(frame, nobody);
    cv::Mat1b memory;
    const auto begin = std::chrono::steady_clock::now();
    const temporal::TemporalOutput fused = filter.Compute({.id = frame.id,
                                                           .left = ToGrey(frame.left, memory),
                                                           .disparity = *frame.disparity,
                                                           .confidence = frame.confidence,
                                                           .pair = rig.pair});
    times_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
            .count());
    const Pose moved = result.motion_known ? motions[static_cast<size_t>(i)] : Pose();
    if (result.motion_known) result.motion.Add(fused.motion, moved);
    const cv::Mat1f& truth = captured.truth.left;
    const cv::Mat1b mask = IsKitti(source) ? away.Add(captured.tof, rig, moved)
                                           : cv::Mat1b(truth.size(), uint8_t{255});
    const cv::Mat1f single = ToPx(*frame.disparity);
    const VideoMaps maps = {single, average.Add(single), ToPx(fused.disparity)};
    std::optional<VideoScore::TrueMotion> true_motion;
    if (result.motion_known) true_motion = VideoScore::TrueMotion{moved, rig.pair};
    for (size_t k = 0; k < maps.size(); ++k) scores[k].Add(maps[k], truth, mask, true_motion);
    if (!settings.images.empty()) pictures.Add(i, frame.left, truth, mask, maps);
  }
  if (!settings.images.empty()) pictures.Write(settings.images);
  result.single = scores[0].figures();
  result.average = scores[1].figures();
  result.fused = scores[2].figures();
  result.filter_ms = OrderStatistic(std::span(times_ms), times_ms.size() / 2);
  return result;
}

std::string VideoTable(const std::vector<VideoResult>& results) {
  std::string text =
      "| source | map | bad 1, % | bad 3, % | mean error, px | change error, px | along the "
      "motion, px | trail, bad 3 | covered, bad 3 | flicker, median | flicker, p95 "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  const auto rows = [&](const std::string& name, const VideoFigures& single,
                        const VideoFigures& average, const VideoFigures& fused) {
    text += VideoRow(name, "single", single) + VideoRow("", "average", average) +
            VideoRow("", "fused", fused);
  };
  for (const VideoResult& result : results) {
    rows(result.source, result.single, result.average, result.fused);
  }
  if (results.size() > 1) {
    rows("mean", MeanFigures(results, &VideoResult::single),
         MeanFigures(results, &VideoResult::average), MeanFigures(results, &VideoResult::fused));
  }
  text +=
      "\n| source | frames | motion known | way, m | error, % of the way | largest, mm | turn "
      "error, degrees a frame | resets | filter, ms |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const VideoResult& result : results) {
    const MotionScore& motion = result.motion;
    const double degrees = motion.turn_error * 180 / CV_PI / std::max(1, motion.frames);
    text += fmt::format(
        "| {} | {} | {} | {:.3f} | {} | {:.1f} | {:.3f} | {} | {:.1f} |\n", result.source,
        result.frames, result.motion_known ? "yes" : "no", motion.way_m,
        motion.way_m > 0 ? fmt::format("{:.2f}", 100 * motion.error_m / motion.way_m) : "–",
        1000 * motion.largest_m, degrees, motion.resets, result.filter_ms);
  }
  return text;
}

VideoPictures::VideoPictures(const std::string& source, int frames)
    : source_(source), every_(std::max(1, (frames + kStripRows - 1) / kStripRows)) {}

void VideoPictures::Add(int frame, const cv::Mat& left, const cv::Mat1f& truth,
                        const cv::Mat1b& mask, const VideoMaps& maps) {
  FigureRow row{.cells = {{FigureThumbnail(ToBgr(left)), fmt::format("frame {}", frame)}},
                .scale = {.axes = {{{0, kLargestErrorPx}, "px"}}, .above = true}};
  for (size_t i = 0; i < maps.size(); ++i) {
    const cv::Mat1f error_px = ErrorMap(maps[i], truth, mask);
    const double bad = BadPercent(error_px);
    bad3_percent_[i].push_back(bad);
    if (frame % every_ != 0) continue;
    row.cells.push_back({FigureThumbnail(ColorizeErrors(error_px)),
                         std::isnan(bad) ? "" : fmt::format("bad 3: {:.2f} %", bad)});
  }
  if (frame % every_ == 0) rows_.push_back(std::move(row));
}

void VideoPictures::Write(const std::filesystem::path& folder) const {
  const std::string name = FileName(source_);
  std::vector<std::string> titles = {"left image"};
  titles.insert(titles.end(), kVideoMapNames.begin(), kVideoMapNames.end());
  RequireWritten(WritePng(folder / (name + "_strip.png"), Figure(titles, rows_)));
  OutputFile plot(folder / (name + ".svg"));
  plot.Write(PlotsSvg({{PlotOf(source_, bad3_percent_)}}));
  RequireWritten(plot.Commit());
}

}  // namespace sprout::evaluate
