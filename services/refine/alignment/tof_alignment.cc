#include "services/refine/alignment/tof_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "common/core/image.h"
#include "common/core/parallel.h"

namespace sprout::refine {
namespace {

using Rules = AlignmentRules;

// A place, mirrored in the pair: what stands in `here` is looked for in `there`.
struct View {
  const cv::Mat1b& here;
  const cv::Mat1b& there;
  double to_there;  // times the disparity: from a column of the one to one of the other
  double u, v;      // of the edge
};

// How badly a row at a column fits a grey value: 0 to 1; one half where the row ends.
inline float Misfit(const uint8_t* row, float last_column, float column, float grey) {
  if (!(column >= 0 && column < last_column)) return 0.5F;
  const int whole = static_cast<int>(column);
  const float part = column - static_cast<float>(whole);
  const auto at = static_cast<float>(row[whole]);
  const float there = at + part * (static_cast<float>(row[whole + 1]) - at);
  return std::min(std::abs(there - grey) / Rules::kMaxMisfit, 1.0F);
}

// Calls look(u, v) for the pixels at a place of the normal, along the tangent.
template <typename Look>
void ForEachPixel(const View& view, const Eigen::Vector2d& normal, int place, const Look& look) {
  const double u = view.u + place * normal.x();
  const double v = view.v + place * normal.y();
  for (int w = -Rules::kTangentReach; w <= Rules::kTangentReach; ++w) {
    look(cvRound(u - w * normal.y()), cvRound(v + w * normal.x()));
  }
}

// Running sums for the edge's profile: `preference` for the near surface, eq. (A3), and grey.
struct Sums {
  std::vector<float> preference;
  std::vector<float> grey;
};

void AddUp(std::vector<float>& values) {
  float sum = 0;
  for (float& value : values) {
    sum += value / (2 * Rules::kTangentReach + 1);
    value = sum;
  }
}

// The edge in an image `scale` times smaller; pixel centres are whole numbers.
TofEdge AtScale(TofEdge edge, double scale) {
  const auto half = Eigen::Vector2d::Constant(0.5);
  edge.left = (edge.left + half) / scale - half;
  edge.near_px /= scale;
  edge.far_px /= scale;
  return edge;
}

double CellPx(const Rig& rig) { return rig.pair.focal_px / std::min(rig.tof.fx, rig.tof.fy); }

// What an edge's place depends on: the offset, and how far all edges seem to lie outwards.
Eigen::Vector3d RowOf(const TofEdge& edge) { return {edge.motion.x(), edge.motion.y(), 1}; }

// Sums along an edge's normal, for places of up to `middle` px on either side of it.
void SumAlong(const View& view, const View& in_left, const TofEdge& edge, int middle,
              double plane_px, Sums& sums) {
  const int samples = 2 * middle + 1;
  const cv::Rect image({}, view.here.size());
  const cv::Mat1b& left = in_left.here;
  const auto last_column = static_cast<float>(image.width - 1);
  sums.preference.assign(static_cast<size_t>(samples) + 1, 0);
  sums.grey.assign(static_cast<size_t>(samples) + 1, 0);
  for (int i = 0; i < samples; ++i) {
    const int place = i - middle;
    const double on_plane = std::clamp<double>(place, -plane_px, plane_px);
    const double to_near = view.to_there * (edge.near_px + edge.near_slope * on_plane);
    const double to_far = view.to_there * (edge.far_px + edge.far_slope * on_plane);
    float preference = 0;
    ForEachPixel(view, edge.normal, place, [&](int u, int v) {
      if (!image.contains({u, v})) return;
      const float grey = view.here(v, u);
      const uint8_t* row = view.there[v];
      preference += Misfit(row, last_column, static_cast<float>(u + to_far), grey) -
                    Misfit(row, last_column, static_cast<float>(u + to_near), grey);
    });
    float grey = 0;
    ForEachPixel(in_left, edge.normal, place, [&](int u, int v) {
      grey += left(std::clamp(v, 0, left.rows - 1), std::clamp(u, 0, left.cols - 1));
    });
    sums.preference[static_cast<size_t>(i) + 1] = preference;
    sums.grey[static_cast<size_t>(i) + 1] = grey;
  }
  AddUp(sums.preference);
  AddUp(sums.grey);
}

// Eq. (A4) at each place of a profile.
void WriteProfile(const Sums& sums, int window, std::span<float> profile) {
  for (size_t t = 0; t < profile.size(); ++t) {
    // The pixel at the place itself speaks for neither side.
    const size_t first = t;
    const size_t place = t + static_cast<size_t>(window);
    const size_t end = place + 1 + static_cast<size_t>(window);
    const auto inside_less_outside = [&](const std::vector<float>& sum) {
      return (sum[place] - sum[first] - sum[end] + sum[place + 1]) / static_cast<float>(window);
    };
    const float contrast = std::min(std::abs(inside_less_outside(sums.grey)), Rules::kMaxContrast) /
                           Rules::kMaxContrast;
    profile[t] = inside_less_outside(sums.preference) / 2 + Rules::kContrastWeight * contrast;
  }
}

}  // namespace

double EdgeProfiles::Between(size_t k, double place) const {
  if (!(std::abs(place) <= reach_)) return 0;
  const double whole = std::floor(place);
  const double part = place - whole;
  const int at = static_cast<int>(whole);
  return (1 - part) * double{Value(k, at)} + part * double{Value(k, at + 1)};
}

void EdgeProfiles::Set(const cv::Mat1b& left, const cv::Mat1b& right,
                       std::span<const TofEdge> edges, const ProfileSizes& sizes) {
  reach_ = sizes.reach;
  places_ = static_cast<size_t>(2 * reach_ + 1);
  profiles_.resize(edges.size() * places_);
  const auto count = static_cast<int>(edges.size());
  ForRangesParallel(count, count, [&](const cv::Range& part) {
    Sums sums;
    for (int k = part.start; k < part.end; ++k) {
      const auto index = static_cast<size_t>(k);
      const TofEdge& edge = edges[index];
      const View in_left{left, right, -1, edge.left.x(), edge.left.y()};
      const View in_right{right, left, 1, edge.left.x() - edge.near_px, edge.left.y()};
      // The image in which the far surface beside the edge is seen by the other camera, too.
      const View& view = edge.normal.x() >= 0 ? in_left : in_right;
      SumAlong(view, in_left, edge, reach_ + sizes.window, sizes.plane_px, sums);
      WriteProfile(sums, sizes.window, std::span(profiles_).subspan(index * places_, places_));
    }
  });
}

// The sum of all profiles for whole offsets, px.
struct TofAligner::Votes {
  Eigen::Vector2d best{0, 0};
  double doubt = 1;  // how far the best sum elsewhere exceeds the mean, by how far this one does
};

// Where the sum of all profiles, eq. (A5), is largest.
struct TofAligner::Fit {
  Eigen::Vector3d place{0, 0, 0};  // offset and outwards shift, px
  Eigen::Matrix3d inverse;         // of the negative second derivatives
  Eigen::Matrix2d covariance;      // of the offset, px²
  bool is_peak = false;
  int edges = 0;
};

TofAligner::Votes TofAligner::Vote(int most_px, double cell_px) const {
  // Profiles are as wide as a ToF pixel.
  const int step_px = std::max(1, cvRound(cell_px / Rules::kVotesPerCell));
  const int most = (most_px + step_px - 1) / step_px;
  const int side = 2 * most + 1;
  cv::Mat1d sums(side, side);
  ForEachParallel(static_cast<size_t>(side), [&](size_t row) {
    const int dv = (static_cast<int>(row) - most) * step_px;
    for (int i = 0; i < side; ++i) {
      const int du = (i - most) * step_px;
      double sum = 0;
      for (size_t k = 0; k < edges_.size(); ++k) {
        const Eigen::Vector2d& motion = edges_[k].motion;
        sum += double{profiles_.At(k, motion.x() * du + motion.y() * dv)};
      }
      sums(static_cast<int>(row), i) = sum;
    }
  });
  cv::Point best;
  double best_sum = 0;
  cv::minMaxLoc(sums, nullptr, &best_sum, nullptr, &best);
  double elsewhere = 0;
  double mean = 0;
  const double distance = Rules::kElsewhereCells * cell_px / step_px;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      mean += sums(y, x) / static_cast<double>(sums.total());
      const cv::Point off = cv::Point(x, y) - best;
      if (off.dot(off) > distance * distance) elsewhere = std::max(elsewhere, sums(y, x));
    }
  }
  return {.best = Eigen::Vector2d(best.x - most, best.y - most) * step_px,
          .doubt = best_sum > mean ? (elsewhere - mean) / (best_sum - mean) : 1};
}

