#include "services/grow/confidence.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"
#include "services/grow/growth_rule.h"

namespace sprout::grow {
namespace {

EdgePenalties EdgePenaltiesByDistance() {
  constexpr double kRangePx = 8;  // a prior's edges are a few pixels off
  constexpr double kStepsPerPx = 4;
  EdgePenalties penalties;
  for (size_t i = 0; i < penalties.size(); ++i) {
    const double exponent = static_cast<double>(i) / (kStepsPerPx * kRangePx);
    penalties[i] = static_cast<int>(std::lround(kEdgeWeight * std::exp(-exponent)));
  }
  return penalties;
}

}  // namespace

cv::Mat1b ConfidenceEstimator::Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                       std::span<const Seed> seeds, const DisparityImage& grown,
                                       const DisparityImage& filled) {
  static const EdgePenalties edge_penalties = EdgePenaltiesByDistance();
  const cv::Size size = filled.size();
  RunBoth([&] { PenaliseEdges(filled, edge_penalties, edge_memory_, edge_penalties_); },
          [&] {
            const float spacing_px = MarkSeeds(seeds, size);
            PenaliseHoles(no_seed_, spacing_px, hole_memory_, hole_penalties_);
          });
  Renew(confidence_, size);
  const ConfidenceInput input{left,        right, grown, filled, edge_penalties_, hole_penalties_,
                              photo_scale_};
  const int rows = RowsPerBand(size.height);
  ForEachParallel(static_cast<size_t>(CountBands(size.height)), [&](size_t band) {
    const int first = static_cast<int>(band) * rows;
    RateRows(input, {first, std::min(first + rows, size.height)}, confidence_);
  });
  return confidence_;
}

float ConfidenceEstimator::MarkSeeds(std::span<const Seed> seeds, cv::Size size) {
  no_seed_.create(size);
  no_seed_ = uint8_t{1};
  int count = 0;
  for (const Seed& seed : seeds) {
    const cv::Point position(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, size).contains(position)) continue;
    count += no_seed_(position);
    no_seed_(position) = 0;
  }
  return std::sqrt(static_cast<float>(size.area()) / static_cast<float>(std::max(count, 1)));
}

void DropUnsure(const cv::Mat1b& confidence, int least, DisparityImage& disparity) {
  if (least == 0) return;
  disparity = DisparityImage(cv::Mat1s(disparity.counts().clone()));  // others may hold the pixels
  disparity.counts().setTo(DisparityImage::kInvalid, confidence < least);
}

}  // namespace sprout::grow
