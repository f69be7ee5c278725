#include "services/grow/confidence/row_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "common/core/joined.h"
#include "common/core/parallel.h"
#include "common/core/prior_map.h"
#include "common/core/quantile.h"
#include "common/core/window_sums.h"
#include "common/inputs/judges.h"

namespace sprout::grow {
namespace {

struct RowRules {
  static constexpr int kColumns = 20;  ///< of parts, with one corner each
  static constexpr int kRows = 15;
  static constexpr int kAcross = 4;  ///< places of a part that are looked at for it
  static constexpr int kDown = 3;
  static constexpr int kRadius = 4;      ///< of the windows that are compared, px
  static constexpr int kUpDown = 8;      ///< rows that are searched, px to either side
  static constexpr int kSideways = 1;    ///< columns: a disparity that is right to 1 px is right
  static constexpr double kMinGrey = 2;  ///< of a corner: its gradient in all directions
  static constexpr size_t kMinCorners = 60;  ///< with fewer nothing is said
  static constexpr double kSigmas = 2;       ///< see RowCheck::right_share
  /// Corners stand beside edges, where growth errs more often than it claims, most between coarse
  /// ranges: of right pairs no less than this share of what it claims is found.
  static constexpr double kMinClaimedShare = 0.8;
  /// The same among range points: of right ones images show 0.8 of what is claimed and more, 0.5
  /// to 0.7 in images with JPEG of quality 5 or noise, of another scene's 0 to 0.3.
  static constexpr double kMinRangeShare = 0.5;
  /// Of a corner among range points: its gradient's square, by that of noise.
  static constexpr double kClearSignal = 4;
  /// Range points are asked only if fewer than half of every fourth corner are so alike.
  static constexpr int kGlanceStep = 4;
  static constexpr double kAlike = 0.8;
};

constexpr int kParts = RowRules::kColumns * RowRules::kRows;

// The pixels of a part, row by row.
cv::Rect PartAt(int index, cv::Size size) {
  const int column = index % RowRules::kColumns;
  const int row = index / RowRules::kColumns;
  const cv::Point from(size.width * column / RowRules::kColumns,
                       size.height * row / RowRules::kRows);
  const cv::Point to(size.width * (column + 1) / RowRules::kColumns,
                     size.height * (row + 1) / RowRules::kRows);
  return {from, to};
}

// 1 for the parts that, with those beside them, have no more range points than stereo seeds: only
// there the map depends on the pair; or for the others.
cv::Mat1b PartsOf(SeedOrigin origin, std::span<const Seed> seeds, cv::Size size) {
  cv::Mat1i more(RowRules::kRows, RowRules::kColumns, 0);  // range points
  for (const Seed& seed : seeds) {
    if (!IsInside(seed.u, seed.v, size, -0.5)) continue;
    more(cvFloor((seed.v + 0.5) * RowRules::kRows / size.height),
         cvFloor((seed.u + 0.5) * RowRules::kColumns / size.width)) +=
        seed.origin == SeedOrigin::kTof ? 1 : -1;
  }
  cv::Mat1b parts(more.size());
  for (int y = 0; y < more.rows; ++y) {
    for (int x = 0; x < more.cols; ++x) {
      const cv::Rect around = cv::Rect(x - 1, y - 1, 3, 3) & cv::Rect({}, more.size());
      int sum = 0;
      for (const int count : more(around)) sum += count;
      parts(y, x) = (sum <= 0) == (origin == SeedOrigin::kStereo) ? 1 : 0;
    }
  }
  return parts;
}

// The least mean square of the gradient over a window in any direction, grey levels² a px.
double Cornerness(const cv::Mat1b& image, cv::Point at) {
  constexpr int kRadius = RowRules::kRadius;
  double across = 0, down = 0, both = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    const uint8_t* const row = image[at.y + y] + at.x;
    const uint8_t* const above = image[at.y + y - 1] + at.x;
    const uint8_t* const below = image[at.y + y + 1] + at.x;
    for (int x = -kRadius; x <= kRadius; ++x) {
      const int du = row[x + 1] - row[x - 1];
      const int dv = below[x] - above[x];
      across += du * du;
      down += dv * dv;
      both += du * dv;
    }
  }
  constexpr double kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
  return (across + down - std::hypot(across - down, 2 * both)) / (2 * kPixels);
}

// Variance of an image's noise, in the quarter of the parts that have least.
double NoiseVariance(const cv::Mat1b& image) {
  std::vector<double> noise;
  for (int i = 0; i < kParts; ++i) {
    const cv::Rect part = PartAt(i, image.size());
    const cv::Point middle = (part.tl() + part.br()) / 2;
    if (!IsInside(middle.x, middle.y, image.size(), RowRules::kRadius + 1)) continue;
    noise.push_back(sprout::NoiseVariance<RowRules::kRadius>(image, middle));
  }
  return noise.empty() ? 0 : Quantile(noise, 0.25);
}

// Where a parabola through the best of some equidistant values and its neighbours has its top.
double TopOf(std::span<const double> values) {
  const auto best = static_cast<size_t>(std::ranges::max_element(values) - values.begin());
  const auto at = static_cast<double>(best);
  if (best == 0 || best + 1 == values.size()) return at;
  const double bend = 2 * values[best] - values[best - 1] - values[best + 1];
  return bend > 0 ? at + (values[best + 1] - values[best - 1]) / (2 * bend) : at;
}

// The place up and down where the right image is most like a pixel's window, as its match.
std::optional<inputs::Match> MatchOf(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at,
                                     int u_right) {
  constexpr int kUpDown = RowRules::kUpDown;
  std::array<double, 2 * kUpDown + 1> likeness;
  for (int y = -kUpDown; y <= kUpDown; ++y) {
    double& best = likeness[static_cast<size_t>(y + kUpDown)];
    best = -1;
    for (int x = -RowRules::kSideways; x <= RowRules::kSideways; ++x) {
      best = std::max(
          best, WindowCorrelation<RowRules::kRadius>(left, right, at, {u_right + x, at.y + y}));
    }
  }
  return inputs::Match{.left = at, .right = cv::Point2d(u_right, at.y + TopOf(likeness) - kUpDown)};
}

// The column of the right image where a pixel of the map matches.
int RightColumnOf(const DisparityImage& map, cv::Point at) {
  return cvRound(at.x - double{map.Px(at.x, at.y)});
}

// The strongest corner of a part; nothing where no window fits or has texture.
std::optional<cv::Point> CornerOf(const JudgedFrame& frame, const cv::Rect& part,
                                  double least_cornerness) {
  const DisparityImage& map = frame.filled;
  constexpr int kMargin = RowRules::kRadius + RowRules::kUpDown + 1;
  double best = least_cornerness;
  std::optional<cv::Point> corner;
  for (int i = 0; i < RowRules::kAcross * RowRules::kDown; ++i) {
    const cv::Point at(
        part.x + part.width * (2 * (i % RowRules::kAcross) + 1) / (2 * RowRules::kAcross),
        part.y + part.height * (2 * (i / RowRules::kAcross) + 1) / (2 * RowRules::kDown));
    if (!IsInside(at.x, at.y, map.size(), kMargin) || !map.IsValid(at.x, at.y)) continue;
    const double u_right = at.x - double{map.Px(at.x, at.y)};
    if (!IsInside(u_right, at.y, map.size(), kMargin)) continue;
    const double cornerness = Cornerness(frame.left, at);
    if (cornerness <= best) continue;
    best = cornerness;
    corner = at;
  }
  return corner;
}

// Whether the right image shows the same at most corners of every fourth part, as that of a right
// map does: then no more has to be asked.
bool ShowsAtAGlance(const JudgedFrame& frame, const cv::Mat1b& parts, double least_cornerness) {
  int corners = 0;
  int alike = 0;
  for (int i = 0; i < kParts; i += RowRules::kGlanceStep) {
    if (parts.data[i] == 0) continue;
    const auto corner = CornerOf(frame, PartAt(i, frame.filled.size()), least_cornerness);
    if (!corner) continue;
    ++corners;
    const cv::Point match(RightColumnOf(frame.filled, *corner), corner->y);
    alike += WindowCorrelation<RowRules::kRadius>(frame.left, frame.right, *corner, match) >
                     RowRules::kAlike
                 ? 1
                 : 0;
  }
  return 2 * alike > corners;
}

// Multiplies the confidence of the parts of one origin, and adds an error of the columns.
void Bound(const JudgedFrame& frame, SeedOrigin origin, double factor, double columns_px,
           ConfidenceEstimator::Judgement& judgement) {
  cv::Mat1b confidences(1, 256), sigmas(1, 256);
  for (int i = 0; i < 256; ++i) {
    const auto counts = static_cast<uint8_t>(i);
    const double sigma_px = std::hypot(SigmaToPx(counts), columns_px / std::numbers::sqrt3);
    confidences(i) = static_cast<uint8_t>(factor * counts);
    sigmas(i) = counts == kMaxSigmaCounts || columns_px == 0 ? counts : SigmaToCounts(sigma_px);
  }
  const cv::Size size = frame.filled.size();
  const cv::Mat1b parts = PartsOf(origin, frame.seeds, size);
  for (int i = 0; i < kParts; ++i) {
    if (parts.data[i] == 0) continue;
    cv::Mat1b confidence = judgement.confidence(PartAt(i, size));
    cv::Mat1b sigma = judgement.sigma(PartAt(i, size));
    cv::LUT(confidence, confidences, confidence);
    cv::LUT(sigma, sigmas, sigma);
  }
}

// Of what stereo found.
std::string BoundMatches(const JudgedFrame& frame, ConfidenceEstimator::Judgement& judgement) {
  const RowCheck check = CheckRows(frame, judgement.confidence, SeedOrigin::kStereo);
  const double most = RowRules::kMinClaimedShare * check.claimed;
  const double columns_px = check.columns_px > 1 ? check.columns_px : 0;
  if (check.right_share >= most && columns_px == 0) return {};
  const double factor = std::min(1.0, check.right_share / std::max(most, 1e-9));
  Bound(frame, SeedOrigin::kStereo, factor / std::max(1.0, columns_px), columns_px, judgement);
  if (columns_px > 0) {
    return cv::format("rows of the images do not fit, so columns may be off by %.1f px, too",
                      columns_px);
  }
  return cv::format(
      "of the matches away from ranges at most %.0f %% are on the row where they fit best, %.0f %% "
      "are claimed",
      100 * check.right_share, 100 * check.claimed);
}

// Of ranges.
std::string BoundRanges(const JudgedFrame& frame, ConfidenceEstimator::Judgement& judgement) {
  const RowCheck check = CheckRows(frame, judgement.confidence, SeedOrigin::kTof);
  if (check.right_share >= RowRules::kMinRangeShare * check.claimed) return {};
  Bound(frame, SeedOrigin::kTof, check.right_share / check.claimed, 0, judgement);
  return cv::format(
      "where the map depends on ranges, the images show at most %.0f %% of it to be right, on any "
      "rows; %.0f %% are claimed",
      100 * check.right_share, 100 * check.claimed);
}

}  // namespace

