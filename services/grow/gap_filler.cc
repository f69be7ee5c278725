#include "services/grow/gap_filler.h"

#include <algorithm>
#include <vector>

#include "common/core/parallel.h"
#include "services/grow/gap_medians.h"

namespace sprout {
namespace {

constexpr int kRadius = 2;  // of the window

// Columns of kFillColumns pixels in a row.
int BlocksAcross(cv::Size size) { return (size.width + kFillColumns - 1) / kFillColumns; }

// Writes a block of pixels, as many as there are in the map.
void CopyTo(DisparityImage& map, int v, int u, const FilledPixels& pixels) {
  std::copy_n(pixels.begin(), std::min(kFillColumns, map.width() - u), &map.counts()(v, u));
}

}  // namespace

DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior) {
  return GapFiller().Fill(map, fill, prior);
}

DisparityImage GapFiller::Fill(const DisparityImage& map, GrowConfig::Fill fill,
                               const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  Renew(result_, map.size());
  switch (fill) {
    case GrowConfig::PRIOR:
      FillFromPrior(map, prior);
      break;
    case GrowConfig::ONE_PASS:
      FillOnce(map);
      break;
    default:
      FillOnce(map);
      FillOn();
  }
  return result_;
}

void GapFiller::FillOnce(const DisparityImage& map) {
  ForEachParallel(static_cast<size_t>(map.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    FilledPixels pixels;
    for (int u = 0; u < map.width(); u += kFillColumns) {
      FillPixels(map, v, u, pixels);
      CopyTo(result_, v, u, pixels);
    }
  });
}

// Passes over the blocks around what the last pass has filled, until one fills nothing.
void GapFiller::FillOn() {
  const int across = BlocksAcross(result_.size());
  blocks_.clear();
  for (int i = 0; i < across * result_.height(); ++i) blocks_.push_back({i / across, i % across});
  listed_.assign(blocks_.size(), 0);
  while (!blocks_.empty()) {
    filled_.resize(blocks_.size());
    ForEachParallel(blocks_.size(), [&](size_t i) {
      Filled& filled = filled_[i];
      const Block& block = blocks_[i];
      filled.changed = FillPixels(result_, block.v, block.column * kFillColumns, filled.pixels);
    });
    KeepFilled();
    ListBlocksAround();
  }
}

// Writes what a pass has filled, and leaves only these blocks in the list.
void GapFiller::KeepFilled() {
  size_t kept = 0;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!filled_[i].changed) continue;
    const Block& block = blocks_[i];
    CopyTo(result_, block.v, block.column * kFillColumns, filled_[i].pixels);
    blocks_[kept++] = block;
  }
  blocks_.resize(kept);
}

// The blocks that see one of the list, each once, become the list.
void GapFiller::ListBlocksAround() {
  const int across = BlocksAcross(result_.size());
  const auto listed = [&](const Block& block) -> uint8_t& {
    return listed_[static_cast<size_t>(block.v * across + block.column)];
  };
  next_blocks_.clear();
  for (const Block& block : blocks_) {
    for (int v = std::max(block.v - kRadius, 0);
         v <= std::min(block.v + kRadius, result_.height() - 1); ++v) {
      for (int column = std::max(block.column - 1, 0);
           column <= std::min(block.column + 1, across - 1); ++column) {
        const Block near{v, column};
        if (listed(near) == 0) next_blocks_.push_back(near);
        listed(near) = 1;
      }
    }
  }
  for (const Block& block : next_blocks_) listed(block) = 0;
  std::swap(blocks_, next_blocks_);
}

void GapFiller::FillFromPrior(const DisparityImage& map, const DisparityImage& prior) {
  Renew(without_gaps_, map.size());
  ForEachParallel(static_cast<size_t>(map.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    const int16_t* from = map.counts()[v];
    const int16_t* instead = prior.size() == map.size() ? prior.counts()[v] : from;
    int16_t* to = without_gaps_[v];
    for (int u = 0; u < map.width(); ++u) {
      to[u] = from[u] != DisparityImage::kInvalid ? from[u] : instead[u];
    }
  });
  median_.Apply(without_gaps_, result_.counts());
}

}  // namespace sprout
