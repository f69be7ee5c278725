#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/picture/cloud_view.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "common/picture/write_ply.h"
#include "services/evaluate/score.h"
#include "services/snapshot/snapshot.h"

namespace sprout::snapshot {
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
Result<void> CheckSizes(const Frame& frame, const datasets::GroundTruth& truth) {
  if (auto tof = CheckTofSize(RigOfFrame(*frame.rig, *frame.tof), *frame.tof); !tof) return tof;
  const cv::Size calibrated = frame.rig->pair.size();
  std::vector<std::pair<const char*, cv::Size>> images = {
      {"left image", frame.left.size()},
      {"prior", frame.prior->size()},
      {"disparity map", frame.disparity->size()}};
  if (frame.unfilled) images.emplace_back("unfilled map", frame.unfilled->size());
  if (!frame.confidence.empty()) images.emplace_back("confidence", frame.confidence.size());
  if (!truth.left.empty()) images.emplace_back("truth", truth.left.size());
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

// The range of the ToF picture: depths of the disparity pictures' range, so that near and far have
// the same colours there.
ValueRange TofRange(const Frame& frame, const ValueRange& range_px) {
  const std::optional<ValueRange> in_front = InFront(frame.rig->pair, range_px);
  return in_front ? DepthRange(frame.rig->pair, *in_front) : DepthRange(*frame.tof);
}

using NamedPictures = std::vector<std::pair<const char*, cv::Mat3b>>;

NamedPictures Pictures(const Frame& frame) {
  const cv::Mat1b grey = ToGrey(frame.left);
  const std::vector<Seed> raw_seeds = RawSeeds(frame);
  const std::vector<Seed>& seeds = frame.seeds->seeds;
  // The maps, not the raw seeds, choose the scale: wild points should not stretch it.
  const std::array maps = {frame.prior->disparity, *frame.disparity};
  const ValueRange range_px = DisparityRange(maps, seeds);

  const RectifiedPair& pair = frame.rig->pair;
  const cv::Mat3b left = CameraPicture(frame.left, "Left image");
  const cv::Mat3b tof =
      DepthPicture(*frame.tof, frame.left.size(), TofRange(frame, range_px), "ToF depth");
  const cv::Mat3b filled =
      DisparityPicture(*frame.disparity, range_px, "Disparity and depth", &pair);
  const cv::Mat3b cloud =
      CameraPicture(CloudView(pair, *frame.disparity, frame.left), "Point cloud from the side");
  NamedPictures pictures = {
      {"left.png", left},
      {"tof.png", tof},
      {"seeds_raw.png",
       SeedPicture(grey, raw_seeds, range_px, Counted("ToF points", raw_seeds.size()), &pair)},
      {"seeds.png",
       SeedPicture(grey, seeds, range_px, Counted("Refined seeds", seeds.size()), &pair)},
      {"prior.png", DisparityPicture(frame.prior->disparity, range_px, "Prior disparity", &pair)},
      {"prior_sigma.png", SigmaPicture(*frame.prior, "Standard deviation of the prior")},
      {"disparity_filled.png", filled},
      {"cloud.png", cloud},
      {"overview.png", Overview({left, tof, filled, cloud})},
  };
  if (frame.unfilled) {
    pictures.emplace_back("disparity.png",
                          DisparityPicture(*frame.unfilled, range_px, "Disparity as grown", &pair));
  }
  if (!frame.confidence.empty()) {
    pictures.emplace_back("confidence.png", ConfidencePicture(frame.confidence, "Confidence"));
  }
  return pictures;
}

}  // namespace

std::vector<std::string> MissingParts(const Frame& frame) {
  std::vector<std::string> missing;
  if (!frame.unfilled) {
    missing.emplace_back(
        "no SPROUT_UNFILLED, so no disparity.png (sprout-grow: grow { publish_unfilled: true })");
  }
  if (frame.confidence.empty()) {
    missing.emplace_back(
        "no SPROUT_CONFIDENCE, so no confidence.png (sprout-grow: grow { publish_confidence: true "
        "})");
  }
  return missing;
}

Result<void> WriteFrameFiles(const Frame& frame, const datasets::GroundTruth& truth,
                             const std::filesystem::path& folder) {
  if (auto sizes = CheckSizes(frame, truth); !sizes) return sizes;
  NamedPictures pictures = Pictures(frame);
  if (!truth.left.empty()) {
    const Result<cv::Mat1b> mask = evaluate::NonOccludedMask(truth.left, truth.right);
    if (!mask) return tl::unexpected(mask.error());
    pictures.emplace_back("errors.png",
                          ErrorPicture(evaluate::ErrorMap(ToPx(*frame.disparity), truth.left, *mask),
                                       "Error of the disparity"));
  }
  for (const auto& [name, picture] : pictures) {
    if (auto written = WritePng(folder / name, picture); !written) return written;
  }
  const RectifiedPair& pair = frame.rig->pair;
  if (auto written = WritePfm(folder / "disparity.pfm", *frame.disparity); !written) {
    return written;
  }
  if (auto written = WriteCloudPly(folder / "cloud.ply", pair, *frame.disparity, frame.left);
      !written) {
    return written;
  }
  return WriteMeshPly(folder / "mesh.ply", pair, *frame.disparity, frame.left);
}

}  // namespace sprout::snapshot
