#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "services/refine/stereo/stereo_search.h"
#include "tests/common/testing/instruction_sets.h"

namespace sprout::refine {
namespace {

const cv::Size kPairSize(61, 13);

// Grey value, that of the border beyond it.
int Grey(const cv::Mat1b& image, int u, int v) {
  return image(std::clamp(v, 0, image.rows - 1), std::clamp(u, 0, image.cols - 1));
}

// Eq. (M5), pixel by pixel.
int DataTerm(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point p, int d) {
  int differing = 0;
  for (int y = -2; y <= 2; ++y) {
    for (int x = -2; x <= 2; ++x) {
      const auto is_darker = [&](const cv::Mat1b& image, int u) {
        return Grey(image, u + x, p.y + y) < Grey(image, u, p.y);
      };
      differing += static_cast<int>(is_darker(left, p.x) != is_darker(right, p.x - d));
    }
  }
  // In grey levels a px, rounded to half ones.
  const auto slope = [&](const cv::Mat1b& image, int u) {
    double sum = 0;
    for (const auto& [y, weight] : {std::pair{-1, 1}, std::pair{0, 2}, std::pair{1, 1}}) {
      sum += weight * (Grey(image, u + 1, p.y + y) - Grey(image, u - 1, p.y + y));
    }
    return std::clamp(std::floor(sum / 8 * 2 + 0.5) / 2, -64.0, 63.5);
  };
  return differing +
         static_cast<int>(std::min(10.0, 4 * std::abs(slope(left, p.x) - slope(right, p.x - d))));
}

// Noise of a contrast that leaves no slope within the limit, and of one that leaves many.
std::pair<cv::Mat1b, cv::Mat1b> RandomPair(int contrast) {
  std::pair<cv::Mat1b, cv::Mat1b> pair{cv::Mat1b(kPairSize), cv::Mat1b(kPairSize)};
  cv::RNG random(3);
  random.fill(pair.first, cv::RNG::UNIFORM, 0, contrast);
  random.fill(pair.second, cv::RNG::UNIFORM, 0, contrast);
  return pair;
}

TEST(MatchCosts, AreTheDataTermOfEveryLabel) {
  for (const int contrast : {6, 60, 256}) {
    const auto [left, right] = RandomPair(contrast);
    StereoSearch search;
    search.first.create(kPairSize);
    for (int v = 0; v < kPairSize.height; ++v) {
      for (int u = 0; u < kPairSize.width; ++u) {
        search.first(v, u) = static_cast<int16_t>(u % 5 == 4 ? StereoSearch::kNowhere : u % 3);
      }
    }
    search.known = cv::Mat1s(kPairSize, StereoSearch::kNowhere);
    search.known(6, 40) = 9;
    SearchRows rows;
    rows.Set(search);
    ForEachInstructionSet([&](const std::string& set) {
      MatchCosts match_costs;
      const std::vector<uint8_t>& costs = match_costs.Compute(left, right, search, rows);
      for (int v = 0; v < kPairSize.height; ++v) {
        for (int u = rows.columns(v).start; u < rows.columns(v).end; ++u) {
          if (search.first(v, u) == StereoSearch::kNowhere) continue;
          for (int label = 0; label < search.labels; ++label) {
            const int d = search.first(v, u) + label;
            int expected = d <= u ? DataTerm(left, right, {u, v}, d) : 17;
            if (u == 40 && v == 6) expected += std::min(24, 6 * std::abs(d - 9));
            ASSERT_EQ(costs[rows.IndexOf(v, u) * 16 + static_cast<size_t>(label)], expected)
                << set << ": " << u << " " << v << " " << d << " contrast " << contrast;
          }
        }
      }
    });
  }
}

}  // namespace
}  // namespace sprout::refine