RowCheck CheckRows(const JudgedFrame& frame, const cv::Mat1b& confidence, SeedOrigin origin) {
  const cv::Size size = frame.filled.size();
  const cv::Mat1b parts = PartsOf(origin, frame.seeds, size);
  double least = RowRules::kMinGrey * RowRules::kMinGrey;
  if (origin == SeedOrigin::kTof) {
    // A difference of two pixels has the noise of both.
    least = std::max(least, RowRules::kClearSignal * 2 * NoiseVariance(frame.left));
    if (ShowsAtAGlance(frame, parts, least)) return {};
  }
  std::array<std::optional<inputs::Match>, kParts> asked;
  ForEachParallel(asked.size(), [&](size_t i) {
    const auto part = static_cast<int>(i);
    if (parts.data[i] == 0) return;
    const auto corner = CornerOf(frame, PartAt(part, size), least);
    if (corner)
      asked[i] = MatchOf(frame.left, frame.right, *corner, RightColumnOf(frame.filled, *corner));
  });
  inputs::Matches matches;
  matches.most_rows_px = RowRules::kUpDown;
  RowCheck check;
  for (const std::optional<inputs::Match>& match : asked) {
    if (!match) continue;
    matches.matches.push_back(*match);
    check.claimed += confidence(cv::Point(match->left)) / 255.0;
  }
  const auto count = static_cast<double>(matches.matches.size());
  if (matches.matches.size() < RowRules::kMinCorners) return {};
  check.claimed /= count;
  const inputs::PairModel model = inputs::FitPair(matches, size);
  // Wrong ones agree by chance; of another scene no rows are better than the own ones.
  const double by_chance = model.by_chance.value / count;
  const auto agree = inputs::ShowOneScene(model)
                         ? std::ssize(model.inliers)
                         : std::ranges::count_if(matches.matches, [&](const inputs::Match& match) {
                             return std::abs(match.rows()) <= by_chance * RowRules::kUpDown;
                           });
  const double share = static_cast<double>(agree) / count;
  const double sigma = std::sqrt(share * (1 - share) / count);
  check.right_share =
      std::clamp((share + RowRules::kSigmas * sigma - by_chance) / (1 - by_chance), 0.0, 1.0);
  check.columns_px = inputs::ColumnErrorPx(model, size.width);
  return check;
}

std::string BoundByRows(const JudgedFrame& frame, ConfidenceEstimator::Judgement& judgement) {
  return JoinedTexts(BoundMatches(frame, judgement), BoundRanges(frame, judgement));
}

}  // namespace sprout::grow
