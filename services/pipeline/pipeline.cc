#include "services/pipeline/pipeline.h"

#include <utility>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "services/pipeline/chain.h"

namespace sprout {
namespace {

Result<void> CheckImage(const char* name, const cv::Mat& image, cv::Size calibrated) {
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3) {
    return Fail(std::string(name) + ": of OpenCV's type " + cv::typeToString(image.type()) +
                "; allowed: CV_8UC1, CV_8UC3");
  }
  if (image.size() != calibrated) {
    return Fail(std::string(name) + ": " + SizeText(image.size()) +
                "; allowed: the calibrated size " + SizeText(calibrated));
  }
  return {};
}

Result<void> CheckTof(const TofImage& tof, const Rig& rig) {
  if (tof.depth_m.empty()) return {};
  if (!tof.amplitude.empty() && tof.amplitude.size() != tof.depth_m.size()) {
    return Fail("tof.amplitude: " + SizeText(tof.amplitude.size()) + "; allowed: empty, or " +
                SizeText(tof.depth_m.size()) + " as tof.depth_m");
  }
  return CheckTofSize(rig, tof);
}

Result<void> CheckInput(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                        const Rig& rig) {
  return CheckRig(rig)
      .and_then([&] { return CheckImage("left", left, rig.pair.size()); })
      .and_then([&] { return CheckImage("right", right, rig.pair.size()); })
      .and_then([&] { return CheckTof(tof, rig); });
}

}  // namespace

Pipeline::Pipeline(const SproutConfig& config) : chain_(std::make_unique<Chain>(config)) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

Result<DepthFrame> Pipeline::Compute(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                                     const Rig& rig) {
  if (const Result<void> fits = CheckInput(left, right, tof, rig); !fits) {
    return tl::unexpected(fits.error());
  }
  Frame frame;
  frame.left = left;
  frame.right = right;
  frame.tof = tof;
  frame.rig = rig;
  ChainObserver nobody;
  DepthFrame result;
  result.warnings = chain_->Run(frame, nobody).warnings;
  result.disparity = std::move(*frame.disparity);
  result.confidence = frame.confidence;
  result.sigma = frame.sigma;
  result.depth_m = DepthMap(rig.pair, result.disparity);
  result.prior = frame.prior.value_or(PriorMap());
  result.seeds = std::move(*frame.seeds);
  result.left_seeds = std::move(*frame.left_seeds);
  return result;
}

}  // namespace sprout
