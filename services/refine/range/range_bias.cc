#include "services/refine/range/range_bias.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "common/core/parallel.h"
#include "services/refine/range/pair_fit.h"
#include "services/refine/range/range_costs.h"
#include "services/refine/range/range_nodes.h"
#include "services/refine/range/row_shift.h"
#include "services/refine/stereo/point_surface.h"

namespace sprout::refine {
namespace {

// What became of a point.
constexpr uint8_t kMoved = 1;
constexpr uint8_t kMovedFar = 2;
constexpr uint8_t kFarFromCurve = 4;
constexpr int kWidestReach = 8;  // of the windows around a point, cells
constexpr int kReaches[] = {1, 2, 4, kWidestReach};

// Moves a point along its ray, so that its disparity grows.
void MovePoint(const RectifiedPair& pair, const Eigen::Vector3d& centre, double offset_px,
               ProjectedPoint& point) {
  const Eigen::Vector3d from = PointFromSeed(pair, point.seed);
  const double depth_m = pair.DepthFromDisparity(point.seed.disparity() + offset_px);
  const double scale = (depth_m - centre.z()) / (from.z() - centre.z());
  if (!(scale > 0 && depth_m > 0) || !std::isfinite(scale)) return;
  const Seed moved = ProjectToPair(pair, centre + scale * (from - centre));
  point.seed.u = moved.u;
  point.seed.v = moved.v;
  point.seed.u_right = moved.u_right;
}

constexpr double kMinShare = 0.005;  // that is more than 0 %

// How many standard deviations of its own a knot is off.
double SigmasOf(const RangeKnot& knot) { return std::abs(knot.error_m) / knot.sigma_m; }

// Nearest, most and farthest of the knots whose error the images show; in a curve that is sure only
// as a whole, the surest of those that are off.
std::vector<RangeKnot> ShownKnots(const std::vector<RangeKnot>& curve) {
  constexpr double kStandardDeviations = 3;
  std::vector<RangeKnot> sure;
  std::ranges::copy_if(curve, std::back_inserter(sure),
                       [](const RangeKnot& knot) { return SigmasOf(knot) > kStandardDeviations; });
  if (sure.empty()) return {*std::ranges::max_element(curve, {}, SigmasOf)};
  const auto most = std::ranges::max_element(
      sure, {}, [](const RangeKnot& knot) { return std::abs(knot.error_m); });
  std::vector<RangeKnot> shown = {sure.front()};
  if (most != sure.begin()) shown.push_back(*most);
  if (most + 1 < sure.end()) shown.push_back(sure.back());
  return shown;
}

// The px that a curve moves all points by, if it is known to be about the same at all depths, as of
// a pair whose right camera is turned: that fits its knots, and an error of so many metres, or of
// such a part of the depth, does not; else 0.
double SamePx(const RectifiedPair& pair, std::span<const RangeKnot> curve) {
  constexpr int kPowers = 3;  // of the depth: metres, a part of it, px
  std::array<double, kPowers> misfits{};
  double same = 0;
  for (int power = 0; power < kPowers; ++power) {
    const auto shape = [&](const RangeKnot& knot) { return std::pow(knot.depth_m, power); };
    double weight = 0, sum = 0;
    for (const RangeKnot& knot : curve) {
      const double w = shape(knot) / (knot.sigma_m * knot.sigma_m);
      sum += w * knot.error_m;
      weight += w * shape(knot);
    }
    same = sum / weight;
    for (const RangeKnot& knot : curve) {
      misfits[static_cast<size_t>(power)] +=
          std::pow((knot.error_m - same * shape(knot)) / knot.sigma_m, 2);
    }
  }
  const double more = std::min(misfits[0], misfits[1]) - misfits[2];
  constexpr double kSigmas = 1;  // which include what all knots err alike
  const bool is_same = misfits[2] < static_cast<double>(curve.size()) && more > kSigmas * kSigmas;
  return is_same ? same * pair.focal_px * pair.baseline_m : 0;
}

}  // namespace

bool RangeError::IsBeyondDataSheets() const {
  return !curve_is_zero && std::ranges::any_of(curve, [](const RangeKnot& knot) {
    return std::abs(knot.error_m) > RangeRules::kDoubtfulOfDepth * knot.depth_m;
  });
}

// Costs reach a few px to either side, on the slant as measured: what is far off is seen better
// from where the first look puts it. Returns whether there was any.
bool RangeBias::LookAgain(const RangeInput& input) {
  int look = 0;
  for (; look < RangeRules::kMoreLooks && field_.variance_px2() > 0; ++look) {
    const std::span<const NodeOffset> offsets = field_.offsets();
    if (std::ranges::none_of(offsets, [](const NodeOffset& offset) {
          return std::abs(offset.offset_px) >= RangeRules::kFarOffsetPx;
        })) {
      break;
    }
    nodes_.Move(input, NodeMoves());
    field_.Improve(nodes_);
  }
  return look > 0;
}

// What the nodes are off by.
std::vector<double> RangeBias::NodeMoves() const {
  std::vector<double> moves_px = start_px_;
  for (size_t i = 0; i < moves_px.size(); ++i) moves_px[i] += field_.offsets()[i].offset_px;
  return moves_px;
}

// Which nodes the images contradict; returns their share of those whose texture can show it.
double RangeBias::JudgeNodes() {
  const std::span<const RangeNode> nodes = nodes_.nodes();
  const std::span<const NodeOffset> offsets = field_.offsets();
  wrong_nodes_.assign(nodes.size(), 0);
  const double noise = RangeRules::kUnlikeVariance + nodes_.noise();
  size_t judged = 0, wrong = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const double signal = offsets[i].texture - noise;
    if (!nodes[i].whole || signal < RangeRules::kClearSignal * noise) continue;
    ++judged;
    // Eq. (R10).
    const double expected = signal / (signal + noise);
    if (offsets[i].likeness > RangeRules::kContradicted * expected) continue;
    ++wrong;
    wrong_nodes_[i] = 1;
  }
  unlike_nodes_ = wrong_nodes_;
  KeepPatches(nodes_, RangeRules::kProvedNodes, wrong_nodes_);
  return judged < RangeRules::kFewestNodes
             ? 0
             : static_cast<double>(wrong) / static_cast<double>(judged);
}

