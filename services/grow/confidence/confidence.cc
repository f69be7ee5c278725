#include "services/grow/confidence/confidence.h"

#include <algorithm>
#include <numeric>

#include "common/core/parallel.h"
#include "services/grow/paper/growth_rule.h"

namespace sprout::grow {

ConfidenceEstimator::Judgement ConfidenceEstimator::Compute(const JudgedFrame& frame) {
  const cv::Size size = frame.filled.size();
  const int rows = CellsOf(size).height;
  Prepare(size);
  const auto for_rows = [&](const auto& work) {
    ForRangesParallel(rows, CountBands(size.height), work);
  };
  for_rows([&](const cv::Range& part) { FindSteps(frame.filled, part, features_); });
  RunBoth([&] { SpreadNearness(features_.edge, edge_memory_); },
          [&] {
            SpreadSeeds(frame.seeds);
            AverageBends();
          });
  for_rows([&](const cv::Range& part) {
    MatchCells(frame.left, frame.right, frame.grown, frame.filled, part, features_);
    RateCells(tables_, features_, frame.filled, frame.sigma_prior, part, judgement_.confidence,
              judgement_.sigma);
  });
  return judgement_;
}

void ConfidenceEstimator::Prepare(cv::Size size) {
  const cv::Size cells = CellsOf(size);
  const cv::Size blocks = BlocksOf(size);
  for (cv::Mat1b* map : {&features_.step, &features_.bend, &features_.margin, &features_.gaps,
                         &features_.blank, &features_.edge}) {
    map->create(cells);
  }
  features_.tof_seed.create(blocks);
  features_.seed.create(blocks);
  features_.rough.create(blocks);
  Renew(judgement_.confidence, size);
  Renew(judgement_.sigma, size);
}

void ConfidenceEstimator::SpreadSeeds(std::span<const Seed> seeds) {
  features_.tof_seed = uint8_t{0};
  features_.seed = uint8_t{0};
  const cv::Rect blocks({}, features_.seed.size());
  for (const Seed& seed : seeds) {
    const cv::Point block(cvFloor(seed.u + 0.5F) / kBlockPx, cvFloor(seed.v + 0.5F) / kBlockPx);
    if (seed.u < -0.5F || seed.v < -0.5F || !blocks.contains(block)) continue;
    features_.seed(block) = 255;
    if (seed.origin == SeedOrigin::kTof) features_.tof_seed(block) = 255;
  }
  SpreadNearness(features_.tof_seed, seed_memory_);
  SpreadNearness(features_.seed, seed_memory_);
}

// Where the prior is unsure each pixel is matched by itself: how far neighbours disagree shows how
// much is guessed.
void ConfidenceEstimator::AverageBends() {
  constexpr int kRadius = 6;
  constexpr int kSide = 2 * kRadius + 1;
  cv::Mat1b& rough = features_.rough;
  constexpr int kStep = kBlockPx / kCellPx;
  const auto bends = [&](int y) {
    return features_.bend[kStep * std::clamp(y, 0, rough.rows - 1)];
  };
  column_sums_.assign(static_cast<size_t>(rough.cols + 2 * kRadius), 0);
  int32_t* const sums = column_sums_.data() + kRadius;
  for (int y = -kRadius - 1; y < kRadius; ++y) {
    for (int x = 0; x < rough.cols; ++x) sums[x] += bends(y)[kStep * x];
  }
  for (int y = 0; y < rough.rows; ++y) {
    const uint8_t* const next = bends(y + kRadius);
    const uint8_t* const last = bends(y - kRadius - 1);
    for (int x = 0; x < rough.cols; ++x) sums[x] += next[kStep * x] - last[kStep * x];
    std::fill_n(sums - kRadius, kRadius, sums[0]);
    std::fill_n(sums + rough.cols, kRadius, sums[rough.cols - 1]);
    int32_t sum = std::accumulate(sums - kRadius, sums + kRadius, 0);
    for (int x = 0; x < rough.cols; ++x) {
      sum += sums[x + kRadius];
      rough(y, x) = static_cast<uint8_t>((sum + kSide * kSide / 2) / (kSide * kSide));
      sum -= sums[x - kRadius];
    }
  }
}

void DropUnsure(const cv::Mat1b& confidence, int least, DisparityImage& disparity) {
  if (least == 0) return;
  disparity = DisparityImage(cv::Mat1s(disparity.counts().clone()));  // others may hold the pixels
  disparity.counts().setTo(DisparityImage::kInvalid, confidence < least);
}

}  // namespace sprout::grow