// Newton's method, with differences over `step_px` for derivatives: the profiles are sums over
// windows, so they are smooth over such a step.
TofAligner::Fit TofAligner::Maximise(Eigen::Vector2d start, double step_px) const {
  Fit fit;
  fit.place.head<2>() = start;
  for (int i = 0; i < Rules::kMaxSteps; ++i) {
    Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < edges_.size(); ++k) {
      const Eigen::Vector3d row = RowOf(edges_[k]);
      const double place = row.dot(fit.place);
      const double before = profiles_.Between(k, place - step_px);
      const double here = profiles_.Between(k, place);
      const double behind = profiles_.Between(k, place + step_px);
      slope += (behind - before) / (2 * step_px) * row;
      curvature += (2 * here - before - behind) / (step_px * step_px) * row * row.transpose();
    }
    const Eigen::LLT<Eigen::Matrix3d> solver(curvature);
    fit.is_peak = solver.info() == Eigen::Success;
    if (!fit.is_peak) return fit;
    fit.inverse = curvature.inverse();
    const Eigen::Vector3d step = solver.solve(slope);
    const double length = std::sqrt(step.squaredNorm());
    fit.place += length > step_px ? Eigen::Vector3d(step * (step_px / length)) : step;
    if (!fit.place.allFinite() || length < Rules::kConvergedPx) break;
  }
  fit.is_peak = fit.place.allFinite();
  return fit;
}

