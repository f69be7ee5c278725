#include "common/inputs/feature_matches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "common/core/image.h"
#include "common/core/window_sums.h"

namespace sprout::inputs {
namespace {

struct FeatureRules {
  /// A quarter of the sides at 2 MP. Finer levels find no more corners, but cost more.
  static constexpr double kMaxPixels = 200e3;
  static constexpr int kColumns = 20;  ///< of cells
  static constexpr int kRows = 15;
  static constexpr size_t kMaxLeft = 2;         ///< corners of a cell, the strongest
  static constexpr size_t kMaxRight = 4;        ///< the partner has to be among them
  static constexpr int kContrasts[] = {40, 8};  ///< FAST's thresholds, grey levels
  static constexpr double kBand = 0.035;        ///< searched rows, share of the height
  static constexpr double kMinBandPx = 8;
  static constexpr double kMaxColumns = 0.5;  ///< searched columns, share of the width
  static constexpr double kMinCorrelation = 0.75;
  /// Lowe's ratio of squared distances, here 2 − 2 · correlation: of the best to the second.
  static constexpr double kRatio = 0.64;
  static constexpr int kSamePx = 2;  ///< corners as near as this are one, found twice
  static constexpr int kRadius = 4;  ///< of the window that the position is measured with, px
  static constexpr double kMinSharp = 0.8;  ///< its correlation
};

constexpr int kSide = 8;  // of a descriptor's window, px
constexpr int kMargin = kSide / 2 + 1;

// A window less its mean, scaled to a norm of about 512 and clamped to ±127.
struct Descriptor {
  std::array<int16_t, kSide * kSide> values;  // of 8 bits; 16 multiply faster
  double inverse_norm = 0;                    // of the values; 0: no texture
};

struct Feature {
  cv::Point at;
  Descriptor descriptor;
};

struct Partner {
  int index = -1;
  double best = -1;
  double second = -1;
};

Descriptor Describe(const cv::Mat1b& image, cv::Point at) {
  std::array<int, kSide * kSide> grey{};
  int sum = 0;
  int squares = 0;
  for (int y = 0; y < kSide; ++y) {
    const uint8_t* row = image.ptr(at.y + y - kSide / 2) + at.x - kSide / 2;
    for (int x = 0; x < kSide; ++x) {
      grey[static_cast<size_t>(y * kSide + x)] = row[x];
      sum += row[x];
      squares += row[x] * row[x];
    }
  }
  Descriptor result{};
  constexpr int kCount = kSide * kSide;
  const double variance = squares - double(sum) * sum / kCount;
  if (variance < kCount * 4) return result;
  const double scale = 512 / std::sqrt(variance);
  const double mean = double(sum) / kCount;
  int squared = 0;
  for (size_t i = 0; i < grey.size(); ++i) {
    const double value = std::clamp((grey[i] - mean) * scale, -127.0, 127.0);
    result.values[i] = static_cast<int16_t>(cvRound(value));
    squared += result.values[i] * result.values[i];
  }
  result.inverse_norm = 1 / std::sqrt(static_cast<double>(squared));
  return result;
}

double Correlation(const Descriptor& a, const Descriptor& b) {
  int32_t product = 0;
  for (size_t i = 0; i < a.values.size(); ++i) product += int{a.values[i]} * int{b.values[i]};
  return product * a.inverse_norm * b.inverse_norm;
}

using Cell = std::vector<cv::KeyPoint>;

int ColumnOf(int x, cv::Size size) { return x * FeatureRules::kColumns / size.width; }
int RowOf(int y, cv::Size size) { return y * FeatureRules::kRows / size.height; }

// First pixel of a cell in its direction.
int FirstOf(int cell, int pixels, int cells) { return (cell * pixels + cells - 1) / cells; }

// Finds the corners of the cells from `first` to before `last` of a row of cells again, with this
// threshold.
void FindCorners(const cv::Mat1b& image, int row, int first, int last, int threshold,
                 std::vector<Cell>& cells) {
  for (int column = first; column < last; ++column) cells[static_cast<size_t>(column)].clear();
  // FAST leaves out three pixels at the border, and compares each corner with its neighbours.
  constexpr int kAround = 4;
  const int left = FirstOf(first, image.cols, FeatureRules::kColumns);
  const int right = FirstOf(last, image.cols, FeatureRules::kColumns);
  const int top = FirstOf(row, image.rows, FeatureRules::kRows);
  const int bottom = FirstOf(row + 1, image.rows, FeatureRules::kRows);
  const cv::Rect part = cv::Rect(left - kAround, top - kAround, right - left + 2 * kAround,
                                 bottom - top + 2 * kAround) &
                        cv::Rect({0, 0}, image.size());
  const cv::Rect inside(kMargin, kMargin, image.cols - 2 * kMargin, image.rows - 2 * kMargin);
  std::vector<cv::KeyPoint> corners;
  cv::FAST(image(part), corners, threshold);
  for (cv::KeyPoint& corner : corners) {
    corner.pt += cv::Point2f(part.tl());
    const cv::Point at(static_cast<int>(corner.pt.x), static_cast<int>(corner.pt.y));
    const int column = ColumnOf(at.x, image.size());
    if (!inside.contains(at) || RowOf(at.y, image.size()) != row) continue;
    if (column < first || column >= last) continue;
    cells[static_cast<size_t>(column)].push_back(corner);
  }
}

// The corners of a row of cells: in each at least the `most` strongest above the least threshold.
// A corner's response is the largest threshold that finds it, so high ones find the strongest, and
// are tried first: corners are what costs.
std::vector<Cell> CornersOfRow(const cv::Mat1b& image, int row, size_t most) {
  std::vector<Cell> cells(static_cast<size_t>(FeatureRules::kColumns));
  for (const int threshold : FeatureRules::kContrasts) {
    int first = 0;
    while (first < FeatureRules::kColumns) {
      int last = first;
      while (last < FeatureRules::kColumns && cells[static_cast<size_t>(last)].size() < most) {
        ++last;
      }
      if (last > first) FindCorners(image, row, first, last, threshold, cells);
      first = last + 1;
    }
  }
  return cells;
}

// The strongest corners of each cell, by rows.
std::vector<Feature> FindFeatures(const cv::Mat1b& image, size_t most) {
  std::vector<Cell> cells;
  for (int row = 0; row < FeatureRules::kRows; ++row) {
    for (Cell& cell : CornersOfRow(image, row, most)) cells.push_back(std::move(cell));
  }
  std::vector<Feature> features;
  for (Cell& cell : cells) {
    const auto kept = static_cast<std::ptrdiff_t>(std::min(cell.size(), most));
    std::partial_sort(cell.begin(), cell.begin() + kept, cell.end(),
                      [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
                        return std::tuple(-a.response, a.pt.y, a.pt.x) <
                               std::tuple(-b.response, b.pt.y, b.pt.x);
                      });
    for (std::ptrdiff_t i = 0; i < kept; ++i) {
      const cv::Point at(cell[static_cast<size_t>(i)].pt);
      const Descriptor descriptor = Describe(image, at);
      if (descriptor.inverse_norm > 0) features.push_back({at, descriptor});
    }
  }
  std::ranges::sort(features, [](const Feature& a, const Feature& b) {
    return std::tuple(a.at.y, a.at.x) < std::tuple(b.at.y, b.at.x);
  });
  return features;
}

bool AreOne(cv::Point a, cv::Point b) {
  return std::abs(a.x - b.x) <= FeatureRules::kSamePx &&
         std::abs(a.y - b.y) <= FeatureRules::kSamePx;
}

void Offer(Partner& partner, const std::vector<Feature>& candidates, int index, double score) {
  const bool same = partner.index >= 0 && AreOne(candidates[static_cast<size_t>(partner.index)].at,
                                                 candidates[static_cast<size_t>(index)].at);
  if (score > partner.best) {
    if (!same) partner.second = partner.best;
    partner.best = score;
    partner.index = index;
  } else if (!same) {
    partner.second = std::max(partner.second, score);
  }
}

bool IsClear(const Partner& partner) {
  return partner.index >= 0 && partner.best >= FeatureRules::kMinCorrelation &&
         1 - partner.best <= FeatureRules::kRatio * (1 - partner.second);
}

// Pairs (left, right) that are each other's clear best.
std::vector<std::pair<int, int>> PairUp(const std::vector<Feature>& left,
                                        const std::vector<Feature>& right, int rows, int columns) {
  std::vector<Partner> of_left(left.size());
  std::vector<Partner> of_right(right.size());
  size_t first = 0;
  for (size_t i = 0; i < left.size(); ++i) {
    while (first < right.size() && right[first].at.y < left[i].at.y - rows) ++first;
    for (size_t j = first; j < right.size() && right[j].at.y <= left[i].at.y + rows; ++j) {
      if (std::abs(right[j].at.x - left[i].at.x) > columns) continue;
      const double score = Correlation(left[i].descriptor, right[j].descriptor);
      Offer(of_left[i], right, static_cast<int>(j), score);
      Offer(of_right[j], left, static_cast<int>(i), score);
    }
  }
  std::vector<std::pair<int, int>> pairs;
  for (size_t i = 0; i < left.size(); ++i) {
    if (!IsClear(of_left[i])) continue;
    const auto j = static_cast<size_t>(of_left[i].index);
    const int back = of_right[j].index;
    if (!IsClear(of_right[j]) || !AreOne(left[static_cast<size_t>(back)].at, left[i].at)) continue;
    pairs.emplace_back(static_cast<int>(i), static_cast<int>(j));
  }
  return pairs;
}

// The place of the top of a parabola through three values, from the middle one; nothing without
// one.
std::optional<double> TopOf(double before, double middle, double behind) {
  const double curvature = 2 * middle - before - behind;
  if (!(curvature > 0) || before > middle || behind > middle) return {};
  return (behind - before) / (2 * curvature);
}

// Similarities of one left window with those around a place in the right image, each computed once.
class Surroundings {
 public:
  Surroundings(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left, cv::Point guess)
      : left_(left), right_(right), at_left_(at_left), guess_(guess) {
    scores_.fill(kUnknown);
  }

