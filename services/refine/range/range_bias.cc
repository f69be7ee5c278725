#include "services/refine/range/range_bias.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "services/refine/range/pair_fit.h"
#include "services/refine/range/range_costs.h"
#include "services/refine/range/row_shift.h"
#include "services/refine/stereo/point_surface.h"

namespace sprout::refine {
namespace {

// What became of a point.
constexpr uint8_t kMoved = 1;
constexpr uint8_t kMovedFar = 2;
constexpr uint8_t kFarFromCurve = 4;
constexpr int kMaxReach = 8;  // of the windows around a point, cells
constexpr int kReaches[] = {1, 2, 4, kMaxReach};

// An error of a depth as an error of its disparity, px.
double ErrorPx(const RectifiedPair& pair, double depth_m, double error_m) {
  return pair.focal_px * pair.baseline_m / (depth_m * depth_m) * error_m;
}

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

// Compares the images again at the moved nodes as long as some are far off: costs cover a few px to
// either side only, on the slant as measured. Returns whether it did.
bool RangeBias::CompareAgain(const RangeInput& input) {
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

// How far each node is off, by curve and field together, px.
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
  return judged < RangeRules::kMinNodes ? 0
                                        : static_cast<double>(wrong) / static_cast<double>(judged);
}

// At which share of the nodes that the images contradict they match elsewhere. If at few, they do
// not fit each other, as where one is out of focus or a few rows off.
double RangeBias::MatchedElsewhere(const RangeInput& input, std::span<const Seed> matches) const {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const CellGrid grid(std::max(1.0, RangeRules::kMatchReach * input.left.cols), input.left.size());
  cv::Mat1f matched(grid.size, kNone);
  const double noise = RangeRules::kUnlikeVariance + nodes_.noise();
  for (const Seed& match : matches) {
    if (IsAlike(input.left, input.right, match, noise)) {
      matched(grid.At(match.v), grid.At(match.u)) = match.disparity();
    }
  }
  size_t contradicted = 0, elsewhere = 0;
  for (size_t i = 0; i < unlike_nodes_.size(); ++i) {
    if (unlike_nodes_[i] == 0) continue;
    const RangeNode& node = nodes_.nodes()[i];
    ++contradicted;
    const float disparity = matched(grid.At(node.at.y), grid.At(node.at.x));
    elsewhere += std::abs(disparity - node.disparity) > RangeRules::kElsewherePx;
  }
  return contradicted == 0 ? 0 : static_cast<double>(elsewhere) / static_cast<double>(contradicted);
}

// Whether the curve moves nodes farther than columns of the pair may be off.
bool RangeBias::CurveIsBeyond(const RectifiedPair& pair, double columns_px) const {
  if (columns_px == 0) return true;
  std::vector<double> moves_px;
  for (const RangeNode& node : nodes_.nodes()) {
    moves_px.push_back(std::abs(curve_.OffsetPx(pair, node.disparity)));
  }
  return Median(moves_px) > RangeRules::kBeyondColumns * columns_px;
}

// Whether nothing can be estimated, since too much is wrong with the points or with the pair. Right
// frames do not take the time.
bool RangeBias::JudgePair(const RangeInput& input, const RangeSettings& settings,
                          std::span<const ProjectedPoint> points) {
  const bool many = error_.contradicted_share > RangeRules::kRejectedShare;
  const bool doubtful = !curve_.is_zero() || field_.variance_px2() > 0 ||
                        error_.contradicted_share > RangeRules::kDoubtfulShare;
  const PairFit fit = doubtful ? PairFitAt(input, nodes_) : PairFit{};
  const bool uneven = fit.uneven_gain > RangeRules::kUnevenGain;
  // Where most nodes are contradicted they may also fit other rows by chance.
  const bool on_other_rows =
      (uneven || fit.rows_gain > RangeRules::kRowsGain) &&
      !(many && MatchedElsewhere(input, settings.matches()) > RangeRules::kMatchedOnOwnRows);
  error_.columns_px = on_other_rows && uneven ? fit.most_rows_px : 0;
  error_.rows_unfit = on_other_rows && !many && CurveIsBeyond(input.rig.pair, error_.columns_px);
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
    error_.pair_unfit =
        error_.rows_shifted ||
        MatchedElsewhere(input, matches) <= RangeRules::MatchedShare(error_.contradicted_share);
  }
  error_.rejected = many && !error_.pair_unfit;
  if (error_.IsUnknown()) error_.curve.clear();
  return error_.rejected || error_.IsUnknown();
}

// Marks where points have to be asked for: within reach of a node that moves, is unsure or is
// contradicted. With a sensor that is right there is none.
bool RangeBias::MarkAffected() {
  const bool all = field_.variance_px2() > 0;
  affected_.create(nodes_.size());
  affected_ = all ? 1 : 0;
  if (all) return true;
  bool any = false;
  for (size_t i = 0; i < wrong_nodes_.size(); ++i) {
    if (wrong_nodes_[i] == 0 && field_.offsets()[i].offset_px == 0) continue;
    affected_(nodes_.nodes()[i].cell) = 1;
    any = true;
  }
  constexpr int kSide = 2 * kMaxReach + 1;
  if (any) cv::dilate(affected_, affected_, cv::Mat1b::ones(kSide, kSide));
  return any;
}

// The error of a point by the nodes of its surface, in a window that widens until there is one.
RangeBias::PointError RangeBias::ErrorOf(const TofSurface& surface,
                                         const ProjectedPoint& point) const {
  const double disparity = point.seed.disparity();
  const cv::Point2d at(point.seed.u, point.seed.v);
  const cv::Point2d cell = nodes_.CellOf(surface, point);
  const cv::Point nearest(static_cast<int>(std::lround(cell.x)),
                          static_cast<int>(std::lround(cell.y)));
  if (cv::Rect({}, affected_.size()).contains(nearest) && affected_(nearest) == 0) return {};
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

// Estimates the error that all points share; it has no knots if few nodes show anything.
void RangeBias::FindCurve(const RangeInput& input, double error_m) {
  const RectifiedPair& pair = input.rig.pair;
  curve_.Estimate(nodes_.nodes(), pair, /*stiff=*/input.coarse || !input.surface.has_pixels());
  curve_.BoundSigmas(error_m);
  error_.curve_is_zero = curve_.is_zero();
  for (const RangeKnot& knot : curve_.knots()) {
    const double shared_m = RangeRules::kCurveSharedPx / ErrorPx(pair, knot.depth_m, 1);
    error_.curve.push_back({.depth_m = knot.depth_m,
                            .error_m = knot.error_m,
                            .sigma_m = std::hypot(knot.sigma_m, shared_m)});
    const double least_m = std::abs(knot.error_m) - RangeRules::kSureSigmas * knot.sigma_m;
    const bool is_absurd = least_m > RangeRules::kMaxDepthShare * knot.depth_m;
    if (is_absurd && !error_.absurd) error_.absurd = knot;
  }
}

// What the scene adds, and which points the images contradict. Returns false where that ends the
// estimate: nothing is to be moved.
bool RangeBias::FindField(const RangeInput& input, const RangeSettings& settings,
                          std::span<const ProjectedPoint> points) {
  const RectifiedPair& pair = input.rig.pair;
  const std::span<const RangeNode> nodes = nodes_.nodes();
  nodes_.Link();
  start_px_.clear();
  for (const RangeNode& node : nodes) start_px_.push_back(curve_.OffsetPx(pair, node.disparity));
  // Between a lidar's beams, and where nodes are few, slopes are not known well enough.
  const bool has_slopes =
      !input.coarse || (input.surface.has_pixels() && nodes.size() >= RangeRules::kMinFieldNodes);
  const double least_share = settings.has_wrong_edges ? 0 : RangeRules::kMovedShare;
  field_.Estimate(nodes_, start_px_, settings.field && has_slopes ? least_share : 1);
  error_.contradicted_share = JudgeNodes();
  if (!settings.field) return true;
  if (JudgePair(input, settings, points)) {
    if (error_.rejected) contradicted_.assign(points.size(), 1);
    return false;
  }
  if (error_.rows_unfit) return true;
  // The share stays that of the first look: a wide search finds alike windows for wrong points.
  if (CompareAgain(input)) JudgeNodes();
  if (!ShiftsRows(nodes_, NodeMoves(), pair.cx - pair.cx_right)) return true;
  error_.pair_unfit = error_.rows_shifted = true;
  error_.curve.clear();
  return false;
}

// Moves the points by what was found, and sets what may be left of their errors.
void RangeBias::MovePoints(const RangeInput& input, const RangeSettings& settings,
                           std::span<ProjectedPoint> points) {
  const RectifiedPair& pair = input.rig.pair;
  // Few points can hardly show that their sensor is off; so they have to show that it is not.
  const bool is_right =
      curve_.is_zero() &&
      (!input.coarse || curve_.IsShownRight(nodes_.nodes(), pair, settings.error_m));
  const bool has_field = settings.field && !error_.rows_unfit && MarkAffected();
  const Eigen::Vector3d centre = input.rig.tof.left_from_tof_translation_m;
  moved_.assign(points.size(), 0);
  ForEachParallel(points.size(), [&](size_t i) {
    ProjectedPoint& point = points[i];
    const double disparity = point.seed.disparity();
    const PointError error = has_field ? ErrorOf(input.surface, point) : PointError();
    const double move_px = curve_.OffsetPx(pair, disparity) + error.offset_px;
    const double curve_sigma_px =
        is_right ? 0
                 : std::min(curve_.SigmaPx(pair, disparity),
                            ErrorPx(pair, pair.DepthFromDisparity(disparity), settings.error_m));
    contradicted_[i] = error.contradicted ? 1 : 0;
    point.seed.sigma_px =
        static_cast<float>(std::hypot(std::sqrt(error.variance_px2), curve_sigma_px));
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
  error_.moved_share = share_of(kMoved);
  error_.far_moved_share = share_of(kMovedFar);
  error_.far_from_curve_share = share_of(kFarFromCurve);
}

const RangeError& RangeBias::Apply(const RangeInput& input, const RangeSettings& settings,
                                   std::span<ProjectedPoint> points) {
  const RectifiedPair& pair = input.rig.pair;
  error_ = {};
  contradicted_.assign(points.size(), 0);
  nodes_.Set(input, points);
  FindCurve(input, settings.error_m);
  if (error_.curve.empty()) {  // only the data sheet is known
    for (ProjectedPoint& point : points) {
      const double depth_m = pair.DepthFromDisparity(point.seed.disparity());
      point.seed.sigma_px = static_cast<float>(ErrorPx(pair, depth_m, settings.error_m));
    }
    return error_;
  }
  if (error_.absurd) curve_ = {};  // a pair that fits nowhere has such curves by chance
  const bool moves = FindField(input, settings, points);
  if (error_.absurd && error_.pair_unfit) {
    error_.absurd.reset();
    error_.rows_unfit = false;
    error_.curve.clear();
    return error_;
  }
  if (error_.absurd) contradicted_.assign(points.size(), 1);
  if (error_.absurd || !moves) return error_;
  MovePoints(input, settings, points);
  if (!curve_.is_zero()) error_.same_px = SamePx(pair, error_.curve);
  return error_;
}

}  // namespace sprout::refine
