// The data term of the two labels of a pixel beside a depth edge, and the decision between them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include "common/core/census.h"
#include "common/core/parallel.h"
#include "services/prior/edges/edge_surfaces.h"

namespace sprout::prior {

// The build asks the compiler to make vectors of its loop: 1 ms for a pair of 2 MP instead of 9.
void CensusTransform(const cv::Mat1b& image, cv::Mat1b& codes) {
  codes.create(image.size());
  ForRangesParallel(image.rows, 4 * cv::getNumThreads(), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) CensusOfRow(image, v, codes[v]);
  });
}

DataTerm::DataTerm(const EdgeImages& images, std::span<const EdgeTriangle> edges,
                   std::span<const Plane> planes, const PriorConfig& config)
    : images_(images),
      scales_(config),
      nearby_(std::make_unique_for_overwrite<ColourSeeds[]>(edges.size())) {
  ForEachParallel(edges.size(), [&](size_t i) { nearby_[i] = Gather(edges[i].nearby(), planes); });
}

ColourSeeds DataTerm::Gather(std::span<const int> seeds, std::span<const Plane> planes) const {
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  constexpr float kNoColour = 1e6;  // of lanes without a seed: nothing is like it
  const auto padded = [&](size_t to) { return (seeds.size() + to - 1) / to * to; };
  ColourSeeds nearby;
  nearby.count = padded(4);
  for (size_t i = 0; i < padded(ColourSeeds::kAtOnce); ++i) {
    const Plane& plane = planes[static_cast<size_t>(seeds[std::min(i, seeds.size() - 1)])];
    nearby.u[i] = plane.u;
    nearby.v[i] = plane.v;
    nearby.counts[i] = kOne * plane.disparity;
    nearby.per_column[i] = kOne * plane.per_column;
    nearby.per_row[i] = kOne * plane.per_row;
    const cv::Mat3b& image = images_.left_bgr;
    const int u = cvRound(std::clamp(plane.u, 0.F, static_cast<float>(image.cols - 1)));
    const int v = cvRound(std::clamp(plane.v, 0.F, static_cast<float>(image.rows - 1)));
    const cv::Vec3b& bgr = image(v, u);
    nearby.blue[i] = i < seeds.size() ? bgr[0] : kNoColour;
    nearby.green[i] = bgr[1];
    nearby.red[i] = bgr[2];
  }
  return nearby;
}

double DataTerm::FarMinusNear(int u, int v, int triangle, int near, int far) const {
  return prior::FarMinusNear(images_, nearby_[static_cast<size_t>(triangle)], scales_,
                             {u, v, near, far});
}

namespace {

// Decides every other pixel of every other row; then, in a second pass, the others.
class Decision {
 public:
  Decision(const EdgeLabels& labels, const DataTerm& data_term, cv::Mat1s& prior)
      : labels_(labels), data_term_(data_term), prior_(prior) {}

  void DecideRow(int v, bool second_pass) {
    const bool even_row = v % 2 == 0;
    const int width = prior_.cols;
    const Row row{labels_.near[v], labels_.far[v], labels_.triangle[v], prior_[v]};
    const int16_t* const above = prior_[v - v % 2];
    const int16_t* const below = v + v % 2 < prior_.rows ? prior_[v + v % 2] : nullptr;
    for (int u = second_pass && even_row ? 1 : 0; u < width; u += even_row ? 2 : 1) {
      while (u + 8 <= width && NoneOfEight(row.near + u)) u += 8;
      if (u >= width) break;
      const int16_t near = row.near[u];
      if (near == DisparityImage::kInvalid) continue;
      const int16_t far = row.far[u];
      const int right = u + u % 2;
      if (second_pass && right < width && below != nullptr) {
        // The decided pixels around: two in an even row or column, otherwise four.
        const auto is_near = [&](int16_t counts) { return 2 * counts > near + far ? 1 : 0; };
        const int left = u - u % 2;
        const int votes = is_near(above[left]) + is_near(above[right]) + is_near(below[left]) +
                          is_near(below[right]);
        if (votes % 4 == 0) {
          row.prior[u] = votes == 4 ? near : far;
          continue;
        }
      }
      row.prior[u] = data_term_.FarMinusNear(u, v, row.triangle[u], near, far) > 0 ? near : far;
    }
  }

 private:
  struct Row {
    const int16_t *near, *far;
    const int* triangle;
    int16_t* prior;
  };

  // Whether eight columns have no labels, as most have none.
  static bool NoneOfEight(const int16_t* labels) {
    constexpr uint64_t kFourInvalid = 0x8000'8000'8000'8000;
    static_assert(DisparityImage::kInvalid == INT16_MIN);
    std::array<uint64_t, 2> columns;
    std::memcpy(columns.data(), labels, sizeof(columns));
    return columns[0] == kFourInvalid && columns[1] == kFourInvalid;
  }

  const EdgeLabels& labels_;
  const DataTerm& data_term_;
  cv::Mat1s& prior_;
};

}  // namespace

void DecideLabels(const EdgeLabels& labels, const DataTerm& data_term, DisparityImage& prior) {
  Decision decision(labels, data_term, prior.counts());
  const auto decide = [&](int rows, int step, bool second_pass) {
    // Reads only what the first pass has decided: the order of the rows does not matter.
    ForRangesParallel(rows, rows, [&](const cv::Range& part) {
      for (int i = part.start; i < part.end; ++i) decision.DecideRow(i * step, second_pass);
    });
  };
  decide((prior.height() + 1) / 2, 2, false);
  decide(prior.height(), 1, true);
}

}  // namespace sprout::prior