  double At(cv::Point off) {
    double& score = scores_[static_cast<size_t>((off.y + kReach) * kWidth + off.x + kReach)];
    if (score == kUnknown)
      score = WindowCorrelation<FeatureRules::kRadius>(left_, right_, at_left_, guess_ + off);
    return score;
  }

  static constexpr int kReach = 3;

 private:
  static constexpr int kWidth = 2 * kReach + 1;
  static constexpr double kUnknown = -2;

  const cv::Mat1b& left_;
  const cv::Mat1b& right_;
  cv::Point at_left_;
  cv::Point guess_;
  std::array<double, kWidth * kWidth> scores_{};
};

// The window's best place within `reach` px of a guess, to a fraction of a pixel, by hill climbing.
std::optional<cv::Point2d> Sharpen(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                                   cv::Point guess, int reach) {
  const int margin = FeatureRules::kRadius + reach + 1;
  if (!IsInside(at_left.x, at_left.y, left.size(), FeatureRules::kRadius) ||
      !IsInside(guess.x, guess.y, right.size(), margin)) {
    return {};
  }
  Surroundings around(left, right, at_left, guess);
  cv::Point place(0, 0);
  for (;;) {
    cv::Point best = place;
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const cv::Point other = place + cv::Point(x, y);
        if (around.At(other) > around.At(best)) best = other;
      }
    }
    if (best == place) break;
    if (std::abs(best.x) > reach || std::abs(best.y) > reach) return {};
    place = best;
  }
  const double top = around.At(place);
  if (top < FeatureRules::kMinSharp) return {};
  const auto at = [&](int x, int y) { return around.At(place + cv::Point(x, y)); };
  const std::optional<double> x = TopOf(at(-1, 0), top, at(1, 0));
  const std::optional<double> y = TopOf(at(0, -1), top, at(0, 1));
  if (!x || !y) return {};
  return cv::Point2d(guess + place) + cv::Point2d(*x, *y);
}

}  // namespace

