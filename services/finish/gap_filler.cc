#include "services/finish/gap_filler.h"

#include <algorithm>
#include <vector>

#include "common/core/median.h"
#include "common/core/parallel.h"
#include "services/finish/gap_medians.h"

namespace sprout {
namespace {

constexpr int kRadius = 2;  // of the window

// kFillColumns pixels of a row.
struct Block {
  int v;
  int column;  // of blocks
  FilledPixels pixels = {};
  bool changed = false;
};

class Blocks {
 public:
  explicit Blocks(cv::Size size)
      : across_((size.width + kFillColumns - 1) / kFillColumns), height_(size.height) {}

  std::vector<Block> All() const {
    std::vector<Block> all;
    for (int i = 0; i < across_ * height_; ++i) all.push_back({i / across_, i % across_});
    return all;
  }

  // Those whose windows see one of the changed ones, each once.
  std::vector<Block> AroundChanged(const std::vector<Block>& blocks) const {
    std::vector<Block> around;
    cv::Mat1b listed(height_, across_, uint8_t{0});
    for (const Block& block : blocks) {
      if (!block.changed) continue;
      for (int v = std::max(block.v - kRadius, 0); v <= std::min(block.v + kRadius, height_ - 1);
           ++v) {
        for (int column = std::max(block.column - 1, 0);
             column <= std::min(block.column + 1, across_ - 1); ++column) {
          if (listed(v, column) == 0) around.push_back({v, column});
          listed(v, column) = 1;
        }
      }
    }
    return around;
  }

 private:
  int across_;
  int height_;
};

// One pass over the blocks; all look at the map as it was before.
void FillPass(std::vector<Block>& blocks, DisparityImage& map) {
  ForEachParallel(blocks.size(), [&](size_t i) {
    Block& block = blocks[i];
    block.changed = FillPixels(map, block.v, block.column * kFillColumns, block.pixels);
  });
  for (const Block& block : blocks) {
    const int u = block.column * kFillColumns;
    if (!block.changed) continue;
    std::copy_n(block.pixels.begin(), std::min(kFillColumns, map.width() - u),
                &map.counts()(block.v, u));
  }
}

DisparityImage FillFromPrior(const DisparityImage& map, const DisparityImage& prior) {
  cv::Mat1s without_gaps = map.counts();
  if (prior.size() == map.size()) {
    without_gaps = map.counts().clone();
    prior.counts().copyTo(without_gaps, map.counts() == DisparityImage::kInvalid);
  }
  DisparityImage filled(map.size());
  MedianFilter().Apply(without_gaps, filled.counts());
  return filled;
}

}  // namespace

DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  if (fill == GrowConfig::PRIOR) return FillFromPrior(map, prior);
  DisparityImage filled(map.counts().clone());
  const Blocks grid(map.size());
  std::vector<Block> blocks = grid.All();
  do {
    FillPass(blocks, filled);
    blocks = grid.AroundChanged(blocks);
  } while (fill == GrowConfig::UNTIL_STABLE && !blocks.empty());
  return filled;
}

}  // namespace sprout
