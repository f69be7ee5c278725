#include "services/refine/stereo/stereo_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/image.h"
#include "common/core/parallel.h"

namespace sprout::refine {
namespace {

constexpr int kLabels = StereoRules::kLabels;

// 255 where it is not 0.
cv::Mat1b Whole(const cv::Mat1b& mask) {
  cv::Mat1b whole;
  cv::compare(mask, 0, whole, cv::CMP_NE);
  return whole;
}

// Whether any of the four is wanted. @param mask  0 or 255, so that the mean of any is not 0.
cv::Mat1b HalvedMask(const cv::Mat1b& mask) { return Whole(Halved(mask)); }

// Position in an image of one scale, of one in the original: pixel centres are whole numbers.
int AtScale(float position, int scale) {
  return static_cast<int>(std::floor((position + 0.5F) / static_cast<float>(scale)));
}

void PutKnown(std::span<const Seed> seeds, int scale, cv::Mat1s& known) {
  known.setTo(StereoSearch::kNowhere);
  for (const Seed& seed : seeds) {
    const cv::Point at(AtScale(seed.u, scale), AtScale(seed.v, scale));
    if (!cv::Rect({}, known.size()).contains(at)) continue;
    const auto disparity =
        static_cast<int16_t>(std::lround(seed.disparity() / static_cast<float>(scale)));
    known(at) = std::max(known(at), disparity);  // of several the nearest surface
  }
}

// The first disparities of a row's pixels, from what a coarser image gave for the 3×3 pixels around
// each. The build asks the compiler to make vectors of the loops, which count in 16 bits.
class RowRanges {
 public:
  explicit RowRanges(const cv::Mat1s& coarser)
      : coarser_(coarser),
        width_(coarser.cols),
        least_(static_cast<size_t>(width_ + 2), INT16_MAX),
        most_(least_.size(), StereoSearch::kNowhere),
        ranges_(2 * static_cast<size_t>(width_)) {}

  // @returns each range twice, for the pixels of the finer image.
  const int16_t* Of(int v) {
    const int16_t* const above = coarser_[std::max(0, v - 1)];
    const int16_t* const here = coarser_[v];
    const int16_t* const below = coarser_[std::min(coarser_.rows - 1, v + 1)];
    const auto known = [](int16_t d) {
      return d == StereoSearch::kNowhere ? int16_t{INT16_MAX} : d;
    };
    int16_t* const least = least_.data();
    int16_t* const most = most_.data();
    for (int u = 0; u < width_; ++u) {
      least[u + 1] = std::min(std::min(known(above[u]), known(here[u])), known(below[u]));
      most[u + 1] = std::max(std::max(above[u], here[u]), below[u]);
    }
    int16_t* const ranges = ranges_.data();
    for (int u = 0; u < width_; ++u) {
      const int16_t range = First(here[u], std::min(std::min(least[u], least[u + 1]), least[u + 2]),
                                  std::max(std::max(most[u], most[u + 1]), most[u + 2]));
      ranges[2 * u] = ranges[2 * u + 1] = here[u] == StereoSearch::kNowhere ? here[u] : range;
    }
    return ranges;
  }

 private:
  static int16_t Number(int x) { return static_cast<int16_t>(x); }

  // @param least, most  of the disparities around, in the coarser image's px.
  static int16_t First(int16_t own, int16_t least, int16_t most) {
    const int16_t from = Number(2 * least - StereoRules::kBeyondPx);
    const int16_t to = Number(2 * most + StereoRules::kBeyondPx + 1);
    const int16_t spare = Number(kLabels - 1 - (to - from));
    const int16_t centred = Number(from - (spare >> 1));
    // If there are too many disparities for one pixel, those around its own are searched.
    const int16_t around = Number(2 * own - kLabels / 2 + 1);
    const int16_t held = std::min(std::max(around, from), Number(to - kLabels + 1));
    return std::max(int16_t{0}, spare >= 0 ? centred : held);
  }

