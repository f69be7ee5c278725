#include "common/inputs/range_model.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "common/core/quantile.h"
#include "common/inputs/modes.h"
#include "common/inputs/point_grid.h"

namespace sprout::inputs {
namespace {

struct RangeRules {
  static constexpr size_t kMaxPoints = 10000;  ///< that are compared; more say no more
  static constexpr size_t kMaxTurned = 2500;   ///< in each other turn, if they are good as they are
  /// See Vote.
  static constexpr double kTolerancePx = 1;
  static constexpr double kToleranceShare = 0.03;
  static constexpr double kToleranceM = 0.05;
  static constexpr double kCloseShare = 0.01;
  static constexpr double kMinDisparityPx = 1;  ///< farther matches do not tell a factor
  /// Other explanations are searched where fewer agree.
  static constexpr double kGood = 0.9;
  static constexpr double kClose = 0.85;
  /// Moves ahead that are tried, shares of the median distance.
  static constexpr double kMoves[] = {0.015, 0.03, 0.045, 0.06, 0.08, 0.1};
  /// Moves in the picture, shares of the picture's width: 1 to 7 degrees of a camera that sees 60.
  static constexpr double kShifts[] = {0.015, 0.03, 0.06, 0.12};
  /// Widths of the field of view that are tried first, shares of what the calibration says.
  static constexpr double kSpreads[] = {0.5,  0.6,  0.7,  0.8, 0.87, 0.93,
                                        1.07, 1.15, 1.25, 1.4, 1.7,  2};
  /// Beside columns that are moved: ranges in mm, cm, 1/256 m ..., taken for another of these.
  static constexpr double kUnits[] = {1e3,          1e2,           10,        0.25,
                                      0.1,          0.125,         0.01,      1e-3,
                                      1000.0 / 256, 1000.0 / 5000, 1.0 / 256, 1.0 / 5000};
  static constexpr double kMaxAside = 0.25;  ///< of these columns, a share of the width
  static constexpr double kSquare = 0.03;    ///< of |ln(fy/fx)|: less is a square pixel
  static constexpr double kApart = 0.1;      ///< see RangeModel::apart
};

// A pixel of the range image.
struct RangePixel {
  cv::Point at;
  float depth;
};

// All values of a range image; counts returns and pairs of them.
std::vector<RangePixel> Collect(const TofImage& tof, RangeModel& model) {
  model.pixels = static_cast<int>(tof.depth_m.total());
  std::vector<RangePixel> all;
  for (int y = 0; y < tof.depth_m.rows; ++y) {
    const float* row = tof.depth_m[y];
    for (int x = 0; x < tof.depth_m.cols; ++x) {
      if (!(row[x] > 0 && row[x] <= std::numeric_limits<float>::max())) continue;
      if (IsReturn(row[x])) ++model.returns;
      if (x > 0 && IsReturn(row[x]) && IsReturn(row[x - 1])) {
        ++model.pairs;
        if (std::abs(row[x] - row[x - 1]) > RangeRules::kApart * std::min(row[x], row[x - 1])) {
          ++model.apart;
        }
      }
      all.push_back({{x, y}, row[x]});
    }
  }
  model.values = static_cast<int>(all.size());
  return all;
}

std::vector<RangePixel> Chosen(const std::vector<RangePixel>& all, size_t most) {
  const size_t step = std::max<size_t>(1, all.size() / most);
  std::vector<RangePixel> chosen;
  for (size_t i = 0; i < all.size(); i += step) chosen.push_back(all[i]);
  return chosen;
}

// Where a pixel lies in the turned image; of other proportions, in its shares.
cv::Point Turned(cv::Point at, cv::Size size, const Turn& turn) {
  if (turn.transposed) {
    at = {static_cast<int>((at.y + 0.5) * size.width / size.height),
          static_cast<int>((at.x + 0.5) * size.height / size.width)};
  }
  if (turn.mirrored) at.x = size.width - 1 - at.x;
  if (turn.upside_down) at.y = size.height - 1 - at.y;
  return at;
}

// Range points against matches of one frame.
class Comparison {
 public:
  Comparison(std::span<const Match> matches, const TofProjector& projector)
      : matches_(matches),
        projector_(projector),
        rotation_(projector.rig().tof.left_from_tof_rotation.toRotationMatrix()) {}

