#include "services/grow/sweep/segments.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace sprout::grow {
namespace {

bool AreLinked(int16_t one, int16_t other) {
  return std::abs(WholeDisparity(one) - WholeDisparity(other)) <= 1;
}

// Segments of a row of the map.
struct SegmentedRow {
  SegmentedRow(const SweepBand& band, int r, const DisparityImage& map)
      : counts(map.counts()[band.first_row + r]),
        width(map.width()),
        segments(band.segments.data()),
        first(band.first_segment[static_cast<size_t>(r)]),
        end(band.first_segment[static_cast<size_t>(r) + 1]) {}

  // Column behind a segment.
  int EndOf(int i) const { return i + 1 < end ? int{segments[i + 1].begin} : width; }

  const int16_t* counts;
  int width;
  const Segment* segments;
  int first, end;  // numbers of the row's segments
};

// Calls link(i, j) for segments of neighbouring rows that meet in a pixel where they differ by at
// most one disparity, unless skip(i, j).
template <typename Skip, typename Link>
void ForEachLink(const SegmentedRow& upper, const SegmentedRow& lower, const Skip& skip,
                 const Link& link) {
  int i = upper.first;
  int j = lower.first;
  while (i < upper.end && j < lower.end) {
    const Segment& one = upper.segments[i];
    const Segment& other = lower.segments[j];
    const int end_of_one = upper.EndOf(i);
    const int end_of_other = lower.EndOf(j);
    if (one.is_matched != 0 && other.is_matched != 0 && !skip(i, j)) {
      const int end = std::min(end_of_one, end_of_other);
      int u = std::max(one.begin, other.begin);
      while (u < end && !AreLinked(upper.counts[u], lower.counts[u])) ++u;
      if (u < end) link(i, j);
    }
    if (end_of_one <= end_of_other) ++i;
    if (end_of_other <= end_of_one) ++j;
  }
}

int RootOf(std::vector<Segment>& segments, int i) {
  const auto parent_of = [&](int child) -> int32_t& {
    return segments[static_cast<size_t>(child)].parent;
  };
  while (parent_of(i) != i) {
    parent_of(i) = parent_of(parent_of(i));  // halves the way for the next one
    i = parent_of(i);
  }
  return i;
}

// Makes the segments of a row from its cuts.
void AddSegments(const int16_t* counts, int r, SweepBand& band) {
  const auto add = [&](int u) {
    const auto number = static_cast<int32_t>(band.segments.size());
    const uint8_t is_matched = counts[u] != DisparityImage::kInvalid ? 1 : 0;
    band.segments.push_back({static_cast<int16_t>(u), is_matched, 0, number});
  };
  add(0);
  const uint64_t* const cuts = band.cuts.data() + static_cast<size_t>(r) * band.words_per_row;
  for (size_t word = 0; word < band.words_per_row; ++word) {
    for (uint64_t bits = cuts[word]; bits != 0; bits &= bits - 1) {
      add(static_cast<int>(word) * 64 + std::countr_zero(bits));
    }
  }
  band.first_segment.push_back(static_cast<int32_t>(band.segments.size()));
}

// Finds segments of a row by column. O(1).
class SegmentFinder {
 public:
  void Renew(const SweepBand& band, int r) {
    cuts_ = band.cuts.data() + static_cast<size_t>(r) * band.words_per_row;
    before_.resize(band.words_per_row);
    int32_t number = band.first_segment[static_cast<size_t>(r)];
    for (size_t word = 0; word < before_.size(); ++word) {
      before_[word] = number;
      number += std::popcount(cuts_[word]);
    }
  }
  size_t At(int u) const {
    const auto word = static_cast<size_t>(u) / 64;
    const uint64_t up_to_u = ~uint64_t{0} >> (63 - u % 64);
    return static_cast<size_t>(before_[word] + std::popcount(cuts_[word] & up_to_u));
  }

 private:
  const uint64_t* cuts_ = nullptr;
  std::vector<int32_t> before_;  // the segment at a word's first column, unless one begins there
};

// Marks the segments of the four neighbours of seeds, where they are within one disparity.
void MarkReached(const int16_t* counts, int width, int v, const SeedsByRow& seeds,
                 const SegmentFinder& finder, SweepBand& band) {
  const auto mark = [&](int u, int d) {
    if (u < 0 || u >= width || counts[u] == DisparityImage::kInvalid) return;
    if (std::abs(WholeDisparity(counts[u]) - d) <= 1) {
      band.segments[finder.At(u)].is_reached = 1;
    }
  };
  for (const Correspondence& seed : seeds.Row(v - 1)) mark(seed.u, seed.d);
  for (const Correspondence& seed : seeds.Row(v)) {
    mark(seed.u - 1, seed.d);
    mark(seed.u + 1, seed.d);
  }
  for (const Correspondence& seed : seeds.Row(v + 1)) mark(seed.u, seed.d);
}

// The right pixels of a row that are free again, and the least key of the claims on each.
class FreeRightPixels {
 public:
  explicit FreeRightPixels(int width) : least_(static_cast<size_t>(width), kTaken) {}

  bool any() const { return any_; }
  void Free(int u, int16_t counts) {
    least_[static_cast<size_t>(u - WholeDisparity(counts))] = INT16_MAX;
    any_ = true;
  }