  const cv::Mat1s& coarser_;
  int width_;
  std::vector<int16_t> least_, most_;  // of three rows; one column more on either side
  std::vector<int16_t> ranges_;
};

void SearchAround(const cv::Mat1s& coarser, const cv::Mat1b& wanted, cv::Mat1s& first) {
  first.create(wanted.size());
  ForRangesParallel(coarser.rows, coarser.rows, [&](const cv::Range& rows) {
    RowRanges row_ranges(coarser);
    for (int v = rows.start; v < rows.end; ++v) {
      const int16_t* const ranges = row_ranges.Of(v);  // four pixels have the same
      for (int y = 2 * v; y <= std::min(2 * v + 1, wanted.rows - 1); ++y) {
        const uint8_t* const is_wanted = wanted[y];
        int16_t* const to = first[y];
        for (int u = 0; u < wanted.cols; ++u) {
          const int16_t range = ranges[u];  // read before it is asked for: no branch
          to[u] = is_wanted[u] != 0 ? range : StereoSearch::kNowhere;
        }
      }
    }
  });
}

// Labels of the coarsest image. One more than the largest disparity on either side, since a minimum
// on the end does not count.
int LabelsAt(int scale, int max_disparity_px) {
  return (max_disparity_px / scale + 2 + kLabels - 1) / kLabels * kLabels;
}

// Takes away what hangs together with fewer than StereoRules::kMinPatch others. The build asks
// the compiler to make vectors of the loops along rows.
void RemoveSmallPatches(cv::Mat1f disparity_px) {
  constexpr float kCountsPerPx = 16;  // for cv::filterSpeckles, which takes whole numbers
  constexpr int16_t kNone = -16;
  cv::Mat1s counts(disparity_px.size());
  const auto for_each_row = [&](const auto& act) {
    ForRangesParallel(counts.rows, counts.rows, [&](const cv::Range& rows) {
      for (int v = rows.start; v < rows.end; ++v) act(disparity_px[v], counts[v]);
    });
  };
  for_each_row([&](const float* px, int16_t* row) {
    for (int u = 0; u < counts.cols; ++u) {
      // Not a number: the first. No branch, which could not be foreseen.
      const float known = std::max(float{kNone}, px[u] * kCountsPerPx + 0.5F);
      row[u] = static_cast<int16_t>(static_cast<int>(known));
    }
  });
  cv::filterSpeckles(counts, kNone, StereoRules::kMinPatch, kCountsPerPx);
  for_each_row([&](float* px, const int16_t* row) {
    for (int u = 0; u < counts.cols; ++u) {
      px[u] = row[u] == kNone ? std::numeric_limits<float>::quiet_NaN() : px[u];
    }
  });
}

// Takes away what no pixel around says anything of: all have the same grey value, as where they are
// clipped. Paths lead a disparity there from elsewhere.
void RemoveEven(const cv::Mat1b& image, cv::Mat1f disparity_px) {
  constexpr int kSide = 2 * StereoRules::kCensusRadius + 1;
  const cv::Mat1b window(kSide, kSide, uint8_t{1});
  cv::Mat1b least, most;
  cv::erode(image, least, window);
  cv::dilate(image, most, window);
  disparity_px.setTo(std::numeric_limits<float>::quiet_NaN(), least == most);
}

}  // namespace

void SearchRows::Set(const StereoSearch& search) {
  const auto is_searched = [](int16_t first) { return first != StereoSearch::kNowhere; };
  const int width = search.first.cols;
  columns_.clear();
  begin_.assign(1, 0);
  for (int v = 0; v < search.first.rows; ++v) {
    const int16_t* row = search.first[v];
    const auto start = static_cast<int>(std::find_if(row, row + width, is_searched) - row);
    int end = width;
    while (end > start && !is_searched(row[end - 1])) --end;
    columns_.emplace_back(start, end);
    begin_.push_back(begin_.back() + static_cast<size_t>(end - start));
  }
}

const StereoMatches& SemiGlobalMatcher::Match(const cv::Mat1b& left, const cv::Mat1b& right,
                                              const StereoSearch& search) {
  rows_.Set(search);
  const std::vector<uint8_t>& costs = match_costs_.Compute(left, right, search, rows_);
  RunBoth([&] { AddUpPaths(left, search, rows_, costs, 1, sums_[0]); },
          [&] { AddUpPaths(left, search, rows_, costs, -1, sums_[1]); });
  matches_.best.create(left.size());
  matches_.best.setTo(StereoSearch::kNowhere);
  if (search.confirm) {
    matches_.confirmed_px.create(left.size());
    matches_.confirmed_px.setTo(std::numeric_limits<float>::quiet_NaN());
  }
  ForRangesParallel(left.rows, left.rows, [&](const cv::Range& range) {
    BestMatches matches;
    for (int v = range.start; v < range.end; ++v) {
      const cv::Range& columns = rows_.columns(v);
      const size_t begin = rows_.IndexOf(v, columns.start) * static_cast<size_t>(search.labels);
      matches.Choose(search, v, columns, sums_[0].data() + begin, sums_[1].data() + begin,
                     matches_.best[v], search.confirm ? matches_.confirmed_px[v] : nullptr);
    }
  });
  return matches_;
}

int MatchingScale(cv::Size size, int most_pixels) {
  int scale = 1;
  while (size.area() > most_pixels) {
    size = {(size.width + 1) / 2, (size.height + 1) / 2};  // as Halved()
    scale *= 2;
  }
  return scale;
}

void StereoMatcher::BuildLevels(const cv::Mat1b& left, const cv::Mat1b& right,
                                const cv::Mat1b& wanted, const StereoMatcherSettings& settings) {
  levels_.clear();
  Level level{left, right, Whole(wanted)};
  const auto is_coarse = [&] {
    const auto labels = static_cast<size_t>(LabelsAt(level.scale, settings.max_disparity_px));
    const size_t pixels = level.left.total();
    return pixels <= StereoRules::kCoarsestPixels && pixels * labels <= StereoRules::kCoarsestCosts;
  };
  const auto halve = [&] {
    level = {Halved(level.left), Halved(level.right), HalvedMask(level.wanted), 2 * level.scale};
  };
  const int scale = MatchingScale(left.size(), settings.most_pixels);
  while (level.scale < scale) halve();
  levels_.push_back(level);
  while (!is_coarse()) {
    halve();
    levels_.push_back(level);
  }
}

const cv::Mat1f& StereoMatcher::Match(const cv::Mat1b& left, const cv::Mat1b& right,
                                      const cv::Mat1b& wanted, std::span<const Seed> known,
                                      const StereoMatcherSettings& settings) {
  BuildLevels(left, right, wanted, settings);
  const StereoMatches* matches = nullptr;
  search_.diagonal = settings.diagonal;
  for (size_t i = levels_.size(); i-- > 0;) {
    const Level& level = levels_[i];
    if (matches == nullptr) {
      search_.labels = LabelsAt(level.scale, settings.max_disparity_px);
      search_.first.create(level.left.size());
      search_.first.setTo(StereoSearch::kNowhere);
      search_.first.setTo(0, level.wanted);
    } else {
      search_.labels = kLabels;
      SearchAround(matches->best, level.wanted, search_.first);
    }
    search_.known.create(level.left.size());
    PutKnown(known, level.scale, search_.known);
    search_.confirm = i == 0;
    matches = &matcher_.Match(level.left, level.right, search_);
  }
  scale_ = levels_.front().scale;
  disparity_px_ = matches->confirmed_px;
  const cv::Rect matched = cv::boundingRect(levels_.front().wanted);
  if (matched.empty()) return disparity_px_;
  RemoveEven(levels_.front().left(matched), disparity_px_(matched));
  RemoveSmallPatches(disparity_px_(matched));
  return disparity_px_;
}

}  // namespace sprout::refine