// Whether the images match elsewhere at many of the nodes that they contradict. If not they do not
// fit each other, as where one is out of focus or a few rows off.
bool RangeBias::MatchesElsewhere(const RangeInput& input, std::span<const Seed> matches) const {
  const CellGrid grid(std::max(1.0, RangeRules::kMatchReach * input.left.cols), input.left.size());
  cv::Mat1b matched(grid.size, uint8_t{0});
  const double noise = RangeRules::kUnlikeVariance + nodes_.noise();
  for (const Seed& match : matches) {
    if (IsAlike(input.left, input.right, match, noise)) {
      matched(grid.At(match.v), grid.At(match.u)) = 1;
    }
  }
  size_t contradicted = 0, elsewhere = 0;
  for (size_t i = 0; i < unlike_nodes_.size(); ++i) {
    if (unlike_nodes_[i] == 0) continue;
    const cv::Point2d& at = nodes_.nodes()[i].at;
    ++contradicted;
    elsewhere += matched(grid.At(at.y), grid.At(at.x));
  }
  const double part = error_.contradicted_share > RangeRules::kRejectedShare
                          ? std::min(1.0, error_.contradicted_share / RangeRules::kManyContradicted)
                          : 1;
  return static_cast<double>(elsewhere) >
         RangeRules::kMatchedShare * part * static_cast<double>(contradicted);
}

// Whether nothing can be estimated, since too much is wrong with the points or with the pair. Right
// frames do not take the time.
bool RangeBias::JudgePair(const RangeInput& input, const RangeSettings& settings,
                          std::span<const ProjectedPoint> points) {
  const bool many = error_.contradicted_share > RangeRules::kRejectedShare;
  const bool doubtful = !curve_.is_zero() || field_.variance_px2() > 0 ||
                        error_.contradicted_share > RangeRules::kDoubtfulShare;
  const PairFit fit = doubtful ? PairFitAt(input, nodes_) : PairFit{};
  const bool on_other_rows = fit.rows_gain > RangeRules::kRowsGain;
  error_.rows_unfit = on_other_rows && !many;
  error_.pair_unfit = on_other_rows;
  if (!on_other_rows && (many || fit.cost > RangeRules::kPoorCost)) {
    const std::span<const Seed> matches = settings.matches();
    error_.rows_shifted =
        ShiftsRows({.raw = {},
                    .corrected = points,
                    .spacing_px = {input.surface.column_px(), input.surface.row_px()},
                    .image = input.left.size(),
                    .infinity_px = input.rig.pair.cx - input.rig.pair.cx_right},
                   matches);
    error_.pair_unfit = error_.rows_shifted || !MatchesElsewhere(input, matches);
  }
  error_.rejected = many && !error_.pair_unfit;
  const bool shows_nothing = error_.pair_unfit && !error_.rows_unfit;
  if (shows_nothing) error_.curve.clear();
  return error_.rejected || shows_nothing;
}

