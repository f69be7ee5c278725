#include "services/temporal/point_tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "common/core/parallel.h"
#include "services/temporal/window_matcher.h"

namespace sprout::temporal {
namespace {

constexpr int kCellColumns = 32;
constexpr int kCellRows = 20;
constexpr int kPointsPerPart = 16;

// Smallest eigenvalue that makes a corner: differences of two grey levels over 2 px, summed over
// 3×3 pixels.
constexpr float kMinCorner = 9 * 2 * 2;

// Largest distance from its start of a point tracked there and back, parts of a pixel: 1/2 px.
constexpr int kMaxRoundTripError = kPositionParts / 2;

// Sums over 3×3 pixels of the products of grey value differences.
struct StructureTensor {
  int32_t uu = 0, uv = 0, vv = 0;

  float SmallerEigenvalue() const {
    const float half_difference = static_cast<float>(uu - vv) / 2;
    const auto mixed = static_cast<float>(uv);
    return static_cast<float>(uu + vv) / 2 -
           std::sqrt(half_difference * half_difference + mixed * mixed);
  }
};

// One row of smaller eigenvalues, by sums over three rows and then three columns.
class CornerRow {
 public:
  explicit CornerRow(const cv::Mat1b& image)
      : image_(image), columns_(static_cast<size_t>(image.cols)) {}

  // @param v  at least two rows from the border.
  void Fill(int v) {
    std::fill(columns_.begin(), columns_.end(), StructureTensor());
    for (int y = v - 1; y <= v + 1; ++y) {
      const uint8_t* const above = image_[y - 1];
      const uint8_t* const row = image_[y];
      const uint8_t* const below = image_[y + 1];
      for (int u = 1; u + 1 < image_.cols; ++u) {
        const int slope_u = row[u + 1] - row[u - 1];
        const int slope_v = below[u] - above[u];
        StructureTensor& sum = columns_[static_cast<size_t>(u)];
        sum.uu += slope_u * slope_u;
        sum.uv += slope_u * slope_v;
        sum.vv += slope_v * slope_v;
      }
    }
  }

  // @param u  at least two columns from the border.
  float At(int u) const {
    const StructureTensor* const at = &columns_[static_cast<size_t>(u)];
    return StructureTensor{at[-1].uu + at[0].uu + at[1].uu, at[-1].uv + at[0].uv + at[1].uv,
                           at[-1].vv + at[0].vv + at[1].vv}
        .SmallerEigenvalue();
  }

 private:
  const cv::Mat1b& image_;
  std::vector<StructureTensor> columns_;
};

struct Corner {
  float strength = kMinCorner;
  cv::Point place{-1, -1};  // none
};

// The strongest corner of each cell in a row of cells.
void FindInCellRow(const cv::Mat1b& image, int cell_row, Corner* corners) {
  const int top = std::max(2, image.rows * cell_row / kCellRows);
  const int bottom = std::min(image.rows - 2, image.rows * (cell_row + 1) / kCellRows);
  CornerRow row(image);
  for (int v = top; v < bottom; ++v) {
    row.Fill(v);
    for (int cell = 0; cell < kCellColumns; ++cell) {
      const int left = std::max(2, image.cols * cell / kCellColumns);
      const int right = std::min(image.cols - 2, image.cols * (cell + 1) / kCellColumns);
      Corner& corner = corners[cell];
      for (int u = left; u < right; ++u) {
        const float strength = row.At(u);
        if (strength > corner.strength) corner = {strength, {u, v}};
      }
    }
  }
}

// Positions on the next coarser and the next finer level: pixel 0 there is between 0 and 1 here.
Place Coarser(Place place) {
  return {(place.u - kPositionParts / 2) >> 1, (place.v - kPositionParts / 2) >> 1};
}
Place Finer(Place place) {
  return {2 * place.u + kPositionParts / 2, 2 * place.v + kPositionParts / 2};
}

std::optional<Place> Track(const ImagePyramid& before, const ImagePyramid& after, Place place) {
  std::vector<Place> places{place};
  while (places.size() < before.levels.size()) places.push_back(Coarser(places.back()));
  Place found = places.back();
  for (size_t level = places.size(); level-- > 0;) {
    Place closer = found;
    const bool matches = MatchWindow(ViewOf(before.levels[level]), places[level],
                                     ViewOf(after.levels[level]), closer);
    if (matches) found = closer;
    // Coarse windows leave the image early, and may lack texture.
    if (level == 0) return matches ? std::optional(found) : std::nullopt;
    found = Finer(found);
  }
  return std::nullopt;
}

}  // namespace

std::vector<cv::Point> FindCorners(const ImagePyramid& pyramid) {
  if (pyramid.levels.empty()) return {};
  // Corners are searched in the halved image, which is less noisy; the tracker needs no exact
  // corner.
  const bool halved = pyramid.levels.size() > 1;
  const cv::Mat1b& image = pyramid.levels[halved ? 1 : 0];
  std::vector<Corner> cells(size_t{kCellRows} * kCellColumns);
  ForEachParallel(kCellRows, [&](size_t row) {
    FindInCellRow(image, static_cast<int>(row), &cells[row * kCellColumns]);
  });
  std::vector<cv::Point> corners;
  for (const Corner& corner : cells) {
    if (corner.place.x >= 0) corners.push_back(halved ? 2 * corner.place : corner.place);
  }
  return corners;
}

std::vector<TrackedPoint> TrackCorners(const ImagePyramid& before, const ImagePyramid& after) {
  const std::vector<cv::Point> corners = FindCorners(before);
  std::vector<std::optional<Place>> found(corners.size());
  const auto count = static_cast<int>(corners.size());
  ForRangesParallel(count, count / kPointsPerPart + 1, [&](const cv::Range& part) {
    for (auto i = static_cast<size_t>(part.start); i < static_cast<size_t>(part.end); ++i) {
      const Place start{corners[i].x * kPositionParts, corners[i].y * kPositionParts};
      found[i] = Track(before, after, start);
      if (!found[i]) continue;
      const std::optional<Place> back = Track(after, before, *found[i]);
      if (!back || std::abs(back->u - start.u) > kMaxRoundTripError ||
          std::abs(back->v - start.v) > kMaxRoundTripError) {
        found[i].reset();
      }
    }
  });
  std::vector<TrackedPoint> points;
  // Pixel 0 of the finest level is in the middle of scale × scale pixels.
  const auto whole = [&](double u) { return (u + 0.5) * before.scale - 0.5; };
  for (size_t i = 0; i < corners.size(); ++i) {
    if (!found[i]) continue;
    points.push_back({{whole(corners[i].x), whole(corners[i].y)},
                      {whole(double(found[i]->u) / kPositionParts),
                       whole(double(found[i]->v) / kPositionParts)}});
  }
  return points;
}

}  // namespace sprout::temporal
