#include <array>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "services/snapshot/snapshot.h"

namespace sprout {
namespace {

// Every ToF point as a seed, before refinement.
std::vector<Seed> RawSeeds(const Frame& frame) {
  int behind = 0;
  std::vector<Seed> seeds;
  for (const ProjectedPoint& point : TofProjector(*frame.rig).Project(*frame.tof, behind)) {
    seeds.push_back(point.seed);
  }
  return seeds;
}

std::string Counted(const std::string& what, size_t count) {
  return what + " (" + std::to_string(count) + ")";
}

}  // namespace

Result<void> WriteFrameFiles(const Frame& frame, const std::filesystem::path& folder) {
  const cv::Mat1b grey = ToGrey(frame.left);
  const std::vector<Seed> raw_seeds = RawSeeds(frame);
  const std::vector<Seed>& seeds = frame.seeds->seeds;
  // The maps, not the raw seeds, choose the scale: wild points should not stretch it.
  const std::array maps = {*frame.prior, *frame.disparity};
  const ValueRange range_px = DisparityRange(maps, seeds);

  const std::vector<std::pair<const char*, cv::Mat3b>> pictures = {
      {"left.png", CameraPicture(frame.left, "Left image")},
      {"tof.png", DepthPicture(*frame.tof, frame.left.size(), DepthRange(*frame.tof), "ToF depth")},
      {"seeds_raw.png",
       SeedPicture(grey, raw_seeds, range_px, Counted("ToF points", raw_seeds.size()))},
      {"seeds.png", SeedPicture(grey, seeds, range_px, Counted("Refined seeds", seeds.size()))},
      {"prior.png", DisparityPicture(*frame.prior, range_px, "Prior disparity")},
      {"disparity.png", DisparityPicture(*frame.unfilled, range_px, "Disparity as grown")},
      {"disparity_filled.png",
       DisparityPicture(*frame.disparity, range_px, "Disparity, gaps filled")},
  };
  for (const auto& [name, picture] : pictures) {
    if (auto written = WritePng(folder / name, picture); !written) return written;
  }
  if (auto written = WritePfm(folder / "disparity.pfm", *frame.disparity); !written) {
    return written;
  }
  const RectifiedPair& pair = frame.rig->pair;
  if (auto written = WriteCloudPly(folder / "cloud.ply", pair, *frame.disparity, frame.left);
      !written) {
    return written;
  }
  return WriteMeshPly(folder / "mesh.ply", pair, *frame.disparity, frame.left);
}

}  // namespace sprout
