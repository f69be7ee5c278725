#include "services/tools/calibrate/scene/pair_matches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "common/core/parallel.h"

namespace sprout::calibrate {
namespace {

struct MatchRules {
  static constexpr int kColumns = 8;  ///< of cells
  static constexpr int kRows = 6;
  /// The partner of a left feature has to be among those of the right image, which are so many
  /// times as many.
  static constexpr double kMoreInRight = 2.5;
  /// Least contrast of a feature, Lowe's 0.04 halved: walls count too.
  static constexpr double kContrast = 0.02;
  /// Rows that the images are off, as share of their height: half a degree of pitch or roll through
  /// a lens of 30° from top to bottom is 1/60, and both may come together.
  static constexpr double kBand = 0.05;
  static constexpr float kRatio = 0.8F;  ///< Lowe's: distance of the best to that of the second
  /// Distances up to this many rows or columns belong to one feature found twice.
  static constexpr float kSamePx = 3;
  static constexpr int kWindow = 15;       ///< side of Lucas and Kanade's window, px
  static constexpr double kMaxBack = 0.2;  ///< px between the start and where the way back ends
  static constexpr double kMaxMove = 3;    ///< px from the feature's own position
};

struct Features {
  std::vector<cv::KeyPoint> points;
  cv::Mat1f descriptors;
};

// The strongest features of each cell, cell by cell.
std::vector<cv::KeyPoint> Spread(const std::vector<cv::KeyPoint>& points, cv::Size size,
                                 size_t most) {
  std::vector<std::vector<cv::KeyPoint>> cells(
      static_cast<size_t>(MatchRules::kColumns * MatchRules::kRows));
  for (const cv::KeyPoint& point : points) {
    const int column = std::clamp(static_cast<int>(point.pt.x) * MatchRules::kColumns / size.width,
                                  0, MatchRules::kColumns - 1);
    const int row = std::clamp(static_cast<int>(point.pt.y) * MatchRules::kRows / size.height, 0,
                               MatchRules::kRows - 1);
    cells[static_cast<size_t>(row * MatchRules::kColumns + column)].push_back(point);
  }
  std::vector<cv::KeyPoint> spread;
  for (std::vector<cv::KeyPoint>& cell : cells) {
    std::ranges::stable_sort(cell, [](const auto& a, const auto& b) {
      return std::tuple(b.response, a.pt.x, a.pt.y, a.angle) <
             std::tuple(a.response, b.pt.x, b.pt.y, b.angle);
    });
    cell.resize(std::min(cell.size(), most));
    spread.insert(spread.end(), cell.begin(), cell.end());
  }
  return spread;
}

Features Find(const cv::Mat1b& whole, size_t max_in_cell, int shrink) {
  cv::Mat1b image = whole;
  if (shrink > 1) cv::resize(whole, image, whole.size() / shrink, 0, 0, cv::INTER_AREA);
  const auto sift = cv::SIFT::create(/*nfeatures=*/0, /*nOctaveLayers=*/3, MatchRules::kContrast);
  std::vector<cv::KeyPoint> points;
  sift->detect(image, points);
  Features features{.points = Spread(points, image.size(), max_in_cell), .descriptors = {}};
  if (!features.points.empty()) sift->compute(image, features.points, features.descriptors);
  if (shrink == 1) return features;
  const float across = static_cast<float>(whole.cols) / static_cast<float>(image.cols);
  const float down = static_cast<float>(whole.rows) / static_cast<float>(image.rows);
  for (cv::KeyPoint& point : features.points) {
    point.pt = {(point.pt.x + 0.5F) * across - 0.5F, (point.pt.y + 0.5F) * down - 0.5F};
  }
  return features;
}

// Index of the unique best partner of each feature of `a` among those of `b`, or −1.
std::vector<int> BestPartners(const Features& a, const Features& b, float band_px) {
  std::vector<int> partners(a.points.size(), -1);
  ForEachParallel(a.points.size(), [&](size_t i) {
    float best = std::numeric_limits<float>::infinity();
    float second = best;
    int partner = -1;
    for (size_t j = 0; j < b.points.size(); ++j) {
      if (std::abs(b.points[j].pt.y - a.points[i].pt.y) > band_px) continue;
      const auto distance =
          static_cast<float>(cv::norm(a.descriptors.row(static_cast<int>(i)),
                                      b.descriptors.row(static_cast<int>(j)), cv::NORM_L2SQR));
      const bool same =
          partner >= 0 && cv::norm(b.points[j].pt - b.points[static_cast<size_t>(partner)].pt) <
                              MatchRules::kSamePx;
      if (distance < best) {
        if (!same) second = best;
        best = distance;
        partner = static_cast<int>(j);
      } else if (!same) {
        second = std::min(second, distance);
      }
    }
    if (best < MatchRules::kRatio * MatchRules::kRatio * second) partners[i] = partner;
  });
  return partners;
}

std::vector<cv::Point2f> Track(const cv::Mat1b& from, const cv::Mat1b& to,
                               const std::vector<cv::Point2f>& start,
                               std::vector<cv::Point2f> guess, std::vector<uchar>& found) {
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.002);
  cv::calcOpticalFlowPyrLK(from, to, start, guess, found, cv::noArray(),
                           {MatchRules::kWindow, MatchRules::kWindow}, /*maxLevel=*/0, until,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  return guess;
}

// Sub-pixel positions in the right image, without those that are not found back in the left one.
std::vector<PairMatch> Sharpen(const cv::Mat1b& left, const cv::Mat1b& right,
                               const std::vector<cv::Point2f>& at_left,
                               const std::vector<cv::Point2f>& at_right) {
  if (at_left.empty()) return {};
  std::vector<uchar> found;
  std::vector<uchar> found_back;
  const std::vector<cv::Point2f> there = Track(left, right, at_left, at_right, found);
  const std::vector<cv::Point2f> back = Track(right, left, there, at_left, found_back);
  std::vector<PairMatch> matches;
  for (size_t i = 0; i < there.size(); ++i) {
    if (found[i] == 0 || found_back[i] == 0) continue;
    if (cv::norm(back[i] - at_left[i]) > MatchRules::kMaxBack) continue;
    if (cv::norm(there[i] - at_right[i]) > MatchRules::kMaxMove) continue;
    matches.push_back({.left = at_left[i], .right = there[i]});
  }
  return matches;
}

}  // namespace

PairMatches MatchPair(const cv::Mat1b& left, const cv::Mat1b& right, const MatchEffort& effort) {
  const auto in_right =
      static_cast<size_t>(MatchRules::kMoreInRight * static_cast<double>(effort.max_in_cell));
  const Features of_left = Find(left, effort.max_in_cell, effort.shrink);
  const Features of_right = Find(right, in_right, effort.shrink);
  const auto band_px = static_cast<float>(MatchRules::kBand * left.rows);
  const std::vector<int> partners = BestPartners(of_left, of_right, band_px);
  const std::vector<int> back = BestPartners(of_right, of_left, band_px);
  std::vector<cv::Point2f> at_left;
  std::vector<cv::Point2f> at_right;
  for (size_t i = 0; i < partners.size(); ++i) {
    if (partners[i] < 0) continue;
    const auto partner = static_cast<size_t>(partners[i]);
    const int returned = back[partner];
    if (returned < 0) continue;
    // One place may have several features, of different orientation.
    if (cv::norm(of_left.points[static_cast<size_t>(returned)].pt - of_left.points[i].pt) >
        MatchRules::kSamePx) {
      continue;
    }
    at_left.push_back(of_left.points[i].pt);
    at_right.push_back(of_right.points[partner].pt);
  }
  return {.matches = Sharpen(left, right, at_left, at_right),
          .left_features = static_cast<int>(of_left.points.size()),
          .right_features = static_cast<int>(of_right.points.size())};
}

}  // namespace sprout::calibrate