// Marks where points have to be asked for: within reach of a node that moves, is unsure or is
// contradicted. With a sensor that is right there is none.
bool RangeBias::MarkAsked() {
  const bool all = field_.variance_px2() > 0;
  asked_.create(nodes_.size());
  asked_ = all ? 1 : 0;
  if (all) return true;
  bool any = false;
  for (size_t i = 0; i < wrong_nodes_.size(); ++i) {
    if (wrong_nodes_[i] == 0 && field_.offsets()[i].offset_px == 0) continue;
    asked_(nodes_.nodes()[i].cell) = 1;
    any = true;
  }
  constexpr int kSide = 2 * kWidestReach + 1;
  if (any) cv::dilate(asked_, asked_, cv::Mat1b::ones(kSide, kSide));
  return any;
}

// What the nodes around a point say of it: those of its surface, within a widening window.
RangeBias::PointError RangeBias::ErrorOf(const TofSurface& surface,
                                         const ProjectedPoint& point) const {
  const double disparity = point.seed.disparity();
  const cv::Point2d at(point.seed.u, point.seed.v);
  const cv::Point2d cell = nodes_.CellOf(surface, point);
  const cv::Point nearest(static_cast<int>(std::lround(cell.x)),
                          static_cast<int>(std::lround(cell.y)));
  if (cv::Rect({}, asked_.size()).contains(nearest) && asked_(nearest) == 0) return {};
  double weight = 0, offset_px = 0, variance = 0, wrong = 0;
  for (const int reach : kReaches) {
    const cv::Rect window =
        cv::Rect({}, nodes_.size()) &
        cv::Rect(nearest.x - reach, nearest.y - reach, 2 * reach + 1, 2 * reach + 1);
    for (int y = window.y; y < window.y + window.height; ++y) {
      for (int x = window.x; x < window.x + window.width; ++x) {
        if (nodes_.At(x, y) < 0) continue;
        const auto i = static_cast<size_t>(nodes_.At(x, y));
        const RangeNode& node = nodes_.nodes()[i];
        if (!IsOnSurface(node, at, disparity)) continue;
        const NodeOffset& offset = field_.offsets()[i];
        const double across = cell.x - x;
        const double down = cell.y - y;
        const double w = 1 / (0.25 + across * across + down * down);
        weight += w;
        offset_px += w * (offset.offset_px + offset.slope.dot(at - node.at));
        variance += w * offset.sigma_px * offset.sigma_px;
        wrong += w * wrong_nodes_[i];
      }
    }
    if (weight > 0) break;
  }
  if (weight == 0) return {.variance_px2 = field_.variance_px2()};
  return {.offset_px = offset_px / weight,
          .variance_px2 = variance / weight,
          .contradicted = wrong > weight / 2};
}