  Agreement Compare(std::span<const RangePixel> pixels, const Hypothesis& hypothesis) const {
    const RectifiedPair& pair = projector_.rig().pair;
    const double fb = pair.focal_px * pair.baseline_m;
    std::vector<PicturePoint> points = Project(pixels, hypothesis);
    const auto in_picture = static_cast<int>(points.size());
    const auto in_both = std::ranges::count_if(points, [&](const PicturePoint& point) {
      const double u_right = point.u - point.disparity + pair.cx_right - pair.cx;
      return u_right >= 0 && u_right < pair.width;
    });
    PointGrid grid(std::move(points), pair.size());
    Agreement result;
    result.with = hypothesis;
    result.in_picture = in_picture;
    result.in_both = static_cast<int>(in_both);
    result.votes.assign(matches_.size(), Vote::kNone);
    for (size_t i = 0; i < matches_.size(); ++i) {
      const double stereo =
          matches_[i].disparity() + pair.cx_right - pair.cx + hypothesis.columns_px;
      if (stereo < RangeRules::kMinDisparityPx) continue;
      const std::optional<double> range = grid.SurfaceAt(cv::Point2f(matches_[i].left));
      if (!range) continue;
      const double off = std::abs(*range - stereo);
      const double loose = RangeRules::kTolerancePx + RangeRules::kToleranceShare * stereo +
                           RangeRules::kToleranceM * stereo * stereo / fb;
      const double close = RangeRules::kTolerancePx + RangeRules::kCloseShare * stereo;
      result.votes[i] = off <= close   ? Vote::kIsClose
                        : off <= loose ? Vote::kAgrees
                                       : Vote::kDisagrees;
      ++result.compared;
      result.logs.push_back(std::log(*range / stereo));
      result.offs_px.push_back(*range - stereo);
      if (off <= close) ++result.close;
      if (off > loose) continue;
      ++result.agreeing;
      result.offsets_m.push_back(fb / *range - fb / stereo);
    }
    return result;
  }

  std::vector<PicturePoint> Project(std::span<const RangePixel> pixels,
                                    const Hypothesis& hypothesis) const {
    const Rig& rig = projector_.rig();
    const RectifiedPair& pair = rig.pair;
    const cv::Size size(rig.tof.width, rig.tof.height);
    const Eigen::Vector3d position =
        rig.tof.left_from_tof_translation_m + Eigen::Vector3d(0, 0, hypothesis.ahead_m);
    std::vector<PicturePoint> points;
    points.reserve(pixels.size());
    for (const RangePixel& pixel : pixels) {
      const cv::Point at = Turned(pixel.at, size, hypothesis.turn);
      Eigen::Vector3d ray = projector_.ray(at.x, at.y);
      ray.x() *= hypothesis.spread.x;
      ray.y() *= hypothesis.spread.y;
      const double depth = DepthOf(hypothesis.reading, pixel.depth, ray);
      const Eigen::Vector3d point = rotation_ * (ray * (hypothesis.factor * depth)) + position;
      if (!(point.z() > 0)) continue;
      const double share = pair.focal_px / point.z();
      const double u = share * point.x() + pair.cx + hypothesis.move_px.x;
      const double v = share * point.y() + pair.cy + hypothesis.move_px.y;
      if (!(u >= 0 && u < pair.width && v >= 0 && v < pair.height)) continue;
      points.push_back({static_cast<float>(u), static_cast<float>(v),
                        static_cast<float>(share * pair.baseline_m)});
    }
    return points;
  }