// Eq. (A6).
void TofAligner::FindErrors(double step_px, double cell_px, Fit& fit) const {
  const double block_px = Rules::kBlockCells * cell_px;
  std::map<std::pair<int, int>, Eigen::Vector3d> blocks;
  Eigen::Matrix<double, 3, 4> sides = Eigen::Matrix<double, 3, 4>::Zero();
  for (size_t k = 0; k < edges_.size(); ++k) {
    const TofEdge& edge = edges_[k];
    const Eigen::Vector3d row = RowOf(edge);
    const double place = row.dot(fit.place);
    const double before = profiles_.Between(k, place - step_px);
    const double here = profiles_.Between(k, place);
    const double behind = profiles_.Between(k, place + step_px);
    if (here >= double{Rules::kClearEdge}) ++fit.edges;
    const std::pair block(static_cast<int>(edge.left.x() / block_px),
                          static_cast<int>(edge.left.y() / block_px));
    blocks.try_emplace(block, Eigen::Vector3d::Zero()).first->second +=
        (behind - before) / (2 * step_px) * row;
    const double curvature = (2 * here - before - behind) / (step_px * step_px);
    const Eigen::Vector2d shares = edge.normal.cwiseAbs2();
    sides.col(edge.normal.x() > 0 ? 0 : 1) += curvature * shares.x() * row;
    sides.col(edge.normal.y() > 0 ? 2 : 3) += curvature * shares.y() * row;
  }
  Eigen::Matrix3d middle = Eigen::Matrix3d::Zero();
  for (const auto& [block, sum] : blocks) middle += sum * sum.transpose();
  const double usual_px = Rules::kSideSigmaCells * cell_px;
  const double outwards_px = Rules::kSideSigmaOutwards * fit.place.z();
  middle += (usual_px * usual_px + outwards_px * outwards_px) * sides * sides.transpose();
  fit.covariance = (fit.inverse * middle * fit.inverse).topLeftCorner<2, 2>();
}