const RangeError& RangeBias::Apply(const RangeInput& input, const RangeSettings& settings,
                                   std::span<ProjectedPoint> points) {
  const RectifiedPair& pair = input.rig.pair;
  error_ = {};
  contradicted_.assign(points.size(), 0);
  nodes_.Set(input, points);
  const std::span<const RangeNode> nodes = nodes_.nodes();
  // Between a lidar's beams, and where nodes are few, slopes are not known well enough.
  const bool has_slopes =
      !input.coarse || (input.surface.has_pixels() && nodes.size() >= RangeRules::kFewestOfField);
  curve_.Estimate(nodes, pair, /*stiff=*/input.coarse);
  for (const RangeKnot& knot : curve_.knots()) {
    const double px_per_m = pair.focal_px * pair.baseline_m / (knot.depth_m * knot.depth_m);
    error_.curve.push_back(
        {.depth_m = knot.depth_m,
         .error_m = knot.error_m,
         .sigma_m = std::hypot(knot.sigma_m, RangeRules::kCurveSharedPx / px_per_m)});
  }
  // What the data sheet says is all that is known where the images show nothing.
  const auto data_sheet_px = [&](double disparity) {
    const double depth_m = pair.DepthFromDisparity(disparity);
    return pair.focal_px * pair.baseline_m / (depth_m * depth_m) * settings.error_m;
  };
  if (error_.curve.empty()) {
    for (ProjectedPoint& point : points) {
      point.seed.sigma_px = static_cast<float>(data_sheet_px(point.seed.disparity()));
    }
    return error_;
  }
  error_.curve_is_zero = curve_.is_zero();
  for (const RangeKnot& knot : curve_.knots()) {
    const double least_m = std::abs(knot.error_m) - RangeRules::kSureSigmas * knot.sigma_m;
    if (!(least_m > RangeRules::kMostOfDepth * knot.depth_m)) continue;
    error_.absurd = knot;
    contradicted_.assign(points.size(), 1);
    return error_;
  }
  nodes_.Link();
  start_px_.clear();
  for (const RangeNode& node : nodes) start_px_.push_back(curve_.OffsetPx(pair, node.disparity));
  const double least_share = settings.errs ? 0 : RangeRules::kMovedShare;
  field_.Estimate(nodes_, start_px_, settings.field && has_slopes ? least_share : 1);
  error_.contradicted_share = JudgeNodes();
  if (settings.field) {
    if (JudgePair(input, settings, points)) {
      contradicted_.assign(points.size(), error_.rejected ? 1 : 0);
      return error_;
    }
    // By then all may seem to fit: who looks far enough finds a likeness anywhere.
    if (!error_.rows_unfit && LookAgain(input)) JudgeNodes();
    if (!error_.rows_unfit && ShiftsRows(nodes_, NodeMoves(), pair.cx - pair.cx_right)) {
      error_.pair_unfit = error_.rows_shifted = true;
      error_.curve.clear();
      return error_;
    }
  }
  // Few points can hardly show that their sensor is off; so they have to show that it is not.
  const bool is_right =
      curve_.is_zero() && (!input.coarse || curve_.IsShownRight(nodes, pair, settings.error_m));
  const auto curve_sigma_px = [&](double disparity) {
    return is_right ? 0 : std::min(curve_.SigmaPx(pair, disparity), data_sheet_px(disparity));
  };
  const bool has_field = settings.field && !error_.rows_unfit && MarkAsked();
  if (!has_field && curve_.is_zero()) {
    for (ProjectedPoint& point : points) {
      point.seed.sigma_px = static_cast<float>(curve_sigma_px(point.seed.disparity()));
    }
    return error_;
  }
  moved_.assign(points.size(), 0);
  const Eigen::Vector3d centre = input.rig.tof.left_from_tof_translation_m;
  ForEachParallel(points.size(), [&](size_t i) {
    ProjectedPoint& point = points[i];
    const double disparity = point.seed.disparity();
    const PointError error =
        has_field ? ErrorOf(input.surface, point) : PointError{.variance_px2 = 0};
    const double move_px = curve_.OffsetPx(pair, disparity) + error.offset_px;
    contradicted_[i] = error.contradicted ? 1 : 0;
    point.seed.sigma_px =
        static_cast<float>(std::hypot(std::sqrt(error.variance_px2), curve_sigma_px(disparity)));
    if (move_px == 0) return;
    const auto flag = [](double px, uint8_t far) {
      return std::abs(px) > RangeRules::kFarMovePx ? far : uint8_t{0};
    };
    moved_[i] = kMoved | flag(move_px, kMovedFar) | flag(error.offset_px, kFarFromCurve);
    MovePoint(pair, centre, move_px, point);
  });
  const auto share_of = [&](uint8_t flag) {
    const auto count =
        std::ranges::count_if(moved_, [&](uint8_t moved) { return (moved & flag) != 0; });
    return static_cast<double>(count) / static_cast<double>(std::max<size_t>(1, points.size()));
  };
  if (!curve_.is_zero()) error_.same_px = SamePx(pair, error_.curve);
  error_.moved_share = share_of(kMoved);
  error_.far_moved_share = share_of(kMovedFar);
  error_.far_from_curve_share = share_of(kFarFromCurve);
  return error_;
}

std::optional<std::string> RangeErrorText(const RangeError& error) {
  if (error.curve.empty() || error.Refuses()) return std::nullopt;
  const std::string moved = fmt::format("{:.0f} % of its points were moved by more than {} px",
                                        100 * error.far_moved_share, RangeRules::kFarMovePx);
  if (error.curve_is_zero) {
    if (error.far_moved_share < kMinShare) return "";
    return "the range sensor is off as by multi-path: " + moved;
  }
  const std::vector<RangeKnot> shown = ShownKnots(error.curve);
  if (SigmasOf(shown.front()) < 1) return "the range sensor is off, at no depth for sure: " + moved;
  std::string knots;
  for (const RangeKnot& knot : shown) {
    knots += fmt::format("{}{:+.1f} ± {:.1f} mm at {:.2f} m", knots.empty() ? "" : ", ",
                         1000 * knot.error_m, 1000 * knot.sigma_m, knot.depth_m);
  }
  const std::string same = error.same_px == 0
                               ? ""
                               : fmt::format(
                                     ", about {:+.1f} px at all depths, as if not the sensor but "
                                     "the right camera of the pair were turned",
                                     error.same_px);
  return fmt::format(
      "depths of the range sensor are off by {}{}; {}. If that stays so: sprout-calibrate refine",
      knots, same, moved);
}

}  // namespace sprout::refine
