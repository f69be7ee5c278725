#include "services/pipeline/files/write_results.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>

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
  cv::Mat1w counts(disparity.size(), uint16_t{0});
  for (int v = 0; v < disparity.height(); ++v) {
    for (int u = 0; u < disparity.width(); ++u) {
      if (!disparity.IsValid(u, v) || disparity.counts()(v, u) < 0) continue;
      counts(v, u) = static_cast<uint16_t>(std::max<int>(disparity.counts()(v, u), 1));
    }
  }
  return counts;
}

cv::Mat1w MillimetresOf(const cv::Mat1f& depth_m) {
  cv::Mat1w mm(depth_m.size(), uint16_t{0});
  for (int v = 0; v < depth_m.rows; ++v) {
    for (int u = 0; u < depth_m.cols; ++u) {
      const double depth = double{depth_m(v, u)};
      if (depth <= kMaxPngDepthM) mm(v, u) = static_cast<uint16_t>(std::lround(depth * 1000));
    }
  }
  return mm;
}

// NAME.pfm, NAME.png and its confidence, if there is one.
Result<void> WriteMap(const std::filesystem::path& folder, const std::string& name,
                      const DisparityImage& map, const char* confidence_name,
                      const cv::Mat1b& confidence) {
  return WritePfm(folder / (name + ".pfm"), map)
      .and_then([&] { return WritePng(folder / (name + ".png"), CountsOf(map)); })
      .and_then([&]() -> Result<void> {
        if (confidence.empty()) return {};
        return WritePng(folder / confidence_name, confidence);
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

}  // namespace

Result<void> WriteResults(Frame frame, const DepthFrame& depth, DepthConfig::Input input,
                          const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Fail(folder.string() + ": cannot be written (" + error.message() + ")");
  const bool of_fused = input == DepthConfig::FUSED;
  const DisparityImage& map = depth.kept;
  frame.disparity = map;
  frame.seeds = depth.seeds;
  frame.confidence = of_fused ? depth.fused_confidence : depth.confidence;
  if (!of_fused) frame.sigma = depth.sigma;
  if (!depth.prior.disparity.empty()) frame.prior = depth.prior;
  const RectifiedPair& pair = frame.rig->pair;
  return WriteMap(folder, "disparity", depth.disparity, "confidence.png", depth.confidence)
      .and_then([&]() -> Result<void> {
        if (!depth.motion) return {};
        return WriteMap(folder, "fused", depth.fused, "fused_confidence.png",
                        depth.fused_confidence);
      })
      .and_then([&] { return WritePfm(folder / "depth.pfm", depth.depth_m); })
      .and_then([&] { return WritePng(folder / "depth.png", MillimetresOf(depth.depth_m)); })
      .and_then([&]() -> Result<void> {
        if (depth.sigma.empty() || of_fused) return {};  // fused maps have none
        return WritePfm(folder / "depth_sigma.pfm", DepthSigmaMap(pair, depth.kept, depth.sigma));
      })
      .and_then([&] { return WritePng(folder / "left.png", frame.left); })
      .and_then([&] { return WriteCamera(folder / "camera.json", pair); })
      .and_then([&] { return WriteCloudPly(folder / "cloud.ply", pair, map, frame.left); })
      .and_then([&] { return WriteMeshPly(folder / "mesh.ply", pair, map, frame.left); })
      .and_then([&] { return WritePng(folder / "overview.png", OverviewOf(frame)); });
}

}  // namespace sprout
