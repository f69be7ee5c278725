#include "services/prior/hull.h"

#include <iterator>

namespace sprout {

void Hull::Find(const DisparityImage& map) {
  runs_.clear();
  left_.clear();
  right_.clear();
  for (int v = 0; v < map.height(); ++v) {
    const int16_t* const begin = map.counts()[v];
    const int16_t* const end = begin + map.width();
    const auto valid = [](int16_t counts) { return counts != DisparityImage::kInvalid; };
    const int16_t* const first = std::find_if(begin, end, valid);
    if (first == end) continue;
    const auto last = std::find_if(std::reverse_iterator(end), std::reverse_iterator(first), valid);
    runs_.push_back({v, static_cast<int>(first - begin), static_cast<int>(last.base() - begin)});
    left_.push_back(runs_.back().begin);
    right_.push_back(runs_.back().end - 1);
  }
  // Rounding to pixels made dents of less than one, in which Nearest() would get stuck.
  FillDents(left_, -1);
  FillDents(right_, 1);
}

size_t Hull::AtOrBelow(int v) const {
  const auto run = std::lower_bound(runs_.begin(), runs_.end(), v,
                                    [](const PixelRun& one, int row) { return one.v < row; });
  return std::min(static_cast<size_t>(run - runs_.begin()), runs_.size() - 1);
}

size_t Hull::Nearest(int u, int v, size_t run) const {
  double distance = SquaredDistance(u, v, run);
  const auto descend = [&](size_t step) {
    for (size_t next = run + step; next < runs_.size(); next += step) {
      const double there = SquaredDistance(u, v, next);
      if (there >= distance) break;
      distance = there;
      run = next;
    }
  };
  descend(1);
  descend(size_t{0} - 1);
  return run;
}

// Moves columns outwards, which is in the direction of `sign`, onto their convex chain.
void Hull::FillDents(std::vector<double>& columns, double sign) {
  const auto slope = [&](size_t from, size_t to) {
    return (columns[to] - columns[from]) / (runs_[to].v - runs_[from].v) * sign;
  };
  chain_.clear();
  for (size_t i = 0; i < columns.size(); ++i) {
    const auto is_dent = [&](size_t before, size_t at) {
      return slope(before, at) <= slope(at, i);
    };
    while (chain_.size() >= 2 && is_dent(chain_.end()[-2], chain_.back())) chain_.pop_back();
    chain_.push_back(i);
  }
  for (size_t link = 1; link < chain_.size(); ++link) {
    const size_t from = chain_[link - 1];
    const double per_row = slope(from, chain_[link]) * sign;
    for (size_t i = from + 1; i < chain_[link]; ++i) {
      columns[i] = columns[from] + per_row * (runs_[i].v - runs_[from].v);
    }
  }
}

}  // namespace sprout
