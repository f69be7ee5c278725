#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/picture/cloud_view.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "services/snapshot/snapshot.h"

namespace sprout {
namespace {

// Every ToF point as a seed, before refinement.
std::vector<Seed> RawSeeds(const Frame& frame) {
  const TofProjector projector(RigOfFrame(*frame.rig, *frame.tof));
  int behind = 0;
  std::vector<Seed> seeds;
  for (const ProjectedPoint& point : projector.Project(*frame.tof, behind)) {
    seeds.push_back(point.seed);
  }
  return seeds;
}

// Four pictures in two rows, all as high as the first; wide ones keep their shape.
cv::Mat3b Overview(const std::array<cv::Mat3b, 4>& pictures) {
  const int height = pictures[0].rows;
  std::array<cv::Mat3b, 4> scaled;
  for (size_t i = 0; i < pictures.size(); ++i) {
    const double scale = static_cast<double>(height) / pictures[i].rows;
    cv::resize(pictures[i], scaled[i], {cvRound(pictures[i].cols * scale), height}, 0, 0,
               cv::INTER_AREA);
  }
  const int left_width = std::max(scaled[0].cols, scaled[2].cols);
  const int right_width = std::max(scaled[1].cols, scaled[3].cols);
  cv::Mat3b overview(2 * height, left_width + right_width, cv::Vec3b(255, 255, 255));
  for (size_t i = 0; i < scaled.size(); ++i) {
    const cv::Point corner(i % 2 == 0 ? 0 : left_width, i < 2 ? 0 : height);
    scaled[i].copyTo(overview(cv::Rect(corner, scaled[i].size())));
  }
  return overview;
}

// The stages are other people's programs: their maps need not fit each other.
Result<void> CheckSizes(const Frame& frame) {
  if (auto tof = CheckTofSize(RigOfFrame(*frame.rig, *frame.tof), *frame.tof); !tof) return tof;
  const cv::Size calibrated = frame.rig->pair.size();
  const std::array<std::pair<const char*, cv::Size>, 5> images = {
      {{"left image", frame.left.size()},
       {"prior", frame.prior->size()},
       {"unfilled map", frame.unfilled->size()},
       {"disparity map", frame.disparity->size()},
       {"confidence", frame.confidence.size()}}};
  for (const auto& [name, size] : images) {
    if (size == calibrated) continue;
    return Fail(std::string(name) + " of " + SizeText(size) + ": allowed is the calibrated size " +
                SizeText(calibrated));
  }
  return {};
}

std::string Counted(const std::string& what, size_t count) {
  return what + " (" + std::to_string(count) + ")";
}

}  // namespace

Result<void> WriteFrameFiles(const Frame& frame, const std::filesystem::path& folder) {
  if (auto sizes = CheckSizes(frame); !sizes) return sizes;
  const cv::Mat1b grey = ToGrey(frame.left);
  const std::vector<Seed> raw_seeds = RawSeeds(frame);
  const std::vector<Seed>& seeds = frame.seeds->seeds;
  // The maps, not the raw seeds, choose the scale: wild points should not stretch it.
  const std::array maps = {frame.prior->disparity, *frame.disparity};
  const ValueRange range_px = DisparityRange(maps, seeds);

  const RectifiedPair& pair = frame.rig->pair;
  const cv::Mat3b left = CameraPicture(frame.left, "Left image");
  const cv::Mat3b tof =
      DepthPicture(*frame.tof, frame.left.size(), DepthRange(*frame.tof), "ToF depth");
  const cv::Mat3b filled = DisparityPicture(*frame.disparity, range_px, "Disparity, gaps filled");
  const cv::Mat3b cloud =
      CameraPicture(CloudView(pair, *frame.disparity, frame.left), "Point cloud from the side");
  const std::vector<std::pair<const char*, cv::Mat3b>> pictures = {
      {"left.png", left},
      {"tof.png", tof},
      {"seeds_raw.png",
       SeedPicture(grey, raw_seeds, range_px, Counted("ToF points", raw_seeds.size()))},
      {"seeds.png", SeedPicture(grey, seeds, range_px, Counted("Refined seeds", seeds.size()))},
      {"prior.png", DisparityPicture(frame.prior->disparity, range_px, "Prior disparity")},
      {"prior_sigma.png", SigmaPicture(*frame.prior, "Standard deviation of the prior")},
      {"disparity.png", DisparityPicture(*frame.unfilled, range_px, "Disparity as grown")},
      {"disparity_filled.png", filled},
      {"confidence.png", CameraPicture(frame.confidence, "Confidence")},
      {"cloud.png", cloud},
      {"overview.png", Overview({left, tof, filled, cloud})},
  };
  for (const auto& [name, picture] : pictures) {
    if (auto written = WritePng(folder / name, picture); !written) return written;
  }
  if (auto written = WritePfm(folder / "disparity.pfm", *frame.disparity); !written) {
    return written;
  }
  if (auto written = WriteCloudPly(folder / "cloud.ply", pair, *frame.disparity, frame.left);
      !written) {
    return written;
  }
  return WriteMeshPly(folder / "mesh.ply", pair, *frame.disparity, frame.left);
}

}  // namespace sprout
