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

// Writes NAME.pfm and NAME.png.
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

// Writes the left camera that all maps belong to, and what turns disparity into depth.
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

// A result: its files, and what writes them.
struct Job {
  std::vector<std::string_view> files;
  std::function<Result<void>()> write;
};

// Runs the jobs on threads of their own: on OpenCV's they would leave none to the frame that is
// computed meanwhile.
// @returns the first failure in the order of the jobs.
Result<void> RunJobs(const std::vector<Job>& jobs) {
  std::vector<Result<void>> results(jobs.size());
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < jobs.size(); i = next++) {
      try {
        results[i] = jobs[i].write();
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

// Removes the results of an earlier run that none of the jobs replaces: beside new ones they would
// be taken for this pair's. A folder of such a name is no result.
Result<void> RemoveOthers(const std::filesystem::path& folder, const std::vector<Job>& jobs) {
  for (const std::string_view name : kResultNames) {
    const bool is_replaced = std::ranges::any_of(jobs, [&](const Job& job) {
      return std::ranges::find(job.files, name) != job.files.end();
    });
    if (is_replaced) continue;
    const std::filesystem::path path = folder / name;
    std::error_code error;
    const auto type = std::filesystem::symlink_status(path, error).type();
    using enum std::filesystem::file_type;
    if (type != regular && type != symlink) continue;
    std::filesystem::remove(path, error);
    if (error) {
      return Fail(path.string() + ": is of an earlier run and cannot be removed (" +
                  error.message() + ")");
    }
  }
  return {};
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
  const auto write = [&](std::vector<std::string_view> files, std::function<Result<void>()> job) {
    jobs.push_back({std::move(files), std::move(job)});
  };
  const auto is_wanted = [&](const char* name) {
    return only.empty() || std::ranges::find(only, name) != only.end();
  };
  write({"camera.json"}, [&] { return WriteCamera(folder / "camera.json", pair); });
  write({"calib.txt"}, [&] { return WriteCalibration(folder / "calib.txt", pair); });
  if (is_wanted("disparity")) {
    write({"disparity.pfm", "disparity.png"},
          [&] { return WriteMap(folder, "disparity", depth.disparity); });
  }
  if (is_wanted("depth")) {
    write({"depth.pfm", "depth.png"}, [&] { return WriteDepth(folder, depth.depth_m); });
  }
  if (is_wanted("confidence") && !depth.confidence.empty()) {
    write({"confidence.png"},
          [&] { return WritePng(folder / "confidence.png", depth.confidence); });
  }
  // Fused maps have no standard deviation.
  if (is_wanted("sigma") && !depth.sigma.empty() && !of_fused) {
    write({"depth_sigma.pfm"}, [&] {
      return WritePfm(folder / "depth_sigma.pfm", DepthSigmaMap(pair, depth.kept, depth.sigma));
    });
  }
  if (is_wanted("fused") && depth.motion) {
    write({"fused.pfm", "fused.png", "fused_confidence.png"}, [&] {
      return WriteMap(folder, "fused", depth.fused).and_then([&] {
        return WritePng(folder / "fused_confidence.png", depth.fused_confidence);
      });
    });
  }
  if (is_wanted("left")) write({"left.png"}, [&] { return WritePng(folder / "left.png", left); });
  if (is_wanted("cloud")) {
    write({"cloud.ply"}, [&] {
      return WriteCloudPly(folder / "cloud.ply", pair, depth.kept, left, shown.confidence);
    });
  }
  if (is_wanted("mesh")) {
    write({"mesh.ply"}, [&] {
      return WriteMeshPly(folder / "mesh.ply", pair, depth.kept, left, shown.confidence);
    });
  }
  if (is_wanted("overview")) {
    write({"overview.png"}, [&] { return WritePng(folder / "overview.png", OverviewOf(shown)); });
  }
  return RemoveOthers(folder, jobs).and_then([&] { return RunJobs(jobs); });
}

}  // namespace sprout
