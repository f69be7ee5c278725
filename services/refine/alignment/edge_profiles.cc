#include "services/refine/alignment/edge_profiles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/core/parallel.h"
#include "services/refine/alignment/alignment_rules.h"

namespace sprout::refine {
namespace {

using Rules = AlignmentRules;

// A place, mirrored in the pair: what stands in `here` is looked for in `there`.
struct View {
  const cv::Mat1b& here;
  const cv::Mat1b& there;
  double to_there;  // times the disparity: from a column of the one to one of the other
  double u, v;      // of the edge
};

// How badly a row at a column fits a grey value: 0 to 1; one half where the row ends.
inline float Misfit(const uint8_t* row, float last_column, float column, float grey) {
  if (!(column >= 0 && column < last_column)) return 0.5F;
  const int whole = static_cast<int>(column);
  const float part = column - static_cast<float>(whole);
  const auto at = static_cast<float>(row[whole]);
  const float there = at + part * (static_cast<float>(row[whole + 1]) - at);
  return std::min(std::abs(there - grey), Rules::kMaxMisfit) / Rules::kMaxMisfit;
}

// Calls look(u, v) for the pixels at a place of the normal, along the tangent.
template <typename Look>
void ForEachPixel(const View& view, const Eigen::Vector2d& normal, int place, const Look& look) {
  const double u = view.u + place * normal.x();
  const double v = view.v + place * normal.y();
  for (int w = -Rules::kTangentReach; w <= Rules::kTangentReach; ++w) {
    look(cvRound(u - w * normal.y()), cvRound(v + w * normal.x()));
  }
}

// Running sums for the edge's profile: `preference` for the near surface, eq. (A3), and grey.
struct Sums {
  std::vector<float> preference;
  std::vector<float> grey;
};

void AddUp(std::vector<float>& values) {
  float sum = 0;
  for (float& value : values) {
    sum += value / (2 * Rules::kTangentReach + 1);
    value = sum;
  }
}

}  // namespace

double EdgeProfiles::Between(size_t k, double place) const {
  if (!(std::abs(place) <= reach_)) return 0;
  const double whole = std::floor(place);
  const double part = place - whole;
  const int at = static_cast<int>(whole);
  return (1 - part) * double{Value(k, at)} + part * double{Value(k, at + 1)};
}

void EdgeProfiles::Set(const cv::Mat1b& left, const cv::Mat1b& right,
                       std::span<const TofEdge> edges, const ProfileSizes& sizes) {
  reach_ = sizes.reach;
  places_ = static_cast<size_t>(2 * reach_ + 1);
  profiles_.resize(edges.size() * places_);
  const int window = sizes.window;
  const int middle = reach_ + window;
  const int samples = 2 * middle + 1;
  const auto count = static_cast<int>(edges.size());
  ForRangesParallel(count, count, [&](const cv::Range& part) {
    Sums sums;
    for (int k = part.start; k < part.end; ++k) {
      const TofEdge& edge = edges[static_cast<size_t>(k)];
      // The image in which the far surface beside the edge is seen by the other camera, too.
      const bool is_left = edge.normal.x() >= 0;
      const View in_left{left, right, -1, edge.left.x(), edge.left.y()};
      const View in_right{right, left, 1, edge.left.x() - edge.near_px, edge.left.y()};
      const View& view = is_left ? in_left : in_right;
      const cv::Rect image({}, left.size());
      const auto last_column = static_cast<float>(image.width - 1);
      sums.preference.assign(static_cast<size_t>(samples) + 1, 0);
      sums.grey.assign(static_cast<size_t>(samples) + 1, 0);
      for (int i = 0; i < samples; ++i) {
        const int place = i - middle;
        const double on_plane = std::clamp<double>(place, -sizes.plane_px, sizes.plane_px);
        const double to_near = view.to_there * (edge.near_px + edge.near_slope * on_plane);
        const double to_far = view.to_there * (edge.far_px + edge.far_slope * on_plane);
        float preference = 0;
        ForEachPixel(view, edge.normal, place, [&](int u, int v) {
          if (!image.contains({u, v})) return;
          const float grey = view.here(v, u);
          const uint8_t* row = view.there[v];
          preference += Misfit(row, last_column, static_cast<float>(u + to_far), grey) -
                        Misfit(row, last_column, static_cast<float>(u + to_near), grey);
        });
        float grey = 0;
        ForEachPixel(in_left, edge.normal, place, [&](int u, int v) {
          grey += left(std::clamp(v, 0, left.rows - 1), std::clamp(u, 0, left.cols - 1));
        });
        sums.preference[static_cast<size_t>(i) + 1] = preference;
        sums.grey[static_cast<size_t>(i) + 1] = grey;
      }
      AddUp(sums.preference);
      AddUp(sums.grey);
      float* profile = profiles_.data() + static_cast<size_t>(k) * places_;
      for (size_t t = 0; t < places_; ++t) {
        // The pixel at the place itself speaks for neither side.
        const size_t first = t;
        const size_t place = t + static_cast<size_t>(window);
        const size_t end = place + 1 + static_cast<size_t>(window);
        const auto inside_less_outside = [&](const std::vector<float>& sum) {
          return (sum[place] - sum[first] - sum[end] + sum[place + 1]) / static_cast<float>(window);
        };
        const float contrast =
            std::min(std::abs(inside_less_outside(sums.grey)), Rules::kMaxContrast) /
            Rules::kMaxContrast;
        profile[t] = inside_less_outside(sums.preference) / 2 +
                     Rules::kContrastWeight * contrast;  // eq. (A4)
      }
    }
  });
}

}  // namespace sprout::refine
