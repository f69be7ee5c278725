#include "services/tools/evaluate/rivals/harris_seeds.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "services/grow/paper/plain_costs.h"

namespace sprout::evaluate {
namespace {

constexpr int kRowTolerance = 1;  // px: the detector rounds the rows of both corners

// Corners whose window lies in the image, strongest first.
std::vector<cv::Point> HarrisCorners(const cv::Mat1b& image, const HarrisSettings& settings) {
  constexpr double kMinDistance = grow::kWindowRadius + 1;  // px: windows differ by half at least
  constexpr int kBlockSize = 3;                             // OpenCV's default
  constexpr double kHarrisK = 0.04;  // Harris and Stephens (1988), and everybody
  std::vector<cv::Point2f> positions;
  cv::goodFeaturesToTrack(image, positions, settings.max_corners, settings.min_relative_response,
                          kMinDistance, cv::noArray(), kBlockSize, /*useHarrisDetector=*/true,
                          kHarrisK);
  const cv::Rect centres(grow::kWindowRadius, grow::kWindowRadius,
                         image.cols - 2 * grow::kWindowRadius,
                         image.rows - 2 * grow::kWindowRadius);
  std::vector<cv::Point> corners;
  for (const cv::Point2f& position : positions) {
    const cv::Point corner(cvRound(position.x), cvRound(position.y));
    if (centres.contains(corner)) corners.push_back(corner);
  }
  return corners;
}

// Indices of the corners in each row.
std::vector<std::vector<size_t>> ByRow(const std::vector<cv::Point>& corners, int rows) {
  std::vector<std::vector<size_t>> by_row(static_cast<size_t>(rows));
  for (size_t i = 0; i < corners.size(); ++i) {
    by_row[static_cast<size_t>(corners[i].y)].push_back(i);
  }
  return by_row;
}

// Best partner of a corner so far.
struct Best {
  size_t partner = 0;
  int32_t cost = grow::kExcludedCost;

  void Offer(size_t candidate, int32_t candidate_cost) {
    if (candidate_cost < cost) *this = {candidate, candidate_cost};
  }
};

}  // namespace

std::vector<Seed> MatchHarrisCorners(const cv::Mat1b& left, const cv::Mat1b& right,
                                     const HarrisSettings& settings) {
  const int max_disparity =
      settings.max_disparity_px > 0 ? settings.max_disparity_px : left.cols / 4;
  const std::vector<cv::Point> left_corners = HarrisCorners(left, settings);
  const std::vector<cv::Point> right_corners = HarrisCorners(right, settings);
  const auto right_by_row = ByRow(right_corners, right.rows);
  GrowConfig mncc;
  mncc.set_similarity(GrowConfig::MNCC);
  mncc.set_threshold(settings.min_mncc);
  const grow::GrowthRule rule = grow::MakeGrowthRule(mncc);
  const grow::GrowthInput input{left, right, PriorMap()};

  std::vector<Best> best_of_left(left_corners.size());
  std::vector<Best> best_of_right(right_corners.size());
  for (size_t i = 0; i < left_corners.size(); ++i) {
    const auto [u, v] = left_corners[i];
    for (int row = std::max(v - kRowTolerance, 0);
         row <= std::min(v + kRowTolerance, right.rows - 1); ++row) {
      for (const size_t j : right_by_row[static_cast<size_t>(row)]) {
        const int disparity = u - right_corners[j].x;
        if (disparity < 0 || disparity > max_disparity) continue;
        const int32_t cost = grow::CostOf(rule, input, {u, v, disparity});
        best_of_left[i].Offer(j, cost);
        best_of_right[j].Offer(i, cost);
      }
    }
  }

  std::vector<Seed> seeds;
  for (size_t i = 0; i < left_corners.size(); ++i) {
    const Best& best = best_of_left[i];
    if (best.cost > rule.limit || best_of_right[best.partner].partner != i) continue;
    seeds.push_back({.u = static_cast<float>(left_corners[i].x),
                     .v = static_cast<float>(left_corners[i].y),
                     .u_right = static_cast<float>(right_corners[best.partner].x),
                     .origin = SeedOrigin::kStereo});
  }
  return seeds;
}

}  // namespace sprout::evaluate