TofOffset TofAligner::Estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                               std::span<const ProjectedPoint> points, const TofImage& tof,
                               const TofProjector& projector) {
  cv::Mat1b small_left = left;
  cv::Mat1b small_right = right;
  int scale = 1;
  const double full_cell_px = CellPx(projector.rig());
  while (full_cell_px / scale > Rules::kMaxCellPx &&
         std::min(small_left.cols, small_left.rows) >= 2 * Rules::kMinSide) {
    small_left = Halved(small_left);
    small_right = Halved(small_right);
    scale *= 2;
  }
  const double cell_px = std::clamp(full_cell_px / scale, 1.0, Rules::kLimitCellPx);
  const std::span<const TofEdge> found =
      finder_.Find(points, tof, projector, Rules::kMinStepPx * scale);
  const size_t count = std::min(found.size(), Rules::kMaxEdges);
  if (count < Rules::kMinEdges) return {};
  edges_.clear();
  for (size_t i = 0; i < count; ++i) {
    edges_.push_back(AtScale(found[i * found.size() / count], scale));
  }
  const int most_px = static_cast<int>(std::ceil(Rules::kMaxCells * cell_px));
  // An edge moves by up to √2 times as much along its normal, and may be found a pixel farther.
  profiles_.Set(small_left, small_right, edges_,
                {.reach = static_cast<int>(std::ceil(1.5 * most_px + cell_px)),
                 .window = std::max(3, cvRound(cell_px)),
                 .plane_px = Rules::kMaxCells * cell_px});
  const Votes votes = Vote(most_px, cell_px);
  const double step_px = std::max(1.0, Rules::kStepCells * cell_px);
  Fit fit = Maximise(votes.best, step_px);
  if (!fit.is_peak) return {};
  FindErrors(step_px, cell_px, fit);

  const Eigen::Vector2d offset = fit.place.head<2>();
  TofOffset result{.du_px = offset.x() * scale,
                   .dv_px = offset.y() * scale,
                   .sigma_u_px = std::sqrt(fit.covariance(0, 0)) * scale,
                   .sigma_v_px = std::sqrt(fit.covariance(1, 1)) * scale,
                   .significance = std::sqrt(offset.dot(fit.covariance.inverse() * offset)),
                   .edges = fit.edges};
  if (!std::isfinite(result.significance)) return {};
  const double most_sigma_px = Rules::kMaxSigmaCells * cell_px * scale;
  result.sure = fit.edges >= Rules::kMinEdges && votes.doubt <= Rules::kMaxDoubt &&
                (offset - votes.best).squaredNorm() <= cell_px * cell_px &&
                result.sigma_u_px <= most_sigma_px && result.sigma_v_px <= most_sigma_px;
  return result;
}

void ApplyOffset(const TofOffset& offset, const Rig& rig, std::vector<ProjectedPoint>& points) {
  // Half angles. Cosines that differ between machines are left out: the quaternion has its length.
  const double half = 0.5 / rig.pair.focal_px;
  const Eigen::Matrix3d turn = Eigen::Quaterniond(1, -offset.dv_px * half, offset.du_px * half, 0)
                                   .normalized()
                                   .toRotationMatrix();
  const Eigen::Vector3d& place = rig.tof.left_from_tof_translation_m;
  for (ProjectedPoint& point : points) {
    const Eigen::Vector3d turned = place + turn * (PointFromSeed(rig.pair, point.seed) - place);
    if (!(turned.z() > 0)) continue;
    const Seed seed = ProjectToPair(rig.pair, turned);
    point.seed.u = seed.u;
    point.seed.v = seed.v;
    point.seed.u_right = seed.u_right;
  }
}

}  // namespace sprout::refine