 private:
  std::span<const Match> matches_;
  const TofProjector& projector_;
  Eigen::Matrix3d rotation_;
};

// The best move of all columns alike, as of an image that was cropped, or a camera that is turned,
// beside ranges of a hypothesis.
Agreement BestAside(const Comparison& comparison, std::span<const RangePixel> pixels, int width,
                    Hypothesis with) {
  with.columns_px = width;  // beyond all: of disparities below 1 px none is compared
  const Agreement all = comparison.Compare(pixels, with);
  with.columns_px += all.compared == 0 ? 0 : ModeOf(all.offs_px);
  return std::abs(with.columns_px) < width ? comparison.Compare(pixels, with) : Agreement{};
}

// The same beside ranges that are turned, or in another unit, if those as they are do not fit.
Agreement BestAside(const Comparison& comparison, std::span<const RangePixel> pixels, int width) {
  Agreement best = BestAside(comparison, pixels, width, {});
  if (best.close_share() >= RangeRules::kClose) return best;
  const auto look_at = [&](const Hypothesis& hypothesis) {
    Agreement aside = BestAside(comparison, pixels, width, hypothesis);
    const bool is_likely = std::abs(aside.with.columns_px) < width * RangeRules::kMaxAside;
    if (is_likely && aside.close > best.close) best = std::move(aside);
  };
  for (const Turn& turn : kTurns) look_at({.turn = turn});
  for (const double factor : RangeRules::kUnits) look_at({.factor = factor});
  return best;
}

// The best factor. In another unit points lie at other places in the picture, so it takes two
// steps.
Agreement BestScaled(const Comparison& comparison, std::span<const RangePixel> pixels) {
  Agreement best;
  // Ranges in mm taken for m, and the other way round, may fall nowhere near the matches.
  for (double factor : {1.0, 1e3, 1e-3}) {
    for (int step = 0; step < 2; ++step) {
      factor *= BestFactor(comparison.Compare(pixels, {.factor = factor}).logs);
    }
    Agreement scaled = comparison.Compare(pixels, {.factor = factor});
    if (scaled.agreeing > best.agreeing) best = std::move(scaled);
  }
  return best;
}

double MedianDistance(std::span<const Match> matches, const RectifiedPair& pair) {
  std::vector<double> distances;
  for (const Match& match : matches) {
    const double disparity = match.disparity() + pair.cx_right - pair.cx;
    if (disparity < RangeRules::kMinDisparityPx) continue;
    distances.push_back(pair.focal_px * pair.baseline_m / disparity);
  }
  return distances.empty() ? 0 : Median(distances);
}

// @param distance_m  about that of the scene.
Agreement BestMisread(const Comparison& comparison, std::span<const RangePixel> pixels,
                      double distance_m) {
  std::vector<double> values;
  for (const RangePixel& pixel : pixels) values.push_back(pixel.depth);
  Hypothesis hypothesis{.factor = distance_m * Median(values), .reading = Reading::kInverse};
  for (int step = 0; step < 2; ++step) {
    hypothesis.factor *= BestFactor(comparison.Compare(pixels, hypothesis).logs);
  }
  Agreement best = comparison.Compare(pixels, hypothesis);
  for (const Reading reading : {Reading::kAlongRay, Reading::kOtherBytes, Reading::kWithFlags}) {
    Agreement misread = comparison.Compare(pixels, {.reading = reading});
    if (misread.agreeing > best.agreeing) best = std::move(misread);
  }
  return best;
}

// @param transposed  whether turns by 90° are tried, too.
Agreement BestTurned(const Comparison& comparison, std::span<const RangePixel> pixels,
                     bool transposed) {
  Agreement best;
  for (const Turn& turn : kTurns) {
    if (turn == Turn{} || (turn.transposed && !transposed)) continue;
    Agreement turned = comparison.Compare(pixels, {.turn = turn});
    if (turned.agreeing > best.agreeing) best = std::move(turned);
  }
  return best;
}

Agreement BestMoved(const Comparison& comparison, std::span<const RangePixel> pixels,
                    double distance_m) {
  Agreement best;
  for (const double move : RangeRules::kMoves) {
    for (const double ahead_m : {-move * distance_m, move * distance_m}) {
      Agreement moved = comparison.Compare(pixels, {.ahead_m = ahead_m});
      if (moved.close > best.close) best = std::move(moved);
    }
  }
  return best;
}

// The best of moves in the picture, from a few far apart to finer ones around the best of them.
Agreement BestShifted(const Comparison& comparison, std::span<const RangePixel> pixels, int width) {
  Agreement best;
  // By value: `best` changes meanwhile.
  const auto look_around = [&](const cv::Point2d from, double step_px) {
    for (int direction = 0; direction < 8; ++direction) {
      const double angle = direction * CV_PI / 4;
      const cv::Point2d move_px = from + step_px * cv::Point2d(std::cos(angle), std::sin(angle));
      Agreement shifted = comparison.Compare(pixels, {.move_px = move_px});
      if (shifted.close > best.close) best = std::move(shifted);
    }
  };
  for (const double shift : RangeRules::kShifts) look_around({0, 0}, shift * width);
  // Each ring is twice as wide as the one before: between them lies half a radius.
  double step_px = cv::norm(best.with.move_px);
  for (int i = 0; i < 2; ++i) look_around(best.with.move_px, step_px /= 2);
  return best;
}

// Narrower fields of view reach fewer matches, so those that disagree count as well.
int MeritOf(const Agreement& agreement) {
  return agreement.close - 2 * (agreement.compared - agreement.close);
}

// @param height  of a pixel, as a share of what the calibration says.
Agreement BestSpread(const Comparison& comparison, std::span<const RangePixel> pixels,
                     double height) {
  Agreement best;
  const auto look_at = [&](const cv::Point2d& spread) {
    Agreement agreement = comparison.Compare(pixels, {.spread = spread});
    if (MeritOf(agreement) > MeritOf(best)) best = std::move(agreement);
  };
  if (height != 1) look_at({1, height});
  for (const double spread : RangeRules::kSpreads) look_at({spread, spread * height});
  for (const double step : {0.04, 0.02}) {
    const cv::Point2d from = best.with.spread;  // `best` changes meanwhile
    look_at(from * (1 - step));
    look_at(from * (1 + step));
  }
  return best;
}

// Tries square pixels, too, where the calibration has oblong ones: images of 4:3 may be taken for
// 16:9.
Agreement BestSpread(const Comparison& comparison, std::span<const RangePixel> pixels,
                     const TofCamera& tof) {
  Agreement best = BestSpread(comparison, pixels, 1);
  const double height = tof.fy / tof.fx;
  if (std::abs(std::log(height)) < RangeRules::kSquare) return best;
  Agreement square = BestSpread(comparison, pixels, height);
  return MeritOf(square) > MeritOf(best) ? square : best;
}

std::vector<Match> Swapped(std::span<const Match> matches) {
  std::vector<Match> swapped;
  for (const Match& match : matches) swapped.push_back({.left = match.right, .right = match.left});
  return swapped;
}

// Removes the pixels with a number that stands for no return.
void RemoveNoReturns(const TofImage& tof, const Comparison& comparison,
                     std::vector<RangePixel>& all, RepeatedRange& repeated) {
  repeated = FindRepeatedRange(tof);
  if (repeated.count == 0) return;
  const auto others = std::ranges::stable_partition(
      all, [&](const RangePixel& pixel) { return pixel.depth == repeated.depth_m; });
  const std::vector<RangePixel> there(all.begin(), others.begin());
  const Agreement agreement = comparison.Compare(Chosen(there, RangeRules::kMaxPoints), {});
  repeated.compared = agreement.compared;
  repeated.agreeing = agreement.agreeing;
  if (repeated.MeansNothing()) all.erase(all.begin(), others.begin());
}

}  // namespace

double MoreAgree(const Agreement& one, const Agreement& other, Vote least) {
  int only_one = 0;
  int only_other = 0;
  for (size_t i = 0; i < std::min(one.votes.size(), other.votes.size()); ++i) {
    if (one.votes[i] == Vote::kNone || other.votes[i] == Vote::kNone) continue;
    if (one.votes[i] >= least && other.votes[i] < least) ++only_one;
    if (other.votes[i] >= least && one.votes[i] < least) ++only_other;
  }
  return (only_one - only_other) / std::sqrt(std::max(1, only_one + only_other));
}

RangeModel CompareRanges(const std::vector<Match>& matches, const TofImage& tof,
                         const TofProjector& projector) {
  RangeModel model;
  std::vector<RangePixel> all = Collect(tof, model);
  if (all.empty()) return model;
  const RectifiedPair& pair = projector.rig().pair;
  const Comparison comparison(matches, projector);
  RemoveNoReturns(tof, comparison, all, model.repeated);
  const std::vector<RangePixel> pixels = Chosen(all, RangeRules::kMaxPoints);
  model.as_is = comparison.Compare(pixels, {});
  const double part = static_cast<double>(pixels.size()) / static_cast<double>(all.size());
  model.in_picture = static_cast<int>(std::lround(model.as_is.in_picture / part));
  model.in_both = static_cast<int>(std::lround(model.as_is.in_both / part));
  const bool is_good = model.as_is.share() >= RangeRules::kGood;
  model.turned =
      BestTurned(comparison, is_good ? Chosen(all, RangeRules::kMaxTurned) : pixels, !is_good);
  if (!is_good) {
    model.scaled = BestScaled(comparison, pixels);
    model.misread = BestMisread(comparison, pixels, MedianDistance(matches, pair));
    const std::vector<Match> swapped = Swapped(matches);
    model.swapped = Comparison(swapped, projector).Compare(pixels, {});
    model.aside = BestAside(comparison, pixels, pair.width);
  }
  if (model.as_is.close_share() < RangeRules::kClose) {
    model.shifted = BestShifted(comparison, Chosen(all, RangeRules::kMaxTurned), pair.width);
    model.spread = BestSpread(comparison, Chosen(all, RangeRules::kMaxTurned), projector.rig().tof);
    model.moved = BestMoved(comparison, pixels, MedianDistance(matches, pair));
  }
  const Agreement& fitting =
      model.scaled.agreeing > model.as_is.agreeing ? model.scaled : model.as_is;
  const Estimate log = MedianOf(fitting.logs);
  model.ratio.value = std::exp(-log.value) / fitting.with.factor;
  model.ratio.sigma = model.ratio.value * log.sigma;
  model.offset_m = MedianOf(model.as_is.offsets_m);
  return model;
}

}  // namespace sprout::inputs
