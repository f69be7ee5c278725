#include "services/pipeline/files/write_results.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <system_error>
#include <thread>
#include <utility>

#include "common/core/output_file.h"
#include "common/geometry/projection.h"
#include "common/picture/frame_pictures.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"

namespace sprout {
namespace {

// The counts of DisparityImage, so nothing is rounded. Zero means none, as in KITTI's maps, so a
// disparity of zero becomes the smallest there is; negative ones are left out.
cv::Mat1w CountsOf(const DisparityImage& disparity) {
  cv::Mat1w counts;
  cv::Mat(cv::max(disparity.counts(), 1)).convertTo(counts, CV_16U);
  counts.setTo(0, disparity.counts() < 0);
  return counts;
}

// NAME.pfm and NAME.png.
Result<void> WriteMap(const std::filesystem::path& folder, const std::string& name,
                      const DisparityImage& map) {
  return WritePfm(folder / (name + ".pfm"), map).and_then([&] {
    return WritePng(folder / (name + ".png"), CountsOf(map));
  });
}

Result<void> WriteDepth(const std::filesystem::path& folder, const cv::Mat1f& depth_m) {
  return WritePfm(folder / "depth.pfm", depth_m).and_then([&] {
    return WriteDepthPng(folder / "depth.png", depth_m);
  });
}

// The left camera that all maps belong to, and what makes depth of disparity.
Result<void> WriteCamera(const std::filesystem::path& path, const RectifiedPair& pair) {
  OutputFile file(path);
  file.Write(fmt::format(
      R"({{
  "width": {},
  "height": {},
  "focal_px": {},
  "cx": {},
  "cy": {},
  "cx_right": {},
  "baseline_m": {}
}}
)",
      pair.width, pair.height, pair.focal_px, pair.cx, pair.cy, pair.cx_right, pair.baseline_m));
  return file.Commit();
}

// Writes the calibration as Middlebury has it: lengths in px, the baseline in mm.
Result<void> WriteCalibration(const std::filesystem::path& path, const RectifiedPair& pair) {
  OutputFile file(path);
  const auto matrix = [&](double cx) {
    return fmt::format("[{} 0 {}; 0 {} {}; 0 0 1]", pair.focal_px, cx, pair.focal_px, pair.cy);
  };
  file.Write(fmt::format("cam0={}\ncam1={}\ndoffs={}\nbaseline={}\nwidth={}\nheight={}\n",
                         matrix(pair.cx), matrix(pair.cx_right), pair.cx_right - pair.cx,
                         1000 * pair.baseline_m, pair.width, pair.height));
  return file.Commit();
}

using Job = std::function<Result<void>()>;

// Each in a thread of its own that takes the next one. Not by OpenCV's threads, of which the frame
// that is computed meanwhile would get none.
// @returns the first failure in the order of the jobs.
Result<void> RunJobs(const std::vector<Job>& jobs) {
  std::vector<Result<void>> results(jobs.size());
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < jobs.size(); i = next++) {
      try {
        results[i] = jobs[i]();
      } catch (const std::exception& e) {  // no memory
        results[i] = Fail(e.what());
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 1; i < cv::getNumThreads(); ++i) threads.emplace_back(work);
    work();
  }
  const auto failed = std::ranges::find_if(results, [](const auto& one) { return !one; });
  return failed == results.end() ? Result<void>() : *failed;
}

// The frame as pictures show it.
Frame ShownFrame(Frame frame, const DepthFrame& depth, bool of_fused) {
  frame.disparity = depth.kept;
  frame.seeds = depth.seeds;
  frame.confidence = of_fused ? depth.fused_confidence : depth.confidence;
  if (!of_fused) frame.sigma = depth.sigma;
  if (!depth.prior.disparity.empty()) frame.prior = depth.prior;
  return frame;
}

}  // namespace

Result<void> WriteResults(Frame frame, const DepthFrame& depth, DepthConfig::Input input,
                          const std::vector<std::string>& only,
                          const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Fail(folder.string() + ": cannot be written (" + error.message() + ")");
  const bool of_fused = input == DepthConfig::FUSED;
  const RectifiedPair pair = frame.rig->pair;
  const cv::Mat left = frame.left;
  const Frame shown = ShownFrame(std::move(frame), depth, of_fused);
  std::vector<Job> jobs;
  const auto add = [&](const char* name, bool is_there, Job job) {
    const bool is_wanted = only.empty() || std::ranges::find(only, name) != only.end();
    if (is_wanted && is_there) jobs.push_back(std::move(job));
  };
  jobs.emplace_back([&] { return WriteCamera(folder / "camera.json", pair); });
  jobs.emplace_back([&] { return WriteCalibration(folder / "calib.txt", pair); });
  add("disparity", true, [&] { return WriteMap(folder, "disparity", depth.disparity); });
  add("depth", true, [&] { return WriteDepth(folder, depth.depth_m); });
  add("confidence", !depth.confidence.empty(),
      [&] { return WritePng(folder / "confidence.png", depth.confidence); });
  // Fused maps have none.
  add("sigma", !depth.sigma.empty() && !of_fused, [&] {
    return WritePfm(folder / "depth_sigma.pfm", DepthSigmaMap(pair, depth.kept, depth.sigma));
  });
  add("fused", depth.motion.has_value(), [&] {
    return WriteMap(folder, "fused", depth.fused).and_then([&] {
      return WritePng(folder / "fused_confidence.png", depth.fused_confidence);
    });
  });
  add("left", true, [&] { return WritePng(folder / "left.png", left); });
  add("cloud", true, [&] {
    return WriteCloudPly(folder / "cloud.ply", pair, depth.kept, left, shown.confidence);
  });
  add("mesh", true,
      [&] { return WriteMeshPly(folder / "mesh.ply", pair, depth.kept, left, shown.confidence); });
  add("overview", true, [&] { return WritePng(folder / "overview.png", OverviewOf(shown)); });
  return RunJobs(jobs);
}

}  // namespace sprout