  // (W5) with the row's claims that had lost.
  void AssignFreed(std::span<const LostClaim> lost, int16_t* counts) {
    for (const LostClaim& claim : lost) {
      int16_t& least = least_[static_cast<size_t>(claim.u - claim.d)];
      least = std::min(least, claim.key);
    }
    for (const LostClaim& claim : lost) Take(claim, counts, -1);
    for (auto claim = lost.rbegin(); claim != lost.rend(); ++claim) Take(*claim, counts, 1);
    std::fill(least_.begin(), least_.end(), kTaken);
    any_ = false;
  }

 private:
  static constexpr int16_t kTaken = -1;  // less than all keys

  void Take(const LostClaim& claim, int16_t* counts, int side) {
    int16_t& least = least_[static_cast<size_t>(claim.u - claim.d)];
    const int16_t beside = counts[claim.u + side];
    if (least != claim.key || beside == DisparityImage::kInvalid ||
        std::abs(WholeDisparity(beside) - claim.d) > 1) {
      return;
    }
    counts[claim.u] = static_cast<int16_t>(claim.d * DisparityImage::kCountsPerPixel + claim.step);
    least = kTaken;
  }

  std::vector<int16_t> least_;  // key of all claims; kTaken where the pixel is not free
  bool any_ = false;
};

}  // namespace

void SeedsByRow::Sort(std::span<const Correspondence> seeds, int height) {
  first_.assign(static_cast<size_t>(height) + 2, 0);
  for (const Correspondence& seed : seeds) ++first_[static_cast<size_t>(seed.v) + 2];
  for (size_t v = 2; v < first_.size(); ++v) first_[v] += first_[v - 1];
  seeds_.resize(seeds.size());
  for (const Correspondence& seed : seeds) {  // moves first_[v + 1] from the begin of v to its end
    seeds_[first_[static_cast<size_t>(seed.v) + 1]++] = seed;
  }
  first_.pop_back();
}

std::span<const Correspondence> SeedsByRow::Row(int v) const {
  const auto row = static_cast<size_t>(v);
  if (v < 0 || row + 1 >= first_.size()) return {};
  return std::span(seeds_).subspan(first_[row], first_[row + 1] - first_[row]);
}

void LinkRows(const DisparityImage& map, const SeedsByRow& seeds, SweepBand& band) {
  std::vector<Segment>& segments = band.segments;
  segments.clear();
  band.first_segment.assign(1, 0);
  SegmentFinder finder;
  for (int r = 0; r < band.rows; ++r) {
    const int v = band.first_row + r;
    AddSegments(map.counts()[v], r, band);
    finder.Renew(band, r);
    MarkReached(map.counts()[v], map.width(), v, seeds, finder, band);
    if (r == 0) continue;
    ForEachLink(
        {band, r - 1, map}, {band, r, map},
        [&](int i, int j) { return RootOf(segments, i) == RootOf(segments, j); },
        [&](int i, int j) {
          const auto [root, other] = std::minmax({RootOf(segments, i), RootOf(segments, j)});
          segments[static_cast<size_t>(other)].parent = root;
        });
  }
  for (Segment& segment : segments) {  // parents come first: theirs are roots by now
    segment.parent = segments[static_cast<size_t>(segment.parent)].parent;
    segments[static_cast<size_t>(segment.parent)].is_reached |= segment.is_reached;
  }
}

void LinkBands(const DisparityImage& map, std::span<SweepBand> bands) {
  struct Link {
    Segment *upper, *lower;  // roots
  };
  std::vector<Link> links;
  for (size_t k = 1; k < bands.size(); ++k) {
    SweepBand& upper = bands[k - 1];
    SweepBand& lower = bands[k];
    const auto root_of = [](SweepBand& band, int i) {
      return &band.segments[static_cast<size_t>(band.segments[static_cast<size_t>(i)].parent)];
    };
    ForEachLink(
        {upper, upper.rows - 1, map}, {lower, 0, map}, [](int, int) { return false; },
        [&](int i, int j) {
          links.push_back({root_of(upper, i), root_of(lower, j)});
        });
  }
  for (bool changed = true; changed;) {
    changed = false;
    const auto mark = [&](const Link& link) {
      if (link.upper->is_reached == link.lower->is_reached) return;
      link.upper->is_reached = link.lower->is_reached = 1;
      changed = true;
    };
    std::for_each(links.begin(), links.end(), mark);
    std::for_each(links.rbegin(), links.rend(), mark);
  }
}

void EraseUnreached(const SweepBand& band, DisparityImage& map) {
  FreeRightPixels free(map.width());
  for (int r = 0; r < band.rows; ++r) {
    int16_t* const counts = map.counts()[band.first_row + r];
    const SegmentedRow row(band, r, map);
    for (int i = row.first; i < row.end; ++i) {
      const Segment& segment = band.segments[static_cast<size_t>(i)];
      const bool is_reached = band.segments[static_cast<size_t>(segment.parent)].is_reached != 0;
      if (segment.is_matched == 0 || is_reached) continue;
      const int end = row.EndOf(i);
      for (int u = segment.begin; u < end; ++u) free.Free(u, counts[u]);
      std::fill(counts + segment.begin, counts + end, DisparityImage::kInvalid);
    }
    if (!free.any()) continue;
    const auto first = static_cast<size_t>(band.first_lost[static_cast<size_t>(r)]);
    const auto end = static_cast<size_t>(band.first_lost[static_cast<size_t>(r) + 1]);
    free.AssignFreed(std::span(band.lost).subspan(first, end - first), counts);
  }
}

}  // namespace sprout::grow
