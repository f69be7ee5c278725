#include "services/refine/range/range_field.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"
#include "services/refine/range/range_curve.h"

namespace sprout::refine {
namespace {

constexpr int kOffsetLabels = RangeRules::kLabels;

}  // namespace

void RangeField::SetCosts(const RangeNodes& nodes, std::span<const double> start_px) {
  const std::span<const RangeNode> all = nodes.nodes();
  data_.resize(all.size());
  counts_.assign(all.size(), 1);
  ForEachParallel(all.size(), [&](size_t i) {
    data_[i] = all[i].costs;
    if (start_px[i] == 0) return;
    for (int k = 0; k < kOffsetLabels; ++k) {
      data_[i][static_cast<size_t>(k)] =
          static_cast<float>(CostAt(all[i].costs, RangeRules::OffsetPx(k) + start_px[i]));
    }
  });
  // Twice 3×3 nodes are 5×5, the nearest of which count most.
  for (int round = 0; round < 2; ++round) Sum(nodes);
  for (size_t i = 0; i < all.size(); ++i) {
    for (float& cost : data_[i]) cost /= counts_[i];
  }
}

// Sums over the nodes around each on its surface.
void RangeField::Sum(const RangeNodes& nodes) {
  before_.swap(data_);
  counts_before_.swap(counts_);
  data_.resize(before_.size());
  counts_.resize(before_.size());
  ForEachParallel(before_.size(), [&](size_t i) {
    OffsetCosts sum{};
    float count = 0;
    for (const uint32_t other : nodes.SurfaceAround(i)) {
      for (size_t k = 0; k < kOffsetLabels; ++k) sum[k] += before_[other][k];
      count += counts_before_[other];
    }
    data_[i] = sum;
    counts_[i] = count;
  });
}

void RangeField::AddPath(const RangeNodes& nodes, bool along_rows, bool back, float moved) {
  const cv::Size size = nodes.size();
  const int lines = along_rows ? size.height : size.width;
  const int length = along_rows ? size.width : size.height;
  OffsetCosts penalty;
  for (int k = 0; k < kOffsetLabels; ++k) {
    const double off = RangeRules::OffsetPx(k);
    penalty[static_cast<size_t>(k)] =
        static_cast<float>(RangeRules::kFieldPerPx * std::abs(off)) + (off != 0 ? moved : 0);
  }
  ForEachParallel(static_cast<size_t>(lines), [&](size_t at) {
    const auto line = static_cast<int>(at);
    OffsetCosts path{};
    int last = -1;
    for (int i = 0; i < length; ++i) {
      const int along = back ? length - 1 - i : i;
      const int node = along_rows ? nodes.At(along, line) : nodes.At(line, along);
      if (node < 0) continue;
      const auto index = static_cast<size_t>(node);
      OffsetCosts next = data_[index];
      for (size_t k = 0; k < kOffsetLabels; ++k) next[k] += penalty[k];
      if (last >= 0) {
        const bool same = nodes.AreOneSurface(static_cast<size_t>(last), index);
        const float small = RangeRules::kFieldSmallStep * (same ? 1 : RangeRules::kAcrossEdge);
        const float large = RangeRules::kFieldLargeStep * (same ? 1 : RangeRules::kAcrossEdge);
        const float least = *std::min_element(path.begin(), path.end());
        // Labels beyond the outermost cost more than any.
        std::array<float, kOffsetLabels + 2> beside;
        beside.front() = beside.back() = least + large;
        std::copy(path.begin(), path.end(), beside.begin() + 1);
        for (size_t k = 0; k < kOffsetLabels; ++k) {
          const float step = std::min(beside[k], beside[k + 2]) + small;
          next[k] += std::min(std::min(path[k], least + large), step) - least;
        }
      }
      path = next;
      last = node;
      for (size_t k = 0; k < kOffsetLabels; ++k) sums_[index][k] += path[k];
    }
  });
}

void RangeField::Optimise(const RangeNodes& nodes, float moved) {
  sums_.assign(data_.size(), OffsetCosts{});
  for (const bool along_rows : {true, false}) {
    for (const bool back : {false, true}) AddPath(nodes, along_rows, back, moved);
  }
  labels_.resize(sums_.size());
  for (size_t i = 0; i < sums_.size(); ++i) {
    labels_[i] =
        static_cast<size_t>(std::min_element(sums_[i].begin(), sums_[i].end()) - sums_[i].begin());
  }
}

// Puts labels back to 0 but where several nodes side by side match clearly better elsewhere.
// Returns what such nodes say, weighted by how distinct their matches are.
RangeField::Proved RangeField::KeepProved(const RangeNodes& nodes) {
  const std::span<const RangeNode> all = nodes.nodes();
  constexpr auto kZero = static_cast<size_t>(RangeRules::kZeroLabel);
  std::vector<uint8_t> proved(all.size());
  for (size_t i = 0; i < all.size(); ++i) {
    proved[i] = data_[i][kZero] - data_[i][labels_[i]] > RangeRules::kProvedGain ? 1 : 0;
  }
  KeepPatches(nodes, RangeRules::kProvedNodes, proved);
  double weight = 1;
  Proved found;
  for (size_t i = 0; i < all.size(); ++i) {
    const double distinct = DistinctnessOf(data_[i]);
    weight += distinct;
    if (proved[i] != 0) {
      const double offset_px = RangeRules::OffsetPx(static_cast<int>(labels_[i]));
      found.share += distinct;
      found.square += distinct * offset_px * offset_px;
    } else {
      labels_[i] = kZero;
    }
  }
  return {found.share / weight, found.square / weight};
}

// Offsets between labels, from a parabola through the costs; its curvature is their information.
void RangeField::Choose() {
  offsets_.assign(labels_.size(), {});
  information_.assign(offsets_.size(), 0);
  for (size_t i = 0; i < offsets_.size(); ++i) {
    const size_t best = labels_[i];
    double off = RangeRules::OffsetPx(static_cast<int>(best));
    if (best > 0 && best + 1 < kOffsetLabels) {
      const double before = data_[i][best - 1];
      const double behind = data_[i][best + 1];
      const double curvature = before + behind - 2 * double{data_[i][best]};
      information_[i] = std::max(0.0, curvature);
      if (curvature > 1e-3) {
        off += std::clamp((before - behind) / (2 * curvature), -0.5, 0.5);
      }
    }
    offsets_[i].offset_px = off;
  }
}

// A membrane through the offsets, by Gauss and Seidel.
void RangeField::Relax(const RangeNodes& nodes) {
  const std::span<const RangeNode> all = nodes.nodes();
  std::vector<std::array<int, 8>> around(all.size());
  std::vector<double> own(all.size());
  std::vector<double> weights(all.size());
  for (size_t i = 0; i < all.size(); ++i) {
    around[i].fill(-1);
    own[i] = offsets_[i].offset_px;
    size_t next = 0;
    for (const uint32_t other : nodes.SurfaceAround(i)) {
      if (other != i && std::abs(offsets_[other].offset_px - offsets_[i].offset_px) < 3) {
        around[i][next++] = static_cast<int>(other);
      }
    }
    weights[i] =
        information_[i] + RangeRules::kPull + RangeRules::kStiffness * static_cast<double>(next);
  }
  for (int round = 0; round < RangeRules::kRelaxations; ++round) {
    for (size_t n = 0; n < all.size(); ++n) {
      const size_t i = round % 2 == 0 ? n : all.size() - 1 - n;
      double sum = information_[i] * own[i];
      for (const int other : around[i]) {
        if (other < 0) break;
        sum += RangeRules::kStiffness * offsets_[static_cast<size_t>(other)].offset_px;
      }
      offsets_[i].offset_px = sum / weights[i];
    }
  }
}

// How sure an offset is follows from what the images around its node show, and from how much
// offsets vary where they show something.
void RangeField::SetSigma(const RangeNodes& nodes) {
  const std::span<const RangeNode> all = nodes.nodes();
  double squares = 0;
  double weight = 1e-9;
  for (size_t i = 0; i < all.size(); ++i) {
    squares += information_[i] * offsets_[i].offset_px * offsets_[i].offset_px;
    weight += information_[i];
  }
  variance_px2_ = RangeRules::kUnseenFactor * std::max(squares / weight, proved_.square);
  if (variance_px2_ < RangeRules::kMinVariance) {
    variance_px2_ = 0;
    return;
  }
  for (size_t i = 0; i < all.size(); ++i) {
    double information = 0;
    for (const uint32_t other : nodes.SurfaceAround(i)) information += information_[other];
    offsets_[i].sigma_px =
        std::sqrt(1 / (1 / variance_px2_ + information / RangeRules::kCurvatureVariance));
  }
}

void RangeField::SetSlopes(const RangeNodes& nodes) {
  std::vector<double> offsets;
  offsets.reserve(offsets_.size());
  for (const NodeOffset& offset : offsets_) offsets.push_back(offset.offset_px);
  for (size_t i = 0; i < offsets.size(); ++i) offsets_[i].slope = nodes.SlopeOf(i, offsets);
}

// How alike the windows around each node are, and whether they should be.
void RangeField::Judge(const RangeNodes& nodes, std::span<const double> start_px) {
  const std::span<const RangeNode> all = nodes.nodes();
  ForEachParallel(all.size(), [&](size_t i) {
    double products = 0;
    double of_left = 0;
    double of_right = 0;
    double count = 0;
    for (const uint32_t other : nodes.SurfaceAround(i)) {
      const OffsetMoments& moments = all[other].moments;
      const double label =
          std::clamp(start_px[other] + offsets_[i].offset_px + RangeRules::kZeroLabel, 0.0,
                     kOffsetLabels - 1.001);
      const auto below = static_cast<size_t>(label);
      const double part = label - static_cast<double>(below);
      products +=
          2 * (moments.covariance[below] * (1 - part) + moments.covariance[below + 1] * part);
      of_left += moments.left_variance;
      of_right +=
          moments.right_variance[below] * (1 - part) + moments.right_variance[below + 1] * part;
      count += 1;
    }
    offsets_[i].likeness = products / (of_left + of_right + 1);
    // Where one image is blinded or covered the other one says nothing of the range.
    offsets_[i].texture = std::min(of_left, of_right) / count;
  });
}

void RangeField::FindOffsets(const RangeNodes& nodes, double least_share) {
  Optimise(nodes, RangeRules::kFieldMoved);
  proved_ = KeepProved(nodes);
  if (proved_.share <= least_share) return;
  OptimiseAgain(nodes);
  Choose();
  Relax(nodes);
  SetSigma(nodes);
  if (variance_px2_ > 0) SetSlopes(nodes);
}

// Eq. (R7): an offset is as probable as what was proved makes it.
void RangeField::OptimiseAgain(const RangeNodes& nodes) {
  const auto penalty =
      static_cast<float>(RangeRules::kOddsPenalty * std::log((1 - proved_.share) / proved_.share));
  Optimise(nodes, std::clamp(penalty, RangeRules::kMinMoved, RangeRules::kFieldMoved));
}

void RangeField::Estimate(const RangeNodes& nodes, std::span<const double> start_px,
                          double least_share) {
  offsets_.assign(nodes.nodes().size(), {});
  variance_px2_ = 0;
  if (least_share < 1) {
    SetCosts(nodes, start_px);
    FindOffsets(nodes, least_share);
  }
  Judge(nodes, start_px);
}

void RangeField::Improve(const RangeNodes& nodes) {
  const std::vector<NodeOffset> before = offsets_;
  const std::vector<double> none(before.size());
  SetCosts(nodes, none);
  OptimiseAgain(nodes);
  Choose();
  for (size_t i = 0; i < before.size(); ++i) {
    if (labels_[i] == RangeRules::kZeroLabel &&
        std::abs(before[i].offset_px) < RangeRules::kFarOffsetPx) {
      offsets_[i].offset_px = 0;
    }
  }
  Relax(nodes);
  Judge(nodes, none);
  for (size_t i = 0; i < before.size(); ++i) offsets_[i].offset_px += before[i].offset_px;
  SetSigma(nodes);
  if (variance_px2_ > 0) SetSlopes(nodes);
}

}  // namespace sprout::refine
