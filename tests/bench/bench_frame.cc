#include "tests/bench/bench_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/scenes/tof_grid.h"

namespace sprout {
namespace {

constexpr int kTofSpacingPx = 10;

cv::Mat ResizedImage(const cv::Mat& image, cv::Size size) {
  cv::Mat resized;
  const bool smaller = size.width < image.cols;
  cv::resize(image, resized, size, 0, 0, smaller ? cv::INTER_AREA : cv::INTER_CUBIC);
  return resized;
}

cv::Mat1f ResizedTruth(const cv::Mat1f& truth, cv::Size size) {
  cv::Mat1f resized;
  cv::resize(truth, resized, size, 0, 0, cv::INTER_NEAREST);
  resized *= static_cast<double>(size.width) / truth.cols;
  return resized;
}

RectifiedPair ResizedPair(RectifiedPair pair, cv::Size size) {
  const double scale_u = static_cast<double>(size.width) / pair.width;
  const double scale_v = static_cast<double>(size.height) / pair.height;
  pair.width = size.width;
  pair.height = size.height;
  pair.focal_px *= scale_u;
  pair.cx *= scale_u;
  pair.cx_right *= scale_u;
  pair.cy *= scale_v;
  return pair;
}

}  // namespace

BenchFrame LoadBenchFrame(const std::string& folder, cv::Size size) {
  const auto source = scenes::OpenDataset("middlebury:" + folder);
  BenchFrame bench{.rig = source->rig(), .frame = source->Get(0), .left = {}, .right = {}};
  bench.rig.pair = ResizedPair(bench.rig.pair, size);
  bench.rig.tof = scenes::TofGridCamera(bench.rig.pair, kTofSpacingPx);
  scenes::DatasetFrame& frame = bench.frame;
  frame.left = ResizedImage(frame.left, size);
  frame.right = ResizedImage(frame.right, size);
  frame.truth.left = ResizedTruth(frame.truth.left, size);
  frame.truth.right = {};
  frame.tof = scenes::SampleTofGrid(bench.rig.pair, kTofSpacingPx, frame.truth.left);
  bench.left = ToGrey(frame.left);
  bench.right = ToGrey(frame.right);
  for (const float disparity : frame.truth.left) {
    if (std::isfinite(disparity)) {
      bench.max_disparity_px =
          std::max(bench.max_disparity_px, static_cast<int>(std::ceil(disparity)));
    }
  }
  return bench;
}

void LoseDarkReturns(double share, BenchFrame& bench) {
  struct Return {
    uint8_t grey;
    cv::Point pixel;
  };
  std::vector<Return> returns;
  cv::Mat1f& depth_m = bench.frame.tof.depth_m;
  int behind = 0;
  for (const ProjectedPoint& point : TofProjector(bench.rig).Project(bench.frame.tof, behind)) {
    const cv::Point in_left(cvRound(point.seed.u), cvRound(point.seed.v));
    const bool inside = cv::Rect({}, bench.left.size()).contains(in_left);
    returns.push_back({inside ? bench.left(in_left) : uint8_t{0}, {point.tof_u, point.tof_v}});
  }
  std::stable_sort(returns.begin(), returns.end(),
                   [](const Return& a, const Return& b) { return a.grey < b.grey; });
  returns.resize(static_cast<size_t>(share * static_cast<double>(returns.size())));
  for (const Return& lost : returns) depth_m(lost.pixel) = std::numeric_limits<float>::quiet_NaN();
}

}  // namespace sprout