Matches MatchFeatures(const cv::Mat1b& left, const cv::Mat1b& right, int coarser) {
  cv::Mat1b coarse_left = left;
  cv::Mat1b coarse_right = right;
  cv::Mat1b fine_left = left;
  cv::Mat1b fine_right = right;
  int shrink = 1;
  int step = 1;
  const auto halve = [&] {
    fine_left = std::exchange(coarse_left, Halved(coarse_left));
    fine_right = std::exchange(coarse_right, Halved(coarse_right));
    step = std::exchange(shrink, 2 * shrink);
  };
  while (static_cast<double>(coarse_left.total()) > FeatureRules::kMaxPixels) halve();
  for (int i = 0; i < coarser; ++i) halve();
  if (coarser > 0) {
    fine_left = coarse_left;
    fine_right = coarse_right;
    step = shrink;
  }
  Matches result;
  result.step_px = step;
  result.most_rows_px = std::max(FeatureRules::kBand * left.rows, FeatureRules::kMinBandPx);
  if (coarse_left.cols <= 4 * kMargin || coarse_left.rows <= 4 * kMargin) return result;
  const std::vector<Feature> of_left = FindFeatures(coarse_left, FeatureRules::kMaxLeft);
  const std::vector<Feature> of_right = FindFeatures(coarse_right, FeatureRules::kMaxRight);
  result.left_features = static_cast<int>(of_left.size());
  result.right_features = static_cast<int>(of_right.size());
  const int rows = static_cast<int>(std::ceil(result.most_rows_px / shrink));
  const int columns = static_cast<int>(FeatureRules::kMaxColumns * coarse_left.cols);
  const int up = fine_left.cols > coarse_left.cols ? 2 : 1;
  for (const auto& [i, j] : PairUp(of_left, of_right, rows, columns)) {
    // A corner may be found a pixel beside its place, which is `up` pixels here.
    const cv::Point at_left = of_left[static_cast<size_t>(i)].at * up;
    const cv::Point guess = of_right[static_cast<size_t>(j)].at * up;
    const auto place = Sharpen(fine_left, fine_right, at_left, guess, up);
    if (!place) continue;
    // Pixel centres lie at whole numbers on every level.
    const auto full = [&](const cv::Point2d& p) {
      return (p + cv::Point2d(0.5, 0.5)) * result.step_px - cv::Point2d(0.5, 0.5);
    };
    result.matches.push_back({.left = full(at_left), .right = full(*place)});
  }
  return result;
}

}  // namespace sprout::inputs
